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
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence, Set
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, differentiate, holds
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
)
from rulesheets.evaluate.exact import Inexact, Rationals
from rulesheets.model import Equation, Model, Values
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, walk
from solver.accuracy.rule_sides import symbol_of
from solver.facts import DoubleRoot, Proof
from solver.leaves import Leaf
from solver.numerics.elimination import eliminate
from solver.path import given_by, known_rules, solved_by
from solver.path.cases import EQUAL, GREATER, LESS, OPERATORS, outcome

BITS = 400


class _Obstacle(Exception):
    """Why a proof failed, in words; or a double root."""

    def __init__(self, said: str, double: tuple[str, ...] = ()) -> None:
        self.proof = Proof(False, obstacle=said, double=double)


def prove(model: Model, leaf: Leaf, inputs: Values) -> Proof:
    """The proof of a solved leaf, as far as it succeeds."""
    with precision(BITS):
        try:
            return _Proving(model, leaf, inputs).proof()
        except _Obstacle as obstacle:
            return obstacle.proof


class _Proving:
    def __init__(self, model: Model, leaf: Leaf, inputs: Values) -> None:
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
                left, right = (enclosing_ball(side, self.balls) for side in rule.sides)
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
        forms = [equation.form for equation in equations]
        partials = [differentiate(form, name) for form in forms for name in unknowns]
        precise = self.leaf.branch.precise
        middle = [ball(precise.get(name, self.values[name])) for name in unknowns]
        square = Square(forms, partials, tuple(unknowns))
        self._double(square, {equation.index for equation in equations})
        root = proved_root(square, self.balls, middle)
        if root is None:
            raise _Obstacle(f"no proof for {', '.join(unknowns)}: the rules are not regular there")
        self.balls.update(root)

    def _double(self, square: Square, indices: Set[int]) -> None:
        """Raises _Obstacle at an exact double root."""
        folds = (fact.equations for fact in self.leaf.branch.facts if isinstance(fact, DoubleRoot))
        if all(indices.isdisjoint(equations) for equations in folds):
            return
        near = [
            number for name in square.unknowns if isinstance(number := self.values[name], float)
        ]
        if exact_double_root(square, self.balls, near) is not None:
            names = ", ".join(square.unknowns)
            raise _Obstacle(f"{names}: a double root, exactly", double=tuple(square.unknowns))

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

INFLATIONS, TIGHTENINGS = 24, 12
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
    names = square.unknowns
    image = partial(_image, square, known, jumps(square.forms, names))
    try:
        proved = _inflated(image, list(middle))
        if proved is None:
            return None
        box, inner = proved
        # the numbers of the root, where they are short: the box has no other root, for any known
        # numbers
        for point in (middle, [ball(float(m)) for m in middle]):
            inside = all(x.contains(p) for x, p in zip(box, point, strict=True))
            root = dict(zip(names, point, strict=True))
            if inside and all(
                r.is_exact() and r.is_zero() for r in square.residual({**known, **root})
            ):
                return root
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
        return dict(zip(names, inner, strict=True))
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
    image: Callable[[Sequence[Ball], Sequence[Ball]], list[Ball] | None], middle: list[Ball]
) -> tuple[list[Ball], list[Ball]] | None:
    """A box whose image lies inside it, and the image."""
    size = max(float(m.abs_upper()) for m in middle) or 1.0
    wide = least = [max(float(m.abs_upper()), 1e-30 * size) * 2.0**-200 for m in middle]
    for _ in range(INFLATIONS):
        expect_time()
        box = [around(m, r) for m, r in zip(middle, wide, strict=True)]
        found = image(middle, box)
        if found is None:
            return None
        if all(x.contains_interior(k) for x, k in zip(box, found, strict=True)):
            return box, found
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
    if any(map(Rationals(numbers, None).of, square.forms)):
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
        rows = square.rows([*map(Rationals(numbers, pi).of, square.partials)])
        if eliminate(rows, [Fraction(0)] * len(rows)) is not None:
            return False
    return True
