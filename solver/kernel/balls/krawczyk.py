"""Existence and uniqueness of a root of a square system near a point, proved.

If K(X) = m − Y F(m) + (I − Y F'(X)) (X − m) lies in the interior of X, then F has exactly one root in X,
whatever the known numbers are within their balls (R. Krawczyk, Computing 4 (1969) 187–201; A. Neumaier,
*Interval Methods for Systems of Equations*, 1990, section 5.1). F must be continuous in X: where a function
jumps there, nothing is proved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.balls import Ball, around, ball, continuous, enclosing_ball, jumps, preconditioned
from rulesheets.syntax.nodes import Expression

INFLATIONS = 24
TIGHTENINGS = 12
WIDENINGS = 6
TIGHT = 2.0**-110
"""Relative radius that no float can tell from 0."""


class Square:
    """F = 0 for as many ``forms`` as ``unknowns``; ``partials`` are ∂F_i/∂x_j row by row."""

    def __init__(
        self, forms: Sequence[Expression], partials: Sequence[Expression], unknowns: Sequence[str]
    ) -> None:
        self.forms, self.partials, self.unknowns = forms, partials, unknowns


def proved_root(square: Square, known: Mapping[str, Ball], middle: Sequence[Ball]) -> dict[str, Ball] | None:
    """Balls around ``middle`` with exactly one root, for any ``known`` numbers in theirs; None: no proof."""
    try:
        return _Proof(square, known).near(list(middle))
    except (Undefined, OverflowError):
        return None


def only_root(
    square: Square, known: Mapping[str, Ball], middle: Sequence[Ball], radii: Sequence[float]
) -> tuple[dict[str, Ball], list[float]] | None:
    """Balls that hold the root, for any ``known`` numbers in theirs, and the radii around ``middle`` within
    which it is the only one, for each of these: the given ones or larger; None: no proof."""
    try:
        return _Proof(square, known).only(list(middle), list(radii))
    except (Undefined, OverflowError):
        return None


class _Proof:
    def __init__(self, square: Square, known: Mapping[str, Ball]) -> None:
        self.square, self.known = square, known
        self.jumps = jumps(square.forms, square.unknowns)

    def near(self, middle: list[Ball]) -> dict[str, Ball] | None:
        """Inflate until the image lies inside; then tighten."""
        size = max(float(m.abs_upper()) for m in middle) or 1.0
        least = [max(float(m.abs_upper()), 1e-30 * size) * 2.0**-200 for m in middle]
        radii = least
        for _ in range(INFLATIONS):
            expect_time()
            box, image = self._tried(middle, radii)
            if image is None:
                return None
            if _inside(image, box):
                found = self._exact(middle, box) or self._tightened(image)
                return dict(zip(self.square.unknowns, found, strict=True))
            radii = [1.5 * far + tiny for far, tiny in zip(_reach(image, middle), least, strict=True)]
        return None

    def only(self, middle: list[Ball], radii: list[float]) -> tuple[dict[str, Ball], list[float]] | None:
        for _ in range(WIDENINGS):
            expect_time()
            box, image = self._tried(middle, radii)
            if image is None:
                return None
            if _inside(image, box):
                return dict(zip(self.square.unknowns, self._tightened(image), strict=True)), radii
            radii = [max(radius, 1.5 * far) for radius, far in zip(radii, _reach(image, middle), strict=True)]
        return None

    def _tried(self, middle: list[Ball], radii: list[float]) -> tuple[list[Ball], list[Ball] | None]:
        """A box around the middle, and its image."""
        box = [around(m, r) for m, r in zip(middle, radii, strict=True)]
        return box, self._image(middle, box)

    def _exact(self, middle: list[Ball], box: list[Ball]) -> list[Ball] | None:
        """The numbers of the root, where they are short: the middle, or floats, that satisfy F = 0 exactly.

        The box has exactly one root, so that it is this one, for any known numbers.
        """
        for point in (middle, [ball(float(m)) for m in middle]):
            inside = all(x.contains(p) for x, p in zip(box, point, strict=True))
            if inside and all(r.is_exact() and r.is_zero() for r in self._residual(point)):
                return point
        return None

    def _tightened(self, box: list[Ball]) -> list[Ball]:
        """The image of the image, and so on: each holds the root."""
        for _ in range(TIGHTENINGS):
            expect_time()
            if all(float(x.rad()) <= TIGHT * float(x.abs_upper()) for x in box):
                break
            image = self._image([x.mid() for x in box], box)
            if image is None or not any(k.rad() < 0.5 * x.rad() for k, x in zip(image, box, strict=True)):
                break
            box = [x.intersection(k) for x, k in zip(box, image, strict=True)]
        return box

    def _image(self, middle: Sequence[Ball], box: Sequence[Ball]) -> list[Ball] | None:
        if not continuous(self.jumps, self._at(box)):
            return None
        found = preconditioned(self._jacobian(box), self._jacobian(middle), self._residual(middle))
        if found is None:
            return None
        rest, shift = found
        apart = [x - m for x, m in zip(box, middle, strict=True)]
        return [
            m - s + sum((a * d for a, d in zip(row, apart, strict=True)), ball(0))
            for m, s, row in zip(middle, shift, rest, strict=True)
        ]

    def _at(self, point: Sequence[Ball]) -> dict[str, Ball]:
        return {**self.known, **dict(zip(self.square.unknowns, point, strict=True))}

    def _residual(self, point: Sequence[Ball]) -> list[Ball]:
        return [enclosing_ball(form, self._at(point)) for form in self.square.forms]

    def _jacobian(self, point: Sequence[Ball]) -> list[list[Ball]]:
        n, at = len(self.square.unknowns), self._at(point)
        flat = [enclosing_ball(partial, at, derivative=True) for partial in self.square.partials]
        return [flat[i : i + n] for i in range(0, n * n, n)]


def _inside(image: Sequence[Ball], box: Sequence[Ball]) -> bool:
    return all(x.contains_interior(k) for x, k in zip(box, image, strict=True))


def _reach(image: Sequence[Ball], middle: Sequence[Ball]) -> list[float]:
    """How far from the middle the image goes."""
    return [float((k - m).abs_upper()) for m, k in zip(middle, image, strict=True)]
