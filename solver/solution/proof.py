"""Answers proved: that each exists, and is the only one within its radius.

The rules that an answer was solved with are taken step by step, in the order of the path: the inputs are
exact, each step proves its unknowns for whatever its known numbers are within their balls. Conditions must
come out as they were taken for all numbers in the balls; rules that were left over must not be contradicted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from typing import Any

from rulesheets.evaluate import NotDifferentiable, Undefined, differentiate, holds
from rulesheets.evaluate.balls import ball, enclosing_ball, precision
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import Comparison, Condition, Given, Name, Symbol, subtract
from solver.facts import DoubleRoot, Proof, ProvedRoots
from solver.kernel.krawczyk import Square, exact_double_root, proved_root, unfolded
from solver.leaves import Leaf
from solver.path import given_by
from solver.path.cases import EQUAL, GREATER, LESS, OPERATORS, known_rules, outcome, solved_by

BITS = 400


class _Obstacle(Exception):
    """What stands in the way of a proof, in words; a double root, or what is beside it, if it is that."""

    def __init__(self, said: str, double: tuple[str, ...] = (), beside: ProvedRoots | None = None) -> None:
        self.proof = Proof(False, obstacle=said, double=double, beside=beside)


def prove(model: Model, leaf: Leaf, inputs: Mapping[str, Value]) -> Proof:
    """The proof of a solved leaf, as far as it goes."""
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
            for premise in rule.guard:
                if outcome(self.model.conditions[premise.condition], self._certain) is not premise.holds:
                    raise _Obstacle(
                        "a condition that no enclosure decides: two numbers are too near to equal"
                    )
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
        """Raises _Obstacle where floats see a double root: it is there, or two next to it, or none."""
        folds = (fact.equations for fact in self.leaf.branch.facts if isinstance(fact, DoubleRoot))
        if all(indices.isdisjoint(equations) for equations in folds):
            return
        names = ", ".join(square.unknowns)
        near = [number for name in square.unknowns if isinstance(number := self.values[name], float)]
        if exact_double_root(square, self.balls, near) is not None:
            raise _Obstacle(f"{names}: a double root, exactly", double=tuple(square.unknowns))
        found = unfolded(square, self.balls, middle)
        if found is not None:
            apart = {}  # how far two are from each other, at least
            if found:
                one, other = found
                apart = {n: max(0.0, float(abs(at - other[n]).lower())) for n, at in one.items()}
            beside = ProvedRoots(tuple(square.unknowns), len(found), apart)
            raise _Obstacle(f"{names}: {beside.roots or 'no'} roots, a hair apart", beside=beside)

    def _certain(self, condition: Condition) -> bool | None:
        """How a condition comes out for all numbers in the balls; None where they do not agree."""
        if isinstance(condition, Given):
            return condition.name in self.inputs
        if not isinstance(condition, Comparison):
            return None
        sides = condition.left, condition.right
        if any(isinstance(s, Symbol) or (isinstance(s, Name) and s.name in self.symbols) for s in sides):
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
