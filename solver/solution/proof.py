"""Proofs that each answer exists, and is the only one within its radius.

The rules that an answer was solved with are taken step by step, in the order of the path: the
inputs are exact, each step proves its unknowns for all known numbers within their balls. Conditions
must have the same outcome for all numbers in the balls; the remaining rules must not be
contradicted.

If K(X) = m − Y F(m) + (I − Y F'(X)) (X − m) lies in the interior of X, then F has exactly one root
in X, for all known numbers within their balls (R. Krawczyk, Computing 4 (1969) 187–201; A.
Neumaier, *Interval Methods for Systems of Equations*, 1990, section 5.1). F must be continuous in
X: where a function jumps, nothing is proved. A double root is proved if rational numbers satisfy
the rules with a singular Jacobian.

Two roots, or none, near an apparent double root: near a fold the bordered system F(x) + μ u = 0,
v·(x − x₀) = t is regular, so that Krawczyk's operator proves one curve x(t) with one μ(t) for all t
of an interval at once (Lyapunov–Schmidt reduction; W. Govaerts, *Numerical Methods for Bifurcations
of Dynamical Equilibria*, 2000, chapter 3). F = 0 on it where μ = 0. If μ″ has one sign there, μ is
convex or concave: with its value and slope at one point next to its extreme, and its values at the
ends, that proves that it has two zeros, or none. The slopes of the rules must be continuous along
it: second derivatives do not see a kink.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence, Set
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

from rulesheets.deadline import expect_time
from rulesheets.evaluate import NotDifferentiable, Undefined, differentiate, holds
from rulesheets.evaluate.balls import (
    Ball,
    around,
    ball,
    continuous,
    enclosing_ball,
    exact_ball,
    exact_fraction,
    jumps,
    precision,
    preconditioned,
    solved,
)
from rulesheets.evaluate.exact import Inexact, exactly
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Number, add, multiply, subtract
from rulesheets.syntax.program import walk
from solver.accuracy.rule_sides import symbol_of
from solver.facts import DoubleRoot, Proof, ProvedRoots
from solver.leaves import Leaf
from solver.numerics.elimination import eliminate
from solver.numerics.linear_algebra import null_direction
from solver.path import given_by, known_rules, solved_by
from solver.path.cases import EQUAL, GREATER, LESS, OPERATORS, outcome

BITS = 400


class _Obstacle(Exception):
    """Why a proof failed, in words; or a double root, or the roots near an apparent one."""

    def __init__(
        self, said: str, double: tuple[str, ...] = (), beside: ProvedRoots | None = None
    ) -> None:
        self.proof = Proof(False, obstacle=said, double=double, beside=beside)


def prove(model: Model, leaf: Leaf, inputs: Mapping[str, Value]) -> Proof:
    """The proof of a solved leaf, as far as it succeeds."""
    with precision(BITS):
        try:
            return _Proving(model, leaf, inputs).proof()
        except _Obstacle as obstacle:
            return obstacle.proof


class _Proving:
    def __init__(self, model: Model, leaf: Leaf, inputs: Mapping[str, Value]) -> None:
        self.model, self.leaf, self.inputs = model, leaf, inputs
        self.values = leaf.branch.values
        self.symbols = {name for name, value in self.values.items() if isinstance(value, str)}
        self.decided = leaf.branch.conditions
        self.balls: dict[str, Any] = {
            name: ball(number)
            for name, number in self.values.items()
            if isinstance(number, float) and name not in leaf.branch.origins
        }

    def proof(self) -> Proof:
        """Raises _Obstacle."""
        used: set[int] = set()
        for step in dict.fromkeys(self.leaf.branch.steps):
            rules = solved_by(self.model, step, self.decided)
            used.update(rule.index for rule in rules)
            self._step(rules, given_by(step))
        for rule in known_rules(self.model, self.decided, self.values):
            guards = ((self.model.conditions[p.condition], p.holds) for p in rule.guard)
            if any(outcome(condition, self._certain) is not needed for condition, needed in guards):
                why = "two numbers are too near to equal"
                raise _Obstacle(f"a condition that no enclosure decides: {why}")
            if rule.index in used or not self.symbols.isdisjoint(rule.names):
                continue
            try:  # left and right of a rule that checks must overlap
                left, right = (enclosing_ball(side, self.balls) for side in (rule.left, rule.right))
            except Undefined as undefined:
                raise _Obstacle(f"a rule that checks needs {undefined}") from None
            if not left.overlaps(right):
                raise _Obstacle("a rule that checks is not satisfied exactly")
        radius, nearest = {}, True
        for name, found in self.balls.items():
            number, off = self.values[name], (found - ball(self.values[name])).abs_upper()
            computed = name in self.leaf.branch.origins and not off.is_zero()
            radius[name] = math.nextafter(float(off), math.inf) if computed else 0.0
            nearest = nearest and float(found.lower()) == float(found.upper()) == number
        return Proof(True, radius, nearest)

    def _step(self, equations: Sequence[Equation], unknowns: Sequence[str]) -> None:
        if not equations or not self.symbols.isdisjoint(unknowns):
            return
        if not all(name in self.values for name in unknowns):
            raise _Obstacle(f"{', '.join(unknowns)} is not determined")
        forms = [subtract(equation.left, equation.right) for equation in equations]
        try:
            partials = [differentiate(form, name) for form in forms for name in unknowns]
        except NotDifferentiable as missing:
            raise _Obstacle(str(missing)) from None
        precise = self.leaf.branch.precise
        middle = [ball(precise.get(name, self.values[name])) for name in unknowns]
        square = Square(forms, partials, tuple(unknowns))
        self._double(square, {equation.index for equation in equations}, middle)
        root = proved_root(square, self.balls, middle)
        if root is None:
            raise _Obstacle(f"no proof for {', '.join(unknowns)}: the rules are not regular there")
        self.balls.update(root)

    def _double(self, square: Square, indices: Set[int], middle: Sequence[Any]) -> None:
        """Raises _Obstacle at an apparent double root: one exact root, two nearby, or none."""
        folds = (fact.equations for fact in self.leaf.branch.facts if isinstance(fact, DoubleRoot))
        if all(indices.isdisjoint(equations) for equations in folds):
            return
        names = ", ".join(square.unknowns)
        near = [
            number for name in square.unknowns if isinstance(number := self.values[name], float)
        ]
        if exact_double_root(square, self.balls, near) is not None:
            raise _Obstacle(f"{names}: a double root, exactly", double=tuple(square.unknowns))
        found = unfolded(square, self.balls, middle)
        if found is not None:
            apart = {}  # how far two are from each other, at least
            if found:
                one, other = found
                apart = {n: max(0.0, float(abs(at - other[n]).lower())) for n, at in one.items()}
            beside = ProvedRoots(tuple(square.unknowns), len(found), apart)
            raise _Obstacle(f"{names}: {beside.roots or 'no'} roots, just apart", beside=beside)

    def _certain(self, condition: nodes.Condition) -> bool | None:
        """The outcome of a condition for all numbers in the balls; None if it is not the same."""
        if isinstance(condition, nodes.Given):
            return condition.name in self.inputs
        if not isinstance(condition, nodes.Comparison):
            return None
        sides = condition.left, condition.right
        if any(symbol_of(side, self.values) is not None for side in sides):
            return holds(condition, self.values, self.inputs)
        try:
            left, right = (enclosing_ball(side, self.balls) for side in sides)
        except (Undefined, KeyError):
            return None
        exact = left.is_exact() and right.is_exact()
        if not exact and left.overlaps(right):
            return None
        sign = LESS if left < right else EQUAL if exact and left == right else GREATER
        return sign <= OPERATORS[condition.operator]


# --- roots of a step ---

INFLATIONS, TIGHTENINGS, WIDENINGS = 24, 12, 6
RELATIVELY_ZERO = 2.0**-110
"""Relative radius that no float can tell from 0."""


class Square(NamedTuple):
    """F = 0 for as many ``forms`` as ``unknowns``; ``partials`` are ∂F_i/∂x_j row by row."""

    forms: Sequence[Expression]
    partials: Sequence[Expression]
    unknowns: Sequence[str]

    def rows(self, flat: Sequence[Any]) -> list[Sequence[Any]]:
        """A matrix with as many numbers as there are partials."""
        n = len(self.unknowns)
        return [flat[i : i + n] for i in range(0, n * n, n)]

    def jacobian(self, at: Mapping[str, Ball]) -> list[Sequence[Ball]]:
        return self.rows([enclosing_ball(partial, at) for partial in self.partials])

    def residual(self, at: Mapping[str, Ball]) -> list[Ball]:
        return [enclosing_ball(form, at) for form in self.forms]


def proved_root(
    square: Square, known: Mapping[str, Ball], middle: Sequence[Ball]
) -> dict[str, Ball] | None:
    """Balls around ``middle`` with exactly one root for any ``known`` numbers; None without
    proof."""
    found = only_root(square, known, middle)
    return None if found is None else found[0]


def only_root(
    square: Square, known: Mapping[str, Ball], middle: Sequence[Ball], radii: Sequence[float] = ()
) -> tuple[dict[str, Ball], list[float]] | None:
    """Balls that hold the root, for any ``known`` numbers in theirs, and the radii around
    ``middle`` within which it is the only one, for each of these: the given ones or larger; None
    without a proof."""
    names, image = (
        square.unknowns,
        partial(_image, square, known, jumps(square.forms, square.unknowns)),
    )
    try:
        proved = _inflated(image, list(middle), radii)
        if proved is None:
            return None
        box, inner, wide = proved
        # the numbers of the root, where they are short: the box has no other root, for any known
        # numbers
        for point in (middle, [ball(float(m)) for m in middle]):
            inside = all(x.contains(p) for x, p in zip(box, point, strict=True))
            root = dict(zip(names, point, strict=True))
            if inside and all(
                r.is_exact() and r.is_zero() for r in square.residual({**known, **root})
            ):
                return root, wide
        for _ in range(TIGHTENINGS):  # the image of the image, and so on: each holds the root
            expect_time()
            if all(float(x.rad()) <= RELATIVELY_ZERO * float(x.abs_upper()) for x in inner):
                break
            again = image([x.mid() for x in inner], inner)
            if again is None or not any(
                k.rad() < 0.5 * x.rad() for k, x in zip(again, inner, strict=True)
            ):
                break
            inner = [x.intersection(k) for x, k in zip(inner, again, strict=True)]
        return dict(zip(names, inner, strict=True)), wide
    except (Undefined, OverflowError):
        return None


def _image(
    square: Square,
    known: Mapping[str, Ball],
    kinks: Sequence[Call],
    middle: Sequence[Ball],
    box: Sequence[Ball],
) -> list[Ball] | None:
    """K(X) of a ``box`` X around its ``middle`` m; None if F may jump, or F' be singular."""
    inside, centre = (
        {**known, **dict(zip(square.unknowns, point, strict=True))} for point in (box, middle)
    )
    if not continuous(kinks, inside):
        return None
    there = square.jacobian(centre), square.residual(centre)
    if (found := preconditioned(square.jacobian(inside), *there)) is None:
        return None
    rest, shift = found
    apart = [x - m for x, m in zip(box, middle, strict=True)]
    return [
        m - s + sum((a * d for a, d in zip(row, apart, strict=True)), ball(0))
        for m, s, row in zip(middle, shift, rest, strict=True)
    ]


