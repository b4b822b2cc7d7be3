"""A program as Python source: one solve on floats, in straight-line code.

For sines and cosines of degrees the angle is reduced to the nearest right angle, exactly, and the
rest is converted to radians with one rounding: a change of the angle by no more than its last
digit. Multiples of 30 degrees are exact if the exact answer is a float, as in
``rulesheets.functions.angles``, which is more accurate and slower.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from math import atan2, cos, fmod, sin
from types import FunctionType
from typing import Any

from rulesheets.functions import TABLE
from solver.trace.flow import Flow
from solver.trace.graph import DEGREE, OPERATIONS, RADIAN, Operand, computed_from
from solver.trace.program import Ending, Program, checks_and_bounds

NEAR = 45.0
"""Angles up to this need no reduction."""
FAR = 1e15
"""Beyond this many degrees the number of right angles is no longer exact."""


def sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Of any angle. Raises ValueError for nan and infinity."""
    if not -FAR <= degrees <= FAR:
        degrees = fmod(degrees, 360.0)
    quarters = round(degrees / 90.0)
    rest = degrees - 90.0 * quarters
    angle = rest * RADIAN
    sine, cosine = sin(angle), cos(angle)
    if rest * rest == 900.0:
        sine = rest / 60.0
    turn = quarters & 3
    if turn == 0:
        return sine, cosine
    if turn == 1:
        return cosine, 0.0 - sine
    return (0.0 - sine, 0.0 - cosine) if turn == 2 else (0.0 - cosine, sine)


def sine_and_cosine_lines(angle: str, sine: str | None, cosine: str | None) -> list[str]:
    """Statements that assign the requested values, without a call if the angle needs no
    reduction."""
    lines = [f"if -{NEAR} <= {angle} <= {NEAR}:", f"    r = {angle} * {RADIAN!r}"]
    if sine:
        lines += [
            f"    {sine} = sin(r)",
            f"    if {angle} * {angle} == 900.0: {sine} = {angle} / 60.0",
        ]
    if cosine:
        lines.append(f"    {cosine} = cos(r)")
    return [*lines, "else:", f"    {sine or '_'}, {cosine or '_'} = sine_and_cosine({angle})"]


def direction_lines(name: str, y: str, x: str) -> list[str]:
    """Statements that assign the direction of a point, in (-180, 180] degrees, to a name."""
    # A negative zero counts as zero.
    return [f"{name} = atan2({y} + 0.0, {x}) * {DEGREE!r}", f"if {name} == -180.0: {name} = 180.0"]


NAMES = {"sin": sin, "cos": cos, "atan2": atan2, "sine_and_cosine": sine_and_cosine}
"""The names that the statements use."""


DEEP = 30
"""Operations that are nested in one expression of the source."""
_TWICE = frozenset({"max", "sind", "cosd", "unfolded"})
"""Operations whose text has an operand more than once."""


def float_of(given: object) -> float:
    """A number of another type as a float; not a text, an array, or a complex number.

    Raises TypeError.
    """
    kind = getattr(getattr(given, "dtype", None), "kind", "")
    if kind in ("c", "U", "S") or (hasattr(given, "__len__") and getattr(given, "ndim", True)):
        raise TypeError
    return float(given)  # type: ignore[arg-type]


_FUNCTIONS: dict[str, object] = {
    **{name: row.value for name, row in OPERATIONS.items() if not row.source},
    **NAMES,
    "float": float,
    "number": float_of,
    "sorted": sorted,
    "min": min,
    "list": list,
    "fromkeys": dict.fromkeys,
    "ArithmeticError": ArithmeticError,
    "ValueError": ValueError,
    "TypeError": TypeError,
}


def compile_scalar(program: Program, all_answers: bool = False) -> Callable[..., Any]:
    """``f(*numbers)`` returns the wanted values of the primary answer, or None if the program does
    not cover them.

    With ``all_answers`` a list of them, the primary first.
    """
    namespace = _namespace(program)
    exec(compile(_Writer(program, all_answers).source(), "<compiled path>", "exec"), namespace)
    return namespace["solve"]  # type: ignore[no-any-return]


def _namespace(program: Program) -> dict[str, Any]:
    """The names that the statements of a program use."""
    names = {node[1] for node in program.flow.nodes if node[0] == "call"}
    namespace: dict[str, Any] = {"__builtins__": {}, **_FUNCTIONS}
    namespace["otherwise"] = lambda *numbers, **named: None
    namespace["box"] = program.box
    namespace.update(inf=math.inf, nan=math.nan)  # constants that have overflowed
    namespace.update({f"f_{name}": TABLE[str(name)].value for name in names})
    for place, finder in enumerate(program.flow.finders):
        namespace[f"f_{place}"] = finder.scalar
    return namespace


