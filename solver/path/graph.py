"""A model as a graph of integers: rules of one shape, angles, and the algebra behind its edges."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from itertools import chain
from math import gcd, lcm
from typing import Any, TypeAlias

from rulesheets.functions import TABLE, named
from rulesheets.model import Equation, Model, Values, once
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    calls,
    map_leaves,
    rebuilt,
    walk,
)
from solver.path import Isolation, SolveBlock, Step, equations_of, given_by

FOLDING = (0.0, 1.0, -1.0)
"""Numbers that an isolation does away with."""


@dataclass(eq=False)
class Shape:
    """Both sides of rules that differ in names and numbers only: names by their order (``#0``) and
    numbers by theirs (``#.0``), except exponents. Equal shapes are the same object."""

    left: Expression
    right: Expression


MOST = 10_000
"""Shapes that are kept at a time, so that rules of one shape share it."""
_INTERNED: dict[tuple[Expression, Expression], Shape] = {}
_SHAPES: dict[tuple[Any, ...], Shape] = {}
"""By the nodes of their rules, each before its parts."""


@once
def by_shape(model: Model) -> Sequence[Sequence[Equation]]:
    """All rules, those of one shape together, in order of first appearance."""
    found: dict[Shape, list[Equation]] = {}
    for equation in model.equations:
        found.setdefault(shape_of(equation)[0], []).append(equation)
    return tuple(found.values())


@once
def occurrences(model: Model) -> tuple[tuple[int, ...], ...]:
    """The places of the variables in each rule."""
    number = {name: i for i, name in enumerate(model.variables)}.__getitem__
    return tuple([tuple(map(number, e.names)) for e in model.equations])


@once
def shape_of(equation: Equation) -> tuple[Shape, Sequence[float]]:
    """The shape of a rule, and its numbers in the order of the text."""
    place = {name: k for k, name in enumerate(equation.names)}
    numbers, key = list[float](), list[Any]()
    node: Any
    for node in walk(*equation.sides):
        kind = type(node)
        if kind is Name:
            key.append(place[node.name])
        elif kind is Number:
            numbers.append(node.value)
            key.append(kind)
        elif kind is Power and type(node.exponent) is Number:
            key.append((kind, node.exponent.value))
        elif kind is Sum or kind is Call:
            key.append((node.function if kind is Call else kind, len(node.parts)))
        else:
            key.append(node if kind is Symbol else kind)
    if (shape := _SHAPES.get(known := tuple(key))) is None:
        if len(_SHAPES) >= MOST:
            _SHAPES.clear()
            _INTERNED.clear()
        names, count = {name: _shared_name(f"#{k}") for name, k in place.items()}, list[float]()
        sides = [_blank(side, names, count) for side in equation.sides]
        shape = _SHAPES[known] = _INTERNED.setdefault((sides[0], sides[1]), Shape(*sides))
    return shape, numbers


def _blank(side: Expression, names: dict[str, Name], numbers: list[float]) -> Expression:
    """A side of a rule in its shape; its numbers are appended."""
    if isinstance(side, Name):
        return names[side.name]
    if isinstance(side, Number):
        numbers.append(side.value)
        return _shared_name(f"#.{len(numbers) - 1}")
    parts = []
    for part in side.parts:
        blank = _blank(part, names, numbers)
        is_exponent = isinstance(side, Power) and part is side.exponent and isinstance(part, Number)
        parts.append(part if is_exponent else blank)
    return rebuilt(side, tuple(parts))


_shared_name = cache(Name)


@lru_cache(MOST)
def asked_shape(shape: Shape, unknown: tuple[bool, ...]) -> Shape:
    """The shape of rules in which names are ``unknown`` or known, as numbers are, in the order of
    names."""
    asked = [k for k, new in enumerate(unknown) if new]
    names = {f"#{k}": _shared_name(f"#{place}") for place, k in enumerate(asked)}

    def told(leaf: Name | Number | Symbol) -> Expression:
        return names.get(leaf.name, _shared_name("#.")) if isinstance(leaf, Name) else leaf

    sides = map_leaves(shape.left, told), map_leaves(shape.right, told)
    return _INTERNED.setdefault(sides, Shape(*sides))


Kind: TypeAlias = tuple[Shape, ...]
"""The shapes of the rules of a step, in which known names are numbers: equal for such steps."""


def kind_of(model: Model, step: Step) -> Kind:
    rules, unknown = [model.equations[e] for e in equations_of(step)], frozenset(given_by(step))
    return tuple(
        [asked_shape(shape_of(e)[0], tuple([n in unknown for n in e.names])) for e in rules]
    )


def unknowns_by_kind(model: Model, steps: Iterable[Step]) -> Counter[Kind]:
    """The number of unknowns of the blocks of each kind."""
    found = Counter[Kind]()
    for step in steps:
        if isinstance(step, SolveBlock):
            found[kind_of(model, step)] += len(step.unknowns)
    return found


def continued(model: Model, steps: Sequence[Step], begun: Values) -> dict[str, float]:
    """The values that steps have ``begun`` with; others continue the last of their kind."""
    last, found = dict[Kind, tuple[float, ...]](), dict[str, float]()
    for step in steps:
        kind = kind_of(model, step)
        numbers = [v for name in given_by(step) if isinstance(v := begun.get(name), float)]
        if len(numbers) == len(given_by(step)):
            last[kind] = tuple(numbers)
        found.update(zip(given_by(step), last.get(kind, ()), strict=False))
    return found


@lru_cache(MOST)
def _counts(shape: Shape) -> Counter[str]:
    """The number of occurrences of each name in rules of a shape."""
    return Counter(nodes.names(shape.left, shape.right))


Ratio: TypeAlias = tuple[int, int]
Isolated: TypeAlias = tuple[Isolation | None, tuple[str, ...]]

MAX_FACTOR = 12.0
"""Largest factor of an angle in a sine; what is multiplied by more is a time or a position."""
MAX_TURNS = 12
"""Turns with which all functions of an angle repeat; an angle with more counts as a number."""


class ModelGraph:
    """Variables and equations by number; isolations are computed once and kept."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.names = tuple(model.variables)
        self.number = {name: i for i, name in enumerate(self.names)}
        self.occurs = occurrences(model)
        self.condition_occurs = tuple(
            tuple(self.number[name] for name in dict.fromkeys(nodes.names(condition)))
            for condition in model.conditions
        )
        self._isolations: dict[tuple[int, int], Isolated] = {}
        self._efforts: dict[tuple[Shape, int, tuple[float, ...]], Isolation | None] = {}
        self._isolated: dict[tuple[Shape, int, tuple[float, ...]], Isolated] = {}
        self.reaches: dict[str, tuple[float, float]] = {}
        self.kernels: dict[Any, Any] = {}
        self.torn: dict[Any, Any] = {}
        self.generic: dict[Any, Any] = {}

    def __getstate__(self) -> dict[str, object]:
        """Pickled without data that only building paths and blocks of one pattern need."""
        kernels = {
            key: kernel for key, kernel in self.kernels.items() if isinstance(key, SolveBlock)
        }
        lost = "_efforts", "_isolated", "torn", "generic"
        emptied: dict[str, object] = {key: {} for key in lost}
        return {**self.__dict__, **emptied, "kernels": kernels}

    @cached_property
    def users(self) -> Mapping[str, Sequence[int]]:
        """Equations that contain a variable, in their body or their guard."""
        users: dict[str, list[int]] = {name: [] for name in self.names}
        for equation, occurs in zip(self.model.equations, self.occurs, strict=True):
            guards = (v for p in equation.guard for v in self.condition_occurs[p.condition])
            for variable in dict.fromkeys((*occurs, *guards)):
                users[self.names[variable]].append(equation.index)
        return users

    def isolation(self, equation: int, variable: int) -> Isolation | None:
        found, names = self.isolated(equation, variable)
        own = self.model.equations[equation].names
        return (
            found
            if found is None or names == own
            else found.renamed(dict(zip(names, own, strict=True)))
        )

    def isolated(self, equation: int, variable: int) -> Isolated:
        """The isolation of the first of the rules that differ from this one only in names, and its
        names, in the order of those of this one."""
        key = (equation, variable)
        if key not in self._isolations:
            from solver.path.isolate import isolate  # most are kept from an earlier run

            body, unknown = self.model.equations[equation], self.names[variable]
            if unknown not in body.names:
                return None, body.names
            shape, numbers = shape_of(body)
            alike = shape, body.names.index(unknown), tuple(numbers)
            if alike not in self._isolated:
                self._isolated[alike] = isolate(*body.sides, unknown), body.names
            self._isolations[key] = self._isolated[alike]
        return self._isolations[key]

    def effort(self, equation: int, variable: int) -> Isolation | None:
        """An isolation of the same cost and branches, None if there is none: computed once for
        rules of one shape.

        Numbers 0 and 1 fold away, so they distinguish shapes; if an unknown occurs several times,
        terms may also be equal by their numbers.
        """
        body = self.model.equations[equation]
        shape, numbers = shape_of(body)
        place = body.names.index(self.names[variable])
        if _counts(shape)[f"#{place}"] == 1:
            numbers = [number if number in FOLDING else math.inf for number in numbers]
        key = shape, place, tuple(numbers)
        if key not in self._efforts:
            self._efforts[key], _ = self.isolated(equation, variable)
        return self._efforts[key]

    @cached_property
    def angles(self) -> Mapping[str, Angle]:
        """Variables that can only be angles."""
        return _angles(self.model)

    @cached_property
    def weighed(self) -> Set[str]:
        """Angles without a range that a condition or an absolute value compares with something: a
        whole turn of them may make a difference, unless a function has them as its value."""
        required = (requirement.comparison for requirement in self.model.requirements)
        choosing = (r for r in by_shape(self.model) if any(map(_chooses, walk(*r[0].sides))))
        sums = (side for rules in choosing for rule in rules for side in rule.sides)
        chosen = (
            part for side in sums if is_angle_sum(side) for part in walk(side) if _chooses(part)
        )
        conditions = (*self.model.conditions, *required, *chosen)
        weighed = self.angles.keys() - _angles(self.model, conditions) if conditions else set()
        for rule in self.model.equations if weighed else ():
            if not rule.guard:
                by = ((n, call) for n, call in rule.definitions if isinstance(call, Call))
                weighed -= {name for name, call in by if TABLE[call.function].angle}
        variables = map(self.model.variables.__getitem__, weighed)
        return {v.name for v in variables if v.low == -math.inf or v.high == math.inf}

    def turn(self, name: str) -> float | None:
        """The period of a variable that can only be an angle: 360 or 2π, or None.

        Several of them if a rule has a part of the angle: ``sind(theta/2)`` has the period 720.
        """
        return None if (found := self.angles.get(name)) is None else found[0] * found[1]

    def tied_turn(self, name: str) -> float | None:
        """The period of a variable that can only be an angle, or is tied to one by sums."""
        return self.turn(name) or self._tied.get(name)

    @cached_property
    def _tied(self) -> Mapping[str, float]:
        """The turns of variables that sums of angles tie to angles."""
        found, before = {name: turn for name, (turn, _) in self.angles.items()}, 0
        rules = self.model.equations if found else ()
        sums = [rule for rule in rules if is_angle_sum(*rule.sides)]
        while len(found) > before:
            before = len(found)
            for rule in sums:
                if turn := next((found[name] for name in rule.names if name in found), None):
                    found = dict.fromkeys(rule.names, turn) | found
        return found

    def single_turn(self, name: str) -> float | None:
        """360 or 2π for a variable that can only be an angle, else None."""
        return None if (found := self.angles.get(name)) is None else found[0]

    def is_turning(self, name: str) -> bool:
        """Whether a variable can only be an angle, and a single turn of it makes no difference."""
        return (found := self.angles.get(name)) is not None and found[1] == 1


Node: TypeAlias = nodes.Expression | nodes.Condition
Addends: TypeAlias = tuple[tuple[str, Ratio], ...]
"""Names, each with its factor."""
Angle: TypeAlias = tuple[float, int]
"""The turn, in the unit of the angle, and how many of them after which all that reads it repeats
itself."""


def _evidence(*parts: Node) -> Iterator[tuple[str, float, int]]:
    """The names in expressions and in the inequalities of conditions: for each occurrence the
    period of the function around it and how many of them count, or 0 for a plain number."""
    stack = [*parts]
    while stack:
        node = stack.pop()
        if isinstance(node, Name):
            yield node.name, 0.0, 1
        elif (
            isinstance(node, Call)
            and (turn := TABLE[node.function].turn)
            and (addends := sum_of_angles(node.arguments[0]))
        ):
            own = 2 if TABLE[node.function].half_turn else 1
            for name, (numerator, denominator) in addends:
                yield name, turn, denominator // gcd(denominator, own * numerator)
        elif not isinstance(node, nodes.Comparison) or node.operator not in ("=", "<>"):
            stack.extend(node.parts)


@once
def angle_evidence(model: Model) -> Sequence[tuple[str, float, int]]:
    """The evidence of angles in rules that call functions of angles: in rules of one shape the same
    for other names, if the numbers in the arguments of periodic functions are the same."""
    found = list[tuple[str, float, int]]()
    for rules in (rules for rules in by_shape(model) if _reads_angles(rules[0])):
        places = _numbers_of_angles(*rules[0].sides)
        alike: dict[tuple[float, ...], list[Equation]] = {}
        for rule in rules:
            numbers = shape_of(rule)[1]
            alike.setdefault(tuple([numbers[place] for place in places]), []).append(rule)
        for first, same in ((same[0], same) for same in alike.values()):
            number = {name: k for k, name in enumerate(first.names)}
            said = _rule_angle_evidence(first)
            read = dict.fromkeys((number[name], turn, turns) for name, turn, turns in said)
            for rule in same:
                found += [(rule.names[k], turn, turns) for k, turn, turns in read]
    return found


REPEATING = named(lambda row: row.turn or row.swings)
STEPS = frozenset({"frac", "int", "mod", "round"})


def phases(*sides: Node) -> list[Expression]:
    """The arguments of functions that repeat themselves, go through 0 again and again as they grow,
    or jump at every whole number."""
    called = calls(*sides)
    found = [call.arguments[-1] for call in called if call.function in REPEATING]
    return found + [call.arguments[0] for call in called if call.function in STEPS]


@lru_cache(MOST)
def repeats(shape: Shape) -> bool:
    """Whether rules of a shape have such functions."""
    return bool(phases(shape.left, shape.right))


def _reads_angles(rule: Equation) -> bool:
    rows = (TABLE[call.function] for call in calls(*rule.sides))
    return any(row.turn or row.angle for row in rows)


def _angles(model: Model, conditions: Iterable[Node] = ()) -> dict[str, Angle]:
    """Variables that occur only where whole turns make no difference."""
    plain: set[str] = set()
    sums: dict[str, list[Equation]] = {}
    for rules in by_shape(model):
        if is_angle_sum(*rules[0].sides):
            for rule in rules:
                for name in rule.names:
                    sums.setdefault(name, []).append(rule)
        elif not _reads_angles(rules[0]):  # what it reads is read as plain numbers
            plain.update(*[rule.names for rule in rules])
    found: dict[str, Angle] = {}
    for name, turn, turns in chain(_evidence(*conditions), angle_evidence(model)):
        known, before = found.get(name, (turn, turns))
        found[name] = turn, lcm(before, turns)
        if not turn or known != turn or found[name][1] > MAX_TURNS:
            plain.add(name)
    spread, read = list(plain), set[int]()
    while spread:  # a name that a sum ties to a number that is not an angle is not one either
        for equation in sums.pop(spread.pop(), ()):
            if equation.index not in read:
                read.add(equation.index)
                spread += {*equation.names} - plain
                plain.update(equation.names)
    return {name: angle for name, angle in found.items() if name not in plain}


def _numbers_of_angles(*sides: Expression) -> list[int]:
    """The numbers of a rule, by their order, that occur in arguments of periodic functions."""
    found, count = list[int](), 0
    stack = [(side, False) for side in sides[::-1]]
    while stack:
        node, inside = stack.pop()
        if isinstance(node, Number):
            found += [count] if inside else []
            count += 1
        inside = inside or (isinstance(node, Call) and bool(TABLE[node.function].turn))
        stack += [(part, inside) for part in node.parts[::-1]]
    return found


def _rule_angle_evidence(rule: Equation) -> Iterator[tuple[str, float, int]]:
    """The evidence of angles in a rule: ``thetaAB = atan2d(…)`` gives one."""
    read: Sequence[Expression] = rule.sides
    for name, call in rule.definitions:
        if isinstance(call, Call) and (turn := TABLE[call.function].angle):
            yield name, turn, 1
            read = call.arguments
    yield from _evidence(*read)


def within_half_turns(number: float, turn: float) -> float:
    """An angle less its whole turns, in (-turn/2, turn/2]."""
    if -turn / 2 < number <= turn / 2:
        return number
    wrapped = math.remainder(number, turn)
    return turn / 2 if wrapped == -turn / 2 else wrapped


def is_angle_sum(*sides: nodes.Expression) -> bool:
    """Whether names, each a whole number of times, and numbers are only added up, compared or not:
    no evidence of angles, and harmless to them unless one of them is not an angle."""
    waiting = [*sides]
    while waiting:
        part = waiting.pop()
        waiting += part.parts
        factors = (part.left, part.right) if isinstance(part, Product) else ()
        multiple = any(isinstance(one, Number) and one.value.is_integer() for one in factors)
        if not (multiple or isinstance(part, Name | Number | Negative | Sum) or _chooses(part)):
            return False
    return True


def is_balance(rule: Equation) -> bool:
    """Whether a rule only adds up variables, as the flows of a joint."""
    return _adds_variables(shape_of(rule)[0])


@lru_cache(MOST)
def _adds_variables(shape: Shape) -> bool:
    sides = nodes.terms(shape.left, shape.right)
    parts = (part.operand if isinstance(part, Negative) else part for part in sides)
    return all(isinstance(part, Name) and not part.name.startswith("#.") for part in parts)


def _chooses(part: Node) -> bool:
    return isinstance(part, Call) and part.function in ("abs", "min", "max")


def sum_of_angles(argument: nodes.Expression) -> Addends | None:
    """The angles in a sum in an argument with their factors; None if it is not such a sum."""
    match argument:
        case Number():
            return ()
        case Name(name):
            return ((name, (1, 1)),)
        case Negative(operand):
            return _scaled(sum_of_angles(operand), (-1, 1))
        case Product(Number(factor), operand) | Product(operand, Number(factor)):
            return _scaled(sum_of_angles(operand), _ratio(factor))
        case Quotient(operand, Number(divisor)):
            ratio = _ratio(divisor)
            return _scaled(sum_of_angles(operand), ratio and ratio[::-1])
        case Sum(terms):
            found = [sum_of_angles(term) for term in terms]
            return None if None in found else tuple(pair for pairs in found for pair in pairs or ())
        case _:
            return None


def _scaled(addends: Addends | None, by: Ratio | None) -> Addends | None:
    """The addends with their factors multiplied by another."""
    if addends is None or by is None:
        return None
    return tuple((name, (over * by[0], under * by[1])) for name, (over, under) in addends)


def _ratio(number: float) -> Ratio | None:
    """A factor without its sign as numerator and denominator; None for 0, and without a short
    ratio."""
    for denominator in (1, 2, 3, 4, 5, 6, 8, 10, 100, 1000):
        numerator = round(abs(number) * denominator) if abs(number) <= MAX_FACTOR else 0
        if numerator and numerator / denominator == abs(number):
            return numerator, denominator
    return None