def _inflated(
    image: Callable[[Sequence[Ball], Sequence[Ball]], list[Ball] | None],
    middle: list[Ball],
    radii: Sequence[float],
) -> tuple[list[Ball], list[Ball], list[float]] | None:
    """A box whose image lies inside it, the image, and the radii of the box."""
    size = max(float(m.abs_upper()) for m in middle) or 1.0
    least = [max(float(m.abs_upper()), 1e-30 * size) * 2.0**-200 for m in middle]
    most, wide = (WIDENINGS, list(radii)) if radii else (INFLATIONS, least)
    for _ in range(most):
        expect_time()
        box = [around(m, r) for m, r in zip(middle, wide, strict=True)]
        found = image(middle, box)
        if found is None:
            return None
        if all(x.contains_interior(k) for x, k in zip(box, found, strict=True)):
            return box, found, wide
        reach = [1.5 * float((k - m).abs_upper()) for m, k in zip(middle, found, strict=True)]
        wide = [max(r, far + tiny) for r, far, tiny in zip(wide, reach, least, strict=True)]
    return None


DENOMINATORS = (1, 10**3, 10**7)
"""Largest denominators of the rational numbers that floats are taken for, besides what they are."""
SPECK = 2.0**-200
"""How far around a root its rules must be smooth."""