def block_function(
    program: Program, arguments: str, parts: Sequence[int], written: Callable[..., list[str]]
) -> Callable[..., Any]:
    """A function of ``arguments``, inputs ``a0``, ``a1``, … of a program, around its operations.

    ``parts`` are the numbers of results of each part; ``written`` makes the statements of the body
    from a pair for each part: the statements before its results, and the texts of these.
    """
    writer, pairs = _Writer(program, False), []
    nodes = [node for node in program.endings[0].results if isinstance(node, int)]
    for count in parts:
        there = len(writer.lines)
        texts = [writer.text(node) for node in nodes[:count]]
        nodes = nodes[count:]
        pairs.append((writer.lines[there:], texts))
    body = "\n".join(f"    {line}" for line in written(*pairs))
    namespace = _namespace(program)
    exec(compile(f"def solve({arguments}):\n{body}\n", "<compiled block>", "exec"), namespace)
    return namespace["solve"]  # type: ignore[no-any-return]


def with_fallback(
    function: Callable[..., Any], otherwise: Callable[..., Any]
) -> Callable[..., Any]:
    """A compiled function that calls ``otherwise`` for numbers that it does not cover."""
    known = {**function.__globals__, "otherwise": otherwise}
    return FunctionType(function.__code__, known, function.__name__, function.__defaults__)


