"""Two roots, or none, where floats see a double one: decided in balls, for the numbers as they are.

Near a fold the bordered system F(x) + μ u = 0, v·(x − x₀) = t is regular, so that Krawczyk's operator proves
one curve x(t) with one μ(t) for all t of an interval at once (Lyapunov–Schmidt reduction; W. Govaerts,
*Numerical Methods for Bifurcations of Dynamical Equilibria*, 2000, chapter 3). F = 0 on it where μ = 0. If μ″
has one sign there, μ is convex or concave: with its value and slope at one point next to its extreme, and its
values at the ends, that proves that it has two zeros, or none. The slopes of the rules must be continuous
along it: of a kink, where they jump, second derivatives know nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

from rulesheets.evaluate import NotDifferentiable, Undefined, differentiate
from rulesheets.evaluate.balls import Ball, around, ball, continuous, enclosing_ball, jumps, solved
from rulesheets.syntax.nodes import Expression, Name, Number, add, is_number, multiply, subtract
from solver.kernel.balls.krawczyk import Square, only_root, proved_root

MU, PLACE = "#mu", "#t"
"""Names that no sheet can have."""
MOST_UNKNOWNS = 8
"""Of a block whose second derivatives are worth forming."""
REACHES = tuple(10.0**-k for k in range(2, 9))
"""Shares of the size of the unknowns along which the curve is tried, the longest first."""
HIGH = 1e3
"""How much farther than it goes along the curve μ is looked for."""
STEPS = 8
"""Newton steps towards the extreme of μ."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """The only ``curve`` in a ``box``, x and μ by name, for all t within ``reach`` of a place."""

    place: Ball
    reach: float
    curve: Mapping[str, Ball]
    box: Mapping[str, Ball]

    def holds(self, point: Mapping[str, Ball]) -> bool:
        """Whether a point is in the box: if it is one for some t of these, it is on the curve."""
        return all(self.box[name].contains(number) for name, number in point.items())


def unfolded(
    square: Square, known: Mapping[str, Ball], middle: Sequence[Ball]
) -> tuple[Mapping[str, Ball], ...] | None:
    """The roots next to the double one that floats see at ``middle``: two, each enclosed, or none.

    None: no proof.
    """
    if len(square.unknowns) > MOST_UNKNOWNS:
        return None
    try:
        return _Curve(square, known, middle).unfolded()
    except (Undefined, NotDifferentiable, OverflowError, ZeroDivisionError):
        return None


class _Curve:
    """x(t) and μ(t), through ``middle`` at t = 0."""

    def __init__(self, square: Square, known: Mapping[str, Ball], middle: Sequence[Ball]) -> None:
        self.square, self.known, self.middle = square, known, [m.mid() for m in middle]
        self.n = len(square.unknowns)
        self.across, self.along = self._null_vectors()
        self.bordered = self._bordered()
        self.second = [self._curved(place) for place in range(self.n)]
        self.kinks = jumps(square.partials, square.unknowns)

    def unfolded(self) -> tuple[Mapping[str, Ball], ...] | None:
        """Raises Undefined, and ZeroDivisionError where a matrix can't be proved regular."""
        place, point = self._extreme()
        height, tangent = point[MU], self._slopes(point)
        for reach in REACHES:
            stretch = self._stretch(place, reach, point)
            if stretch is None or not continuous(self.kinks, {**self.known, **stretch.box}):
                continue
            bend = self._bend(stretch.curve)
            if bend.contains(0):
                continue
            slope = tangent[self.n]
            extreme = height - slope * slope / (2 * bend)  # μ is no lower where it is convex
            if not _opposite(extreme, bend) and not extreme.contains(0):
                return ()
            ends = [self._at(place + side * ball(reach), list(point.values())) for side in (-1, 1)]
            if all(end and stretch.holds(end) and _opposite(end[MU], height) for end in ends):
                return self._two(stretch, point, tangent, (-2 * height / bend).mid())
        return None

    def _stretch(self, place: Ball, reach: float, point: Mapping[str, Ball]) -> Stretch | None:
        """The curve around a point of it.

        μ = 0 is in the box that is searched for others, so that F = 0 takes place on the curve alone.
        """
        middle = [number.mid() for number in point.values()]
        thin = self._at(around(place, reach), middle)
        if thin is None:
            return None
        radii = [
            3 * (float((thin[name] - m).abs_upper()) + reach * abs(float(m)))
            for name, m in zip(self.square.unknowns, middle, strict=False)
        ]
        high = HIGH * float(thin[MU].abs_upper() + point[MU].abs_upper())  # the system is linear in μ
        known = {**self.known, PLACE: around(place, reach)}
        found = only_root(self.bordered, known, middle, [*radii, high])
        if found is None:
            return None
        curve, radii = found
        box = {n: around(m, r) for n, m, r in zip(self.bordered.unknowns, middle, radii, strict=True)}
        return Stretch(place, reach, curve, box)

    def _two(
        self, stretch: Stretch, point: Mapping[str, Ball], tangent: Sequence[Ball], square: Ball
    ) -> tuple[Mapping[str, Ball], ...] | None:
        """Both roots, at the ``square`` of their distance from the extreme, each enclosed."""
        apart = square.sqrt().mid()
        roots = []
        for side in (-1, 1):
            near = [
                (point[name] + side * apart * slope).mid()
                for name, slope in zip(self.square.unknowns, tangent, strict=False)
            ]
            root = proved_root(self.square, self.known, near)
            if root is None or not self._along(root, stretch):
                return None
            roots.append(root)
        one, other = roots
        return (one, other) if any(not one[name].overlaps(other[name]) for name in one) else None

    def _along(self, root: Mapping[str, Ball], stretch: Stretch) -> bool:
        """Whether a root is one of the zeros of μ along the stretch, and not one from elsewhere."""
        along = self.bordered.forms[-1]
        t = enclosing_ball(along, {**self.known, **root, PLACE: ball(0)})
        return stretch.holds(root) and bool(abs(t - stretch.place) <= stretch.reach)

    def _extreme(self) -> tuple[Ball, dict[str, Ball]]:
        """Next to where μ′ vanishes: the place t, a number, and x and μ there."""
        place, start = ball(0), [*self.middle, ball(0)]
        point = self._certain(place, start)
        for _ in range(STEPS):
            step = (self._slopes(point)[self.n] / self._bend(point)).mid()
            place = (place - step).mid()
            point = self._certain(place, [number.mid() for number in point.values()])
        return place, point

    def _certain(self, place: Ball, start: Sequence[Ball]) -> dict[str, Ball]:
        point = self._at(place, start)
        if point is None:
            raise ZeroDivisionError
        return point

    def _at(self, place: Ball, start: Sequence[Ball]) -> dict[str, Ball] | None:
        """x and μ for every t of a ball, proved to be the only ones near ``start``."""
        return proved_root(self.bordered, {**self.known, PLACE: place}, [s.mid() for s in start])

    def _slopes(self, point: Mapping[str, Ball]) -> list[Ball]:
        """x′ (n,) and μ′ wherever the ``point`` may be."""
        return solved(self._matrix(point), [*([ball(0)] * self.n), ball(1)])

    def _bend(self, point: Mapping[str, Ball]) -> Ball:
        """μ″: by the chain rule J x″ + μ″ u = −F″(x′, x′), with v·x″ = 0."""
        tangent, at = self._slopes(point), {**self.known, **point}
        curved = []
        for row in self.second:
            total = ball(0)
            for (j, k), partial in row.items():
                total += enclosing_ball(partial, at, derivative=True) * tangent[j] * tangent[k]
            curved.append(-total)
        return solved(self._matrix(point), [*curved, ball(0)])[self.n]

    def _matrix(self, point: Mapping[str, Ball]) -> list[list[Ball]]:
        at, size = {**self.known, **point}, self.n + 1
        flat = [enclosing_ball(partial, at, derivative=True) for partial in self.bordered.partials]
        return [flat[i : i + size] for i in range(0, size * size, size)]

    def _null_vectors(self) -> tuple[list[float], list[float]]:
        """u and v, the latter with t in units of the largest unknown's size."""
        from solver.numerics.linear_algebra import null_direction

        at = {**self.known, **dict(zip(self.square.unknowns, self.middle, strict=True))}
        flat = [float(enclosing_ball(partial, at, derivative=True).mid()) for partial in self.square.partials]
        rows = [flat[i : i + self.n] for i in range(0, self.n * self.n, self.n)]
        numbers = [float(m) for m in self.middle]
        direction = null_direction(rows, numbers)
        length = sum(d * d for d in direction) * (max(map(abs, numbers)) or 1.0)
        across = null_direction(list(zip(*rows, strict=True)), [1.0] * self.n)
        return list(across), [d / length for d in direction]

    def _bordered(self) -> Square:
        mu, unknowns = Name(MU), self.square.unknowns
        forms = [
            add(form, multiply(Number(u), mu)) for form, u in zip(self.square.forms, self.across, strict=True)
        ]
        offsets = [
            multiply(Number(v), subtract(Name(name), Number(float(m))))
            for name, v, m in zip(unknowns, self.along, self.middle, strict=True)
        ]
        forms.append(subtract(add(*offsets), Name(PLACE)))
        everything = (*unknowns, MU)
        return Square(forms, [differentiate(form, name) for form in forms for name in everything], everything)

    def _curved(self, place: int) -> dict[tuple[int, int], Expression]:
        """The second derivatives of a form by pairs of unknowns, mixed ones doubled."""
        found = {}
        for j, k in combinations_with_replacement(range(self.n), 2):
            partial = differentiate(self.square.partials[place * self.n + j], self.square.unknowns[k])
            if not is_number(partial, 0.0):
                found[j, k] = partial if j == k else multiply(Number(2.0), partial)
        return found


def _opposite(one: Ball, other: Ball) -> bool:
    return bool((one > 0 and other < 0) or (one < 0 and other > 0))