def exact_double_root(
    square: Square, known: Mapping[str, Ball], near: Sequence[float]
) -> dict[str, Fraction] | None:
    """The exact root next to the floats ``near`` at which the Jacobian is singular; None if there
    is none that is rational, or a number that it depends on is not known exactly."""
    given = {
        name: number for name, ball in known.items() if (number := exact_fraction(ball)) is not None
    }
    exact = [Fraction(number) for number in near]
    short = ([number.limit_denominator(most) for number in exact] for most in DENOMINATORS)
    for candidate in (exact, *short):
        root = dict(zip(square.unknowns, candidate, strict=True))
        try:
            if _singular_root(square, {**given, **root}):
                return root
        except Inexact:
            continue
    return None


def _singular_root(square: Square, numbers: Mapping[str, Fraction]) -> bool:
    """Whether the rules hold, and the determinant of their Jacobian is 0.

    Derivatives by degrees hold π, so the determinant is a sum over powers of π with rational
    coefficients. As π is transcendental, it is 0 if and only if it is 0 for more numbers in place
    of π than its degree.
    """
    if any(exactly(form, numbers) for form in square.forms):
        return False
    calls, unknown = jumps((*square.forms, *square.partials), square.unknowns), set(square.unknowns)
    balls = {n: around(exact_ball(v), SPECK if n in unknown else 0.0) for n, v in numbers.items()}
    try:
        if calls and not continuous(calls, balls):
            return False  # a kink is no double root, though 0 stands for its slope
    except Undefined:
        return False
    if Call("pi", ()) in walk(*square.forms):
        raise Inexact("a power of π in a rule is of a degree that is not counted")
    degree = sum(part == Call("pi", ()) for partial in square.partials for part in walk(partial))
    for pi in map(Fraction, range(1, degree + 2)):
        rows = square.rows([exactly(partial, numbers, pi) for partial in square.partials])
        if eliminate(rows, [Fraction(0)] * len(rows)) is not None:
            return False
    return True