class _Writer:
    """Lines of the function body. A node that is read once is written where it is read."""

    def __init__(self, program: Program, all_answers: bool) -> None:
        self.program, self.all_answers = program, all_answers
        self.flow: Flow = program.flow
        self.lines: list[str] = []
        self.indent = ""
        self.texts: dict[int, str] = {}
        """The text of each node: a name, or its operation if it is read only once."""
        self.depths: dict[int, int] = {}
        self.reads = reads(program)

    def source(self) -> str:
        program = self.program
        arguments = [f"a{i}" for i in range(program.inputs)]
        self.indent = " " * 12
        self._inputs()
        checks, finite = checks_and_bounds(self.flow, program.holds)
        self._require(checks)
        if finite:
            self._line(f"total = {' + '.join(map(self.text, dict.fromkeys(finite.values())))}")
            self._line("if total - total != 0.0: break")
        if len(program.endings) > 1 or program.order.usual:
            self._sorted(program.endings)
        else:
            row = self._row(program.endings[0])
            if program.box is not None:
                self._line("box.uses += 1")
            self._line(f"return [{row}]" if self.all_answers else f"return {row}")
        body = "\n".join(self.lines)
        given = ", ".join([*arguments, "*more", "**named"])
        taken = ", ".join([*(f"{name}=None" for name in arguments), "*more", "**named"])
        # A loop of one round, which results that do not count leave before it returns.
        return (
            f"def solve({taken}):\n    try:\n        while True:\n"
            f"            if more or named: break\n{body}\n"
            "    except (ArithmeticError, ValueError, TypeError):\n        pass\n"
            f"    return otherwise({given})\n"
        )

    def _inputs(self) -> None:
        program, symbols = self.program, dict(self.program.symbols)
        for place, said in symbols.items():
            self._line(f"if a{place} != {said!r}: break")
        numbers = [place for place in range(program.inputs) if place not in symbols]
        for place in numbers:
            self._line(f"if a{place}.__class__ is not float: a{place} = number(a{place})")
        if program.box is not None:
            self._line(f"{''.join(f'l{place}, h{place}, ' for place in numbers)} = box.ends")
            within = " and ".join(f"l{place} <= a{place} <= h{place}" for place in numbers)
            self._line(f"if not ({within}): break")

    def _line(self, text: str) -> None:
        self.lines.append(self.indent + text)

    @contextmanager
    def _under(self, head: str) -> Iterator[None]:
        """Lines under a head; values computed there are not known outside."""
        self._line(head)
        outer, self.texts = self.texts, dict(self.texts)
        self.indent += "    "
        yield
        self.texts, self.indent = outer, self.indent[4:]

    def _sorted(self, endings: Sequence[Ending]) -> None:
        """Return the rows in order, or the first of them."""
        order, count = self.program.order, len(endings)
        rows = [f"row{place}" for place in range(count)]
        usual = [f"{low!r} <= {self.text(node)} <= {high!r}" for node, low, high in order.usual]
        for row, ending in zip(rows, endings, strict=True) if self.all_answers else ():
            self._line(f"{row} = {self._row(ending)}")
        whole = f"list(fromkeys(({', '.join(rows)})))"
        if count == 2:
            whole = "[row0] if row0 == row1 else [row0, row1]"
        if usual or not order.keys:
            with self._under(f"if {' and '.join(usual) or 'True'}:"):
                self._line(f"return {whole if self.all_answers else self._row(endings[0])}")
        if not order.keys:
            self._line("break")
            return
        self._require(order.conditions)
        keys = [f"({''.join(self.text(n) + ', ' for n in key)})" for key in order.keys]
        pairs = ", ".join(f"({key}, {place})" for place, key in enumerate(keys))
        if self.all_answers:
            self._line(f"rows = ({', '.join(rows)})")
            self._line(f"return list(fromkeys([rows[k] for _, k in sorted(({pairs}))]))")
            return
        self._line(f"first = min(({pairs}))[1]")
        for place, ending in enumerate(endings):
            with self._under(f"if first == {place}:"):
                self._line(f"return {self._row(ending)}")

    def _require(self, checks: Iterable[int]) -> None:
        for check in checks:
            kind, *parts = self.flow.nodes[check]
            if kind == "not":
                self._line(f"if {self.text(int(parts[0]))}: break")
            elif kind == "sooner":
                with self._under(f"if not {self.text(int(parts[0]))}:"):
                    self._line(f"if not {self.text(int(parts[1]))}: break")
            else:
                self._line(f"if not {self.text(check)}: break")

    def _row(self, ending: Ending) -> str:
        parts = [repr(r) if isinstance(r, str) else self.text(r) for r in ending.results]
        return "(" + "".join(f"{part}, " for part in parts) + ")"

    def text(self, node: int) -> str:
        """Source of a node, after lines for the nodes that it is computed from."""
        # each after its operands
        for below in sorted(computed_from(self.flow, [node], self.texts)):
            if below not in self.texts:
                self._write(below, *self.flow.nodes[below])
        return self.texts[node]

    def _write(self, node: int, operation: Operand, *parts: Any) -> None:
        name = f"t{node}"
        read = [self.texts[part] for part in self.flow.operands[node]]
        match operation:
            case "const" | "input":
                text = f"a{parts[0]}" if operation == "input" else repr(parts[0])
                self.texts[node] = f"({text})" if text.startswith("-") else text
            case "sind" | "cosd":
                self._sine_and_cosine(parts[0], read[0])
            case "root":
                self._root(node, parts[0], read)
            case "call" | "directiond" if operation == "directiond" or parts[0] == "atan2d":
                self.lines += [self.indent + line for line in direction_lines(name, *read)]
                self.texts[node] = name
            case _:
                parts_of = self.flow.operands[node]
                self.depths[node] = 1 + max(
                    (self.depths.get(part, 0) for part in parts_of), default=0
                )
                self.texts[node] = self._source(str(operation), parts, read)
                if self.reads[node] > 1 or self.depths[node] > DEEP:
                    self._line(f"{name} = {self.texts[node]}")
                    self.texts[node], self.depths[node] = name, 0

    def _sine_and_cosine(self, angle: int, text: str) -> None:
        names = dict[str, str]()
        for operation, letter in (("sind", "s"), ("cosd", "c")):
            number = self.flow.number(operation, angle)
            if number is not None and number in self.reads:
                names[operation] = self.texts[number] = f"{letter}{angle}"
        lines = sine_and_cosine_lines(text, names.get("sind"), names.get("cosd"))
        self.lines += [self.indent + line for line in lines]

    def _root(self, node: int, finder: int, known: Sequence[str]) -> None:
        """The unknowns of a block, all at once."""
        every = range(len(self.flow.finders[finder].start))
        items = [self.flow.number("item", k, node) or -1 for k in every]
        self.texts |= {item: f"t{item}" for item in (node, *items) if item in self.reads}
        names = ", ".join(self.texts.get(item, "_") for item in items)
        self._line(f"{names}, = f_{finder}({', '.join(known)})")

    def _source(self, operation: str, parts: Sequence[Any], read: Sequence[str]) -> str:
        match operation:
            case "call":
                return f"f_{parts[0]}({', '.join(read)})"
            case "unfolded":
                ends, asked = f"f_{parts[0]}.__self__.ends", f"f_{parts[0]}({', '.join(read)})"
                within = [
                    f"{ends}[{2 * k}] <= {x} <= {ends}[{2 * k + 1}]" for k, x in enumerate(read)
                ]
                return f"({' and '.join(within)} or {asked})"
            case "neg" if self.flow.nodes[parts[0]][0] == "sub" and read[0] != f"t{parts[0]}":
                swapped = self.flow.operands[parts[0]][::-1]
                return f"({' - '.join(self.texts[part] for part in swapped)})"
        source = OPERATIONS[operation].source
        return source.format(*read) if source else f"{operation}({', '.join(read)})"


def reads(program: Program) -> Counter[int]:
    """How often each needed node is read, also within the text of another."""
    nodes = *program.wanted, *program.order.nodes
    count = Counter(nodes)
    for node in computed_from(program.flow, nodes):
        for operand in program.flow.operands[node]:
            count[operand] += 2 if program.flow.nodes[node][0] in _TWICE else 1
    return count
