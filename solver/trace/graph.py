"""A straight-line program as a graph: every operation once, constants folded.

Nodes are numbered in an order in which they can be computed, and equal operations are one node. A
computed constant comes with an error bound.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial, reduce
from itertools import dropwhile
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.functions import TABLE
from rulesheets.model import reached

Operand: TypeAlias = int | float | str
Node: TypeAlias = tuple[Operand, ...]
"""An operation and the numbers of its operands; of ``const`` the value (and, where it was computed,
how far it may be off), of ``call`` the function and of ``root`` and ``unfolded`` the number of the
finder first. ``sooner`` is its second operand, which may be dear to compute: true where the first
is true."""

RADIAN = 0.017453292519943295
DEGREE = 57.29577951308232


class NotCompilable(Exception):
    """There is no straight-line form: a symbol in arithmetic, a constant without a value."""


_SELECTABLE = frozenset({"add", "sub", "mul", "div", "neg", "abs", "sqrt"})
LOGICAL = frozenset({"lt", "le", "eq", "and", "or", "xor", "not", "finite", "sooner", "unfolded"})
LEAVES = frozenset({"const", "input"})
HALVED = {"cos": "sin", "cosd": "sind"}
SELECTORS = frozenset({"call", "root", "item", "unfolded"})
"""Operations whose first operand is no node."""
ALGEBRAIC = LEAVES | LOGICAL | {"neg", "add", "sub", "mul", "div", "abs", "pow", "max"}
ALGEBRAIC |= {"sqrt", "where", "root", "item"}
"""Operations that may lead from decimals to numbers that are decimals."""


class Operation(NamedTuple):
    """An operation on floats, on arrays, as Python source (empty for a call by its name), and as
    one of LLVM.

    An array or LLVM form is absent if it is written as other operations.
    """

    value: Callable[..., float | bool]
    array: Callable[..., Any] | None = None
    source: str = ""
    native: str = ""


def intrinsic(name: str) -> str:
    """A function of one number that LLVM has."""
    return f"call double @llvm.{name}.f64(double {{0}})"


OPERATIONS = {
    "neg": Operation(operator.neg, np.negative, "(-{0})", "fneg double {0}"),
    "add": Operation(operator.add, np.add, "({0} + {1})", "fadd double {0}, {1}"),
    "sub": Operation(operator.sub, np.subtract, "({0} - {1})", "fsub double {0}, {1}"),
    "mul": Operation(operator.mul, np.multiply, "({0} * {1})", "fmul double {0}, {1}"),
    "div": Operation(operator.truediv, np.divide, "({0} / {1})", "fdiv double {0}, {1}"),
    "sqrt": Operation(math.sqrt, np.sqrt, native=intrinsic("sqrt")),
    "abs": Operation(abs, np.absolute, native=intrinsic("fabs")),
    "rint": Operation(lambda a: float(round(a)), np.rint, native=intrinsic("rint")),
    "pow": Operation(
        math.pow, np.power, native="call double @llvm.pow.f64(double {0}, double {1})"
    ),
    "expm1": Operation(math.expm1, np.expm1, native="call double @expm1(double {0})"),
    "log1p": Operation(math.log1p, np.log1p, native="call double @log1p(double {0})"),
    "sin": Operation(TABLE["sin"].value, np.sin, native=intrinsic("sin")),
    "cos": Operation(TABLE["cos"].value, np.cos, native=intrinsic("cos")),
    "sind": Operation(TABLE["sind"].value),
    "cosd": Operation(TABLE["cosd"].value),
    "direction": Operation(TABLE["atan2"].value, np.arctan2),
    "directiond": Operation(TABLE["atan2d"].value),
    "copysign": Operation(
        math.copysign, native="call double @llvm.copysign.f64(double {0}, double {1})"
    ),
    "max": Operation(
        max, lambda a, b, out: np.maximum(a, b, out=out), "({0} if {0} > {1} else {1})"
    ),
    "lt": Operation(operator.lt, np.less, "({0} < {1})", "fcmp olt double {0}, {1}"),
    "le": Operation(operator.le, np.less_equal, "({0} <= {1})", "fcmp ole double {0}, {1}"),
    "eq": Operation(operator.eq, np.equal, "({0} == {1})", "fcmp oeq double {0}, {1}"),
    "and": Operation(lambda a, b: a and b, np.logical_and, "({0} and {1})", "and i1 {0}, {1}"),
    "or": Operation(lambda a, b: a or b, np.logical_or, "({0} or {1})", "or i1 {0}, {1}"),
    "xor": Operation(operator.ne, np.not_equal, "({0} != {1})", "xor i1 {0}, {1}"),
    "not": Operation(operator.not_, np.logical_not, "(not {0})", "xor i1 {0}, true"),
    "where": Operation(lambda c, a, b: a if c else b, source="({1} if {0} else {2})"),
    "sooner": Operation(lambda sooner, whole: whole, source="({0} or {1})"),
    "finite": Operation(math.isfinite, np.isfinite),
    "root": Operation(lambda *_: math.nan),
    "unfolded": Operation(lambda *_: True),
    "item": Operation(lambda *_: math.nan),
}
"""Those of blocks have their numbers from elsewhere."""


class Graph:
    """Operations, and the conditions under which the results count.

    ``plain``: as the rules are written, without simplifications that skip special directions or are
    more exact than the rules are in floats (``cosd(theta + 90)`` for a small ``theta``).
    """

    def __init__(self, plain: bool = False) -> None:
        self.plain = plain
        self.reported = False
        """Whether numbers are taken as their rounded values, not as they were computed."""
        self.at: Callable[[int], float | bool] | None = None
        """The number of a node at the sample of a record, where there is one."""
        self.nodes: list[Node] = []
        self.operands: list[tuple[int, ...]] = []
        """Those of each node."""
        self.checks: list[int] = []
        self.finders: list[Any] = []
        """The roots of blocks as functions of known numbers, each a ``BlockNewton``, and whether a
        block has as many roots, a ``ConstantRootCount``."""
        self._numbers: dict[Node, int] = {}
        self.true = self.constant(True)
        self.false = self.constant(False)

    def constant(self, value: float | bool) -> int:
        return self.node("const", value if isinstance(value, bool) else float(value))

    def input(self, place: int) -> int:
        return self.node("input", place)

    def number(self, *node: Operand) -> int | None:
        """The number of an existing operation."""
        return self._numbers.get(node)

    def value_of(self, node: int) -> float | bool | None:
        kind = self.nodes[node]
        return kind[1] if kind[0] == "const" else None  # type: ignore[return-value]

    def add(self, operation: str, *operands: int | float) -> int:
        """The node of an operation, simplified; floats among the operands are constants."""
        nodes = self._nodes(operands)
        values = [self.value_of(node) for node in nodes]
        if None not in values:
            try:
                return self.constant(OPERATIONS[operation].value(*values))
            except (ArithmeticError, ValueError):
                raise NotCompilable from None
        simple = SIMPLIFY.get(operation)
        found = simple and simple(self, *nodes)
        return self.node(operation, *nodes) if found is None else found

    def raw(self, operation: str, *operands: int | float) -> int:
        """The node of an operation, unsimplified; floats among the operands are constants."""
        return self.node(operation, *self._nodes(operands))

    def _nodes(self, operands: Iterable[int | float]) -> list[int]:
        return [self.constant(part) if isinstance(part, float) else part for part in operands]

    def over(self, operation: str, nodes: Iterable[int]) -> int:
        """The sum of some nodes, or their conjunction (``and``) or disjunction."""
        neutral = {"add": self.constant(0.0), "and": self.true, "or": self.false}[operation]
        return reduce(partial(self.add, operation), nodes, neutral)

    def is_zero(self, node: int) -> int:
        return self.add("eq", node, 0.0)

    def beyond(self, number: int, share: float, size: int) -> int:
        """The condition that a number is larger than a share of a size, for either sign."""
        return self.add("lt", self.add("mul", share, size), self.add("abs", number))

    def within(self, number: int, share: float, size: int) -> int:
        """The condition that it is not."""
        return self.add("le", self.add("abs", number), self.add("mul", share, size))

    def alike(self, some: Iterable[int], others: Iterable[int]) -> int:
        """The condition that numbers are equal to others, one by one."""
        return self.over("and", (self.add("eq", *pair) for pair in zip(some, others, strict=True)))

    def logical(self, node: int) -> bool:
        """Whether a node is a truth value, not a number."""
        kind, *parts = self.nodes[node]
        if kind == "const":
            return isinstance(parts[0], bool)
        return kind in LOGICAL or (kind == "where" and self.logical(int(parts[1])))

    def node(self, *node: Operand) -> int:
        """The number of an operation, which is added if needed."""
        key = (
            (node[0], type(node[1]).__name__, *map(repr, node[1:])) if node[0] == "const" else node
        )
        number = self._numbers.setdefault(key, len(self.nodes))
        if number == len(self.nodes):
            self.nodes.append(node)
            read: Any = () if node[0] in LEAVES else node[2 if node[0] in SELECTORS else 1 :]
            self.operands.append(tuple(map(int, read)))
        return number

    def factor(self, node: int) -> tuple[float, int] | None:
        """The number and the other factor of a product with a number."""
        kind, *parts = self.nodes[node]
        if kind == "mul":
            for one, other in ((0, 1), (1, 0)):
                value = self.value_of(int(parts[one]))
                if isinstance(value, float):
                    return value, int(parts[other])
        return None

    def total(self, nodes: Iterable[int]) -> int:
        """The sum of some nodes, unsimplified."""
        return reduce(partial(self.raw, "add"), nodes)

    def horner(self, coefficients: Iterable[float], x: int) -> int:
        """The value of a polynomial, the highest power first; zeros cost nothing."""
        first, *others = [*dropwhile(lambda number: not number, coefficients)] or [0.0]
        total = self.constant(first)
        for number in others:
            total = self.raw("mul", total, x)
            total = self.raw("add", total, number) if number else total
        return total

    def require(self, condition: int) -> None:
        """A condition that must hold for the results to count."""
        if condition != self.true and condition not in self.checks:
            self.checks.append(condition)

    def bound(self, number: int) -> None:
        """A number that must be finite, because results could hide that it is not."""
        if self.value_of(number) is None:
            self.require(self.node("finite", number))

    @contextmanager
    def only_if(self, condition: int) -> Iterator[None]:
        """Requirements made inside, except finiteness, apply only if the condition holds."""
        outside, self.checks = self.checks, []
        yield
        inside, self.checks = self.checks, outside
        for check in inside:
            bound = self.nodes[check][0] == "finite"
            self.require(check if bound else self.add("or", self.add("not", condition), check))

    def beside_one(self, node: int) -> int | None:
        """The term added to 1, if a node is such a sum."""
        kind, *parts = self.nodes[node]
        if self.plain or kind not in ("add", "sub"):
            return None
        one, other = (int(part) for part in parts)
        if self.value_of(one) == 1.0:
            return other if kind == "add" else self.add("neg", other)
        return one if kind == "add" and self.value_of(other) == 1.0 else None

    def selected(self, condition: int, one: int, other: int) -> int:
        """A selection between two nodes, or between the only operands in which they differ."""
        (kind, *parts), (second, *others) = self.nodes[one], self.nodes[other]
        differ = [
            place for place, pair in enumerate(zip(parts, others, strict=False)) if len({*pair}) > 1
        ]
        if kind != second or kind not in _SELECTABLE or len(differ) != 1:
            return self.node("where", condition, one, other)
        (place,) = differ
        parts[place] = self.add("where", condition, int(parts[place]), int(others[place]))
        return self.add(str(kind), *map(int, parts))


# --- the operations that some results need, in order ---


class Schedule(NamedTuple):
    """``order`` lists the nodes to compute; ``last`` is the place in it after which a node is not
    read."""

    order: list[int]
    last: dict[int, int]


def schedule(flow: Graph, wanted: Sequence[int]) -> Schedule:
    """Depth first from the wanted nodes, so that values are read soon after they are computed."""
    placed: dict[int, None] = {}
    stack = [(node, False) for node in reversed(wanted)]
    while stack:
        at, ready = stack.pop()
        if ready:
            placed[at] = None
        elif at not in placed and flow.nodes[at][0] not in LEAVES:
            stack += [(at, True), *((o, False) for o in reversed(flow.operands[at]))]
    order = list(placed)
    last = {part: at for at, node in enumerate(order) for part in (node, *flow.operands[node])}
    return Schedule(order, last | dict.fromkeys(wanted, len(order)))


def computed_from(flow: Graph, wanted: Iterable[int], known: Container[int] = ()) -> set[int]:
    """The nodes that the wanted ones are computed from, themselves included, except known ones."""
    return reached(wanted, flow.operands.__getitem__, known)


def copied(
    source: Graph,
    target: Graph,
    wanted: Sequence[int],
    inputs: Sequence[int] | None = None,
    forms: Mapping[str, Callable[..., int]] | None = None,
) -> list[int]:
    """The wanted nodes in another graph, with ``inputs`` (by place) instead of the source's own.

    The roots of blocks become a few steps of their iteration, unless the target has their finders,
    too; operations that have ``forms`` (by kind, calls by function) become the results of these on
    the target's nodes.
    """
    found: dict[int, int] = {}
    roots: dict[int, list[int]] = {}

    def read(node: int) -> int:
        kind, *rest = source.nodes[node]
        if kind == "input" and inputs is not None:
            return inputs[int(rest[0])]
        return target.node(*source.nodes[node]) if kind in LEAVES else found[node]

    for node in schedule(source, wanted).order:
        kind, *rest = source.nodes[node]
        read_here = (
            [read(one) for one in source.operands[node]] if kind != "item" or not roots else []
        )
        form = forms and forms.get(f"call {rest[0]}" if kind == "call" else str(kind))
        if form:
            found[node] = form(target, *read_here)
        elif kind == "root" and not target.finders:
            roots[node] = source.finders[int(rest[0])].unrolled(target, read_here)
        elif kind == "unfolded" and not target.finders:
            found[node] = target.true
        elif kind == "item" and roots:
            found[node] = roots[int(rest[1])][int(rest[0])]
        else:
            head = (rest[0],) if kind in SELECTORS else ()
            found[node] = target.node(kind, *head, *read_here)
    return [read(node) for node in wanted]


def _negative(flow: Graph, a: int) -> int | None:
    kind, *parts = flow.nodes[a]
    if kind == "neg":
        return int(parts[0])
    number = flow.factor(a)
    return None if number is None else flow.add("mul", -number[0], number[1])


def _opposite(flow: Graph, a: int) -> int | None:
    """The node of which a node is the negative, by its sign or that of a number."""
    number, value = flow.factor(a), flow.value_of(a)
    if flow.nodes[a][0] == "neg" or (number and number[0] < 0.0):
        return _negative(flow, a)
    return flow.constant(-value) if isinstance(value, float) and value < 0.0 else None


def _add(flow: Graph, a: int, b: int) -> int | None:
    pairs = sorted(((a, b), (b, a)), key=lambda pair: flow.nodes[pair[1]][0] != "neg")
    for one, other in pairs:  # signs first: they need not be computed then
        if flow.value_of(other) == 0.0:
            return one
        if (opposite := _opposite(flow, other)) is not None:
            return flow.add("sub", one, opposite)
        kind, *parts = flow.nodes[one]
        if kind == "sub" and parts[1] == other and not (flow.plain or flow.reported):
            return int(parts[0])
    return flow.node("add", b, a) if b < a else None


def _subtract(flow: Graph, a: int, b: int) -> int | None:
    if a == b:
        return flow.constant(0.0)
    if flow.value_of(b) == 0.0:
        return a
    if flow.value_of(a) == 0.0:
        return flow.add("neg", b)
    if (opposite := _opposite(flow, b)) is not None:
        return flow.add("add", a, opposite)
    if (left := _cancelled(flow, a, b)) is not None:
        return left
    if flow.value_of(a) == 1.0 and (growth := _growth(flow, b)) is not None:
        return flow.add("neg", growth)
    if flow.value_of(b) == 1.0 and (growth := _growth(flow, a)) is not None:
        return growth
    return flow.node("neg", flow.node("sub", b, a)) if b < a else None


def _growth(flow: Graph, power: int) -> int | None:
    """``exp(x) - 1``, ``cos(x) - 1`` and ``(1 + x)^n - 1`` without cancellation for a small x."""
    if not flow.plain and flow.nodes[power][:2] == ("call", "exp"):
        return flow.add("expm1", int(flow.nodes[power][2]))
    if not flow.plain and flow.nodes[power][0] in HALVED:
        sine = flow.add(
            HALVED[str(flow.nodes[power][0])], flow.add("mul", 0.5, int(flow.nodes[power][1]))
        )
        small = flow.add("mul", -2.0, flow.add("mul", sine, sine))
        return flow.add("where", flow.add("lt", 0.5, power), small, flow.raw("sub", power, 1.0))
    if flow.plain or flow.nodes[power][0] != "pow":
        return None
    base, exponent = (int(part) for part in flow.nodes[power][1:])
    x = flow.beside_one(base)
    if x is not None and flow.at is not None and not flow.at(x) > -1.0:
        return None  # a negative base, with whole exponents only
    return None if x is None else flow.add("expm1", flow.add("mul", exponent, flow.add("log1p", x)))


def vanishes(flow: Graph, node: int) -> bool:
    """Whether a number is 0 for any inputs."""
    kind, *parts = flow.nodes[node]
    return flow.value_of(node) == 0.0 or (kind in ("neg", "div") and vanishes(flow, int(parts[0])))


def not_negative(flow: Graph, node: int) -> bool:
    """Whether a node cannot be negative."""
    kind, *parts = flow.nodes[node]
    if kind == "const":
        return float(parts[0]) >= 0.0
    if kind in ("abs", "sqrt"):
        return True
    if kind == "max":
        return any(not_negative(flow, int(part)) for part in parts)
    if kind == "mul" and parts[0] == parts[1]:
        return True
    return kind in ("mul", "add") and all(not_negative(flow, int(part)) for part in parts)


def _cancelled(flow: Graph, a: int, b: int) -> int | None:
    """``(x + y) - y`` and the like: an addend that is subtracted again is not rounded twice."""
    if flow.plain or flow.reported:
        return None
    kind, *parts = flow.nodes[a]
    if kind == "add" and b in parts:
        return int(parts[1] if parts[0] == b else parts[0])
    if kind == "sub" and parts[0] == b:
        return flow.add("neg", int(parts[1]))
    kind, *parts = flow.nodes[b]
    if kind == "add" and a in parts:
        return flow.add("neg", int(parts[1] if parts[0] == a else parts[0]))
    return int(parts[1]) if kind == "sub" and parts[0] == a else None


def _multiply(flow: Graph, a: int, b: int) -> int | None:
    for one, other in ((a, b), (b, a)):
        match flow.value_of(one):
            case 0.0:
                return flow.constant(0.0)
            case 1.0:
                return other
            case -1.0:
                return flow.add("neg", other)
    for one, other in ((a, b), (b, a)):
        number, value = flow.factor(other), flow.value_of(one)
        if number is not None and isinstance(value, float):
            return flow.add("mul", flow.add("mul", value, number[0]), number[1])
    if a == b and (square := _square(flow, a)) is not None:
        return square
    if flow.nodes[a][0] == "neg":
        return flow.add("neg", flow.add("mul", int(flow.nodes[a][1]), b))
    if flow.nodes[b][0] == "neg":
        return flow.add("neg", flow.add("mul", a, int(flow.nodes[b][1])))
    return flow.node("mul", b, a) if b < a else None


def _square(flow: Graph, a: int) -> int | None:
    """The square of a root, of a number of roots, of a number whose sign was selected."""
    kind, *parts = flow.nodes[a]
    if kind == "neg":
        return flow.add("mul", int(parts[0]), int(parts[0]))
    if kind == "where":
        one, other = int(parts[1]), int(parts[2])
        if flow.nodes[one] == ("neg", other):
            return flow.add("mul", other, other)
        return flow.add("mul", one, one) if flow.nodes[other] == ("neg", one) else None
    if flow.plain or flow.reported:
        return None
    if kind == "sqrt":
        inside = int(parts[0])
        flow.require(flow.add("le", 0.0, inside))
        return inside
    if kind == "mul":
        for one, other in ((int(parts[0]), int(parts[1])), (int(parts[1]), int(parts[0]))):
            size = _size(flow, one)
            if size is not None and flow.nodes[other][0] == "sqrt":
                return flow.add("mul", flow.add("mul", size, size), flow.add("mul", other, other))
    return None


def _size(flow: Graph, node: int) -> float | None:
    """The absolute value of a number, or of the two alternatives of a selection."""
    kind, *parts = flow.nodes[node]
    values = (
        [flow.value_of(int(part)) for part in parts[1:]]
        if kind == "where"
        else [flow.value_of(node)]
    )
    sizes = {abs(v) if isinstance(v, float) else None for v in values}
    return sizes.pop() if len(sizes) == 1 else None


def _divide(flow: Graph, a: int, b: int) -> int | None:
    if flow.value_of(b) == 1.0:
        return a
    if flow.value_of(b) == -1.0:
        return flow.add("neg", a)
    if flow.nodes[a][0] == "neg":
        return flow.add("neg", flow.add("div", int(flow.nodes[a][1]), b))
    if flow.nodes[b][0] == "neg":
        return flow.add("neg", flow.add("div", a, int(flow.nodes[b][1])))
    number = flow.value_of(b)
    if (
        isinstance(number, float)
        and math.frexp(number)[0] in (0.5, -0.5)
        and 1e-100 < abs(number) < 1e100
    ):
        return flow.add("mul", 1.0 / number, a)  # a power of two: nothing is rounded
    below = flow.nodes[b]
    if below[0] == "div" and flow.value_of(int(below[1])) == 1.0:
        return flow.add("mul", a, int(below[2]))
    if below[0] == "div" and not flow.plain:
        return flow.add("div", flow.add("mul", a, int(below[2])), int(below[1]))
    return None


def _joined(flow: Graph, a: int, b: int, decisive: bool) -> int | None:
    if (outcome := flow.constant(decisive)) in (a, b):
        return outcome
    neutral = flow.constant(not decisive)
    if a in (neutral, b):
        return b
    return a if b == neutral else None


def _where(flow: Graph, c: int, a: int, b: int) -> int | None:
    if c == flow.true or a == b:
        return a
    if flow.nodes[c][0] == "not":
        return flow.add("where", int(flow.nodes[c][1]), b, a)
    return b if c == flow.false else flow.selected(c, a, b)


def _absolute(flow: Graph, a: int) -> int | None:
    if (opposite := _opposite(flow, a)) is not None:
        return flow.add("abs", opposite)
    return a if not_negative(flow, a) else None


def _larger(flow: Graph, a: int, b: int) -> int | None:
    if a == b:
        return a
    for one, other in ((a, b), (b, a)):
        number = flow.value_of(one)
        if number is not None and (
            number == -math.inf or (number <= 0.0 and not_negative(flow, other))
        ):
            return other
    return flow.node("max", b, a) if b < a else None


SIMPLIFY: dict[str, Callable[..., int | None]] = {
    "neg": _negative,
    "add": _add,
    "sub": _subtract,
    "mul": _multiply,
    "div": _divide,
    "and": lambda flow, a, b: _joined(flow, a, b, False),
    "or": lambda flow, a, b: _joined(flow, a, b, True),
    "not": lambda flow, a: int(flow.nodes[a][1]) if flow.nodes[a][0] == "not" else None,
    "where": _where,
    "abs": _absolute,
    "max": _larger,
}