MU, PLACE = "#mu", "#t"
"""Names that no sheet can have."""
MOST_UNKNOWNS = 8
"""Of a block whose second derivatives are worth forming."""
REACHES = tuple(10.0**-k for k in range(2, 9))
"""Shares of the size of the unknowns along which the curve is tried, the longest first."""
HIGH = 1e3
"""The range of μ that is searched, relative to its range along the curve."""
STEPS = 8
"""Newton steps towards the extreme of μ."""


class CurvePiece(NamedTuple):
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
    """The roots near the apparent double one at ``middle``: two, each enclosed, or none.

    None without a proof.
    """
    if len(square.unknowns) > MOST_UNKNOWNS:
        return None
    try:
        return _LocalCurve(square, known, middle).unfolded()
    except (Undefined, NotDifferentiable, OverflowError, ZeroDivisionError):
        return None


class _LocalCurve:
    """x(t) and μ(t), through ``middle`` at t = 0."""

    def __init__(self, square: Square, known: Mapping[str, Ball], middle: Sequence[Ball]) -> None:
        self.square, self.known, self.middle = square, known, [m.mid() for m in middle]
        self.n, names = len(square.unknowns), square.unknowns
        at = {**known, **dict(zip(names, self.middle, strict=True))}
        rows = [[float(slope.mid()) for slope in row] for row in square.jacobian(at)]
        numbers = [float(m) for m in self.middle]
        # v, with t in units of the largest unknown's size
        direction = null_direction(rows, numbers)
        length = sum(d * d for d in direction) * (max(map(abs, numbers)) or 1.0)
        across = null_direction(list(zip(*rows, strict=True)), [1.0] * self.n)  # u
        pairs = zip(square.forms, across, strict=True)
        forms = [add(form, multiply(Number(u), Name(MU))) for form, u in pairs]
        offsets = [
            multiply(Number(d / length), subtract(Name(name), Number(m)))
            for name, d, m in zip(names, direction, numbers, strict=True)
        ]
        forms.append(subtract(add(*offsets), Name(PLACE)))
        partials = [differentiate(form, name) for form in forms for name in (*names, MU)]
        self.bordered = Square(forms, partials, (*names, MU))
        # second derivatives by pairs of unknowns, mixed ones doubled
        self.second = [
            {
                (j, k): bend if j == k else multiply(Number(2.0), bend)
                for j, k in combinations_with_replacement(range(self.n), 2)
                if not nodes.is_number(bend := differentiate(slopes[j], names[k]), 0.0)
            }
            for slopes in square.rows(square.partials)
        ]
        self.kinks = jumps(square.partials, names)

    def unfolded(self) -> tuple[Mapping[str, Ball], ...] | None:
        """Raises Undefined, and ZeroDivisionError if a matrix cannot be proved regular."""
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

    def _stretch(self, place: Ball, reach: float, point: Mapping[str, Ball]) -> CurvePiece | None:
        """The curve around a point of it.

        μ = 0 is in the box that is searched for others, so F = 0 only on the curve.
        """
        middle = [number.mid() for number in point.values()]
        thin = self._at(around(place, reach), middle)
        if thin is None:
            return None
        radii = [
            3 * (float((thin[name] - m).abs_upper()) + reach * abs(float(m)))
            for name, m in zip(self.square.unknowns, middle, strict=False)
        ]
        # the system is linear in μ
        high = HIGH * float(thin[MU].abs_upper() + point[MU].abs_upper())
        known = {**self.known, PLACE: around(place, reach)}
        found = only_root(self.bordered, known, middle, [*radii, high])
        if found is None:
            return None
        curve, radii = found
        box = {
            n: around(m, r) for n, m, r in zip(self.bordered.unknowns, middle, radii, strict=True)
        }
        return CurvePiece(place, reach, curve, box)

    def _two(
        self, stretch: CurvePiece, point: Mapping[str, Ball], tangent: Sequence[Ball], square: Ball
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
            if root is None or not stretch.holds(root):
                return None
            t = enclosing_ball(self.bordered.forms[-1], {**self.known, **root, PLACE: ball(0)})
            if not abs(t - stretch.place) <= stretch.reach:  # a zero of μ from elsewhere
                return None
            roots.append(root)
        one, other = roots
        return (one, other) if any(not one[name].overlaps(other[name]) for name in one) else None

    def _extreme(self) -> tuple[Ball, dict[str, Ball]]:
        """Near the zero of μ′: the place t, a number, and x and μ there."""
        place, start, steps = ball(0), [*self.middle, ball(0)], STEPS
        while (point := self._at(place, start)) is not None:
            if not steps:
                return place, point
            place = (place - (self._slopes(point)[self.n] / self._bend(point)).mid()).mid()
            start, steps = [number.mid() for number in point.values()], steps - 1
        raise ZeroDivisionError

    def _at(self, place: Ball, start: Sequence[Ball]) -> dict[str, Ball] | None:
        """x and μ for every t of a ball, proved to be the only ones near ``start``."""
        return proved_root(self.bordered, {**self.known, PLACE: place}, [s.mid() for s in start])

    def _slopes(self, point: Mapping[str, Ball]) -> list[Ball]:
        """x′ (n,) and μ′ for any position of the ``point``."""
        return solved(
            self.bordered.jacobian({**self.known, **point}), [*([ball(0)] * self.n), ball(1)]
        )

    def _bend(self, point: Mapping[str, Ball]) -> Ball:
        """μ″: by the chain rule J x″ + μ″ u = −F″(x′, x′), with v·x″ = 0."""
        tangent, at = self._slopes(point), {**self.known, **point}
        curved = []
        for row in self.second:
            total = ball(0)
            for (j, k), bend in row.items():
                total += enclosing_ball(bend, at) * tangent[j] * tangent[k]
            curved.append(-total)
        return solved(self.bordered.jacobian({**self.known, **point}), [*curved, ball(0)])[self.n]


def _opposite(one: Ball, other: Ball) -> bool:
    return bool((one > 0 and other < 0) or (one < 0 and other > 0))
