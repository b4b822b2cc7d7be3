"""A program as Python source: one solve on floats, straight down.

Of sines and cosines of degrees the angle is reduced to the nearest right angle, exactly, and what is left is
taken to radians with one rounding: a change of the angle by no more than its last digit. Multiples of 30
degrees are exact where the exact answer is a float, as in ``rulesheets.functions.floats``, which is more
accurate and takes longer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from math import atan2, cos, fmod, sin
from types import FunctionType
from typing import Any, TypeAlias

from rulesheets.functions import TABLE
from rulesheets.model import Value
from solver.trace.flow import Flow
from solver.trace.graph import TOLERANCE, operands
from solver.trace.program import Ending, Program

RADIAN = 0.017453292519943295
DEGREE = 57.29577951308232
NEAR = 45.0
"""Angles up to this need no reduction."""
FAR = 1e15
"""Beyond this many degrees the number of right angles is no longer exact."""


def sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Of any angle. Raises ValueError for one that is no number."""
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
    """Statements that assign what is asked for, without a call where the angle needs no reduction."""
    lines = [f"if -{NEAR} <= {angle} <= {NEAR}:", f"    r = {angle} * {RADIAN!r}"]
    if sine:
        lines += [f"    {sine} = sin(r)", f"    if {angle} * {angle} == 900.0: {sine} = {angle} / 60.0"]
    if cosine:
        lines.append(f"    {cosine} = cos(r)")
    return [*lines, "else:", f"    {sine or '_'}, {cosine or '_'} = sine_and_cosine({angle})"]


def direction_lines(name: str, y: str, x: str) -> list[str]:
    """Statements that assign the direction of a point, in (-180, 180] degrees, to a name."""
    # A negative zero counts as zero.
    return [f"{name} = atan2({y} + 0.0, {x}) * {DEGREE!r}", f"if {name} == -180.0: {name} = 180.0"]


NAMES = {"sin": sin, "cos": cos, "atan2": atan2, "sine_and_cosine": sine_and_cosine}
"""What the statements call."""


Row: TypeAlias = tuple[Value, ...]

DEEP = 30
"""Operations that are nested in one expression of the source."""
_BINARY = {
    "add": "+",
    "sub": "-",
    "mul": "*",
    "div": "/",
    "lt": "<",
    "le": "<=",
    "eq": "==",
    "and": "and",
    "or": "or",
    "xor": "!=",
}


def number(given: object) -> float:
    """A number of another type as a float; a text is none, nor an array of one, nor what has two parts.

    Raises TypeError.
    """
    kind = getattr(getattr(given, "dtype", None), "kind", "")
    if isinstance(given, str | bytes | complex) or hasattr(given, "__len__") or kind == "c":
        raise TypeError
    return float(given)  # type: ignore[arg-type]


_FUNCTIONS: dict[str, object] = {
    **NAMES,
    "sqrt": math.sqrt,
    "abs": abs,
    "pow": math.pow,
    "expm1": math.expm1,
    "log1p": math.log1p,
    "float": float,
    "number": number,
    "direction": TABLE["atan2"].value,
    "rint": lambda x: float(round(x)),
    "sorted": sorted,
    "min": min,
    "list": list,
    "fromkeys": dict.fromkeys,
    "ArithmeticError": ArithmeticError,
    "ValueError": ValueError,
    "TypeError": TypeError,
}


def compile_scalar(program: Program, all_answers: bool = False) -> Callable[..., Any]:
    """``f(*numbers)`` gives the wanted values of the primary answer, or None where the program does not tell.

    With ``all_answers`` a list of them, the primary first.
    """
    namespace = _namespace(program)
    exec(compile(_Writer(program, all_answers).source(), "<compiled path>", "exec"), namespace)
    return namespace["solve"]  # type: ignore[no-any-return]


def _namespace(program: Program) -> dict[str, Any]:
    """What the statements of a program call."""
    names = {node[1] for node in program.flow.nodes if node[0] == "call"}
    namespace: dict[str, Any] = {"__builtins__": {}, **_FUNCTIONS, "near": _near}
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

    ``parts`` are so many of its results each; ``written`` makes the statements of the body from a pair for
    each part: the statements that stand in front of its results, and the texts that read these.
    """
    writer, pairs = _Writer(program, False), []
    nodes = [node for node in program.endings[0].results if isinstance(node, int)]
    for count in parts:
        there = len(writer.lines)
        texts = [writer.text(node, "") for node in nodes[:count]]
        nodes = nodes[count:]
        pairs.append((writer.lines[there:], texts))
    body = "\n".join(f"    {line}" for line in written(*pairs))
    namespace = _namespace(program)
    exec(compile(f"def solve({arguments}):\n{body}\n", "<compiled block>", "exec"), namespace)
    return namespace["solve"]  # type: ignore[no-any-return]


def with_resort(function: Callable[..., Any], otherwise: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that hands numbers of which it does not tell to ``otherwise``."""
    known = {**function.__globals__, "otherwise": otherwise}
    return FunctionType(function.__code__, known, function.__name__, function.__defaults__)


def _near(a: float, b: float) -> bool:
    return abs(a - b) <= TOLERANCE * max(abs(a), abs(b))


class _Writer:
    """Lines of the function body. A node that is read once is written where it is read."""

    def __init__(self, program: Program, all_answers: bool) -> None:
        self.program, self.all_answers = program, all_answers
        self.flow: Flow = program.flow
        self.lines: list[str] = []
        self.texts: dict[int, str] = {}
        self.reads = reads(program)
        self.heights = dict[int, int]()
        for node in sorted(self.reads):  # each comes after its operands
            self.heights[node] = 1 + max((self.heights[o] for o in operands(self.flow, node)), default=-1)

    def source(self) -> str:
        arguments = [f"a{i}" for i in range(self.program.inputs)]
        endings = self.program.endings
        if len(endings) == 1 and not self.program.order.usual:
            self._conditions(endings[0].holds, endings[0].finite)
            row = self._row(endings[0])
            if self.program.box is not None:
                self._line("box.told += 1", "    ")
            self._line(f"return [{row}]" if self.all_answers else f"return {row}", "    ")
        else:
            checks = dict.fromkeys(check for ending in endings for check in ending.holds)
            finite = dict.fromkeys(node for ending in endings for node in ending.finite)
            self._conditions(checks, finite)
            self._sorted(endings)
        symbols = dict(self.program.symbols)
        inputs = [f"            if a{place} != {said!r}: break" for place, said in symbols.items()]
        numbers = [place for place in range(self.program.inputs) if place not in symbols]
        inputs += [
            f"            if a{place}.__class__ is not float: a{place} = number(a{place})"
            for place in numbers
        ]
        if self.program.reach != (-math.inf, math.inf):
            low, high = self.program.reach
            inputs.append(f"            if not {low!r} < a0 < {high!r}: break")
        if self.program.box is not None:
            inputs.append(f"            {''.join(f'l{place}, h{place}, ' for place in numbers)} = box.ends")
            within = " and ".join(f"l{place} <= a{place} <= h{place}" for place in numbers)
            inputs.append(f"            if not ({within}): break")
        body = "\n".join([*inputs, *("        " + line for line in self.lines)])
        given = ", ".join(f"{name}" for name in (*arguments, "*more", "**named"))
        taken = ", ".join([*(f"{name}=None" for name in arguments), "*more", "**named"])
        # A loop that is left, not one that goes round: what does not count leaves it before it returns.
        return (
            f"def solve({taken}):\n    try:\n        while True:\n"
            f"            if more or named: break\n{body}\n"
            "    except (ArithmeticError, ValueError, TypeError):\n        pass\n"
            f"    return otherwise({given})\n"
        )

    def _line(self, text: str, indent: str) -> None:
        self.lines.append(indent + text)

    def _sorted(self, endings: Sequence[Ending]) -> None:
        """Return the rows in their order, or the first of them."""
        order, count = self.program.order, len(endings)
        rows = [f"row{place}" for place in range(count)]
        for node, _, _ in order.usual:
            self.text(node, "    ", store=True)
        for row, ending in zip(rows, endings, strict=True) if self.all_answers else ():
            self._line(f"{row} = {self._row(ending)}", "    ")
        whole = f"list(fromkeys(({', '.join(rows)})))"
        if count == 2:
            whole = "[row0] if row0 == row1 else [row0, row1]"
        if order.usual or not order.keys:
            tests = (f"{low!r} <= {self.text(node, '    ')} <= {high!r}" for node, low, high in order.usual)
            self._line(f"if {' and '.join(tests) or 'True'}:", "    ")
            outer = dict(self.texts)
            row = whole if self.all_answers else self._row(endings[0], "        ")
            self._line(f"return {row}", "        ")
            self.texts = outer
        if not order.keys:
            self._line("break", "    ")
            return
        self._require(order.told, "    ")
        keys = [f"({''.join(self.text(n, '    ') + ', ' for n in key)})" for key in order.keys]
        pairs = ", ".join(f"({key}, {place})" for place, key in enumerate(keys))
        if self.all_answers:
            self._line(f"rows = ({', '.join(rows)})", "    ")
            self._line(f"return list(fromkeys([rows[k] for _, k in sorted(({pairs}))]))", "    ")
            return
        self._line(f"first = min(({pairs}))[1]", "    ")
        for place, ending in enumerate(endings):
            outer = dict(self.texts)
            self._line(f"if first == {place}:", "    ")
            if self.program.alone:
                self._conditions(
                    self.program.alone[place].holds, self.program.alone[place].finite, "        "
                )
            self._line(f"return {self._row(ending, '        ')}", "        ")
            self.texts = outer

    def _conditions(self, checks: Iterable[int], finite: Iterable[int], indent: str = "    ") -> None:
        self._require(checks, indent)
        total = " + ".join(self.text(node, indent, store=True) for node in finite)
        if total:
            self._line(f"total = {total}", indent)
            self._line("if total - total != 0.0: break", indent)

    def _require(self, checks: Iterable[int], indent: str) -> None:
        for check in checks:
            kind, *parts = self.flow.nodes[check]
            if kind == "not":
                self._line(f"if {self.text(int(parts[0]), indent)}: break", indent)
            elif kind == "sooner":
                self._line(f"if not {self.text(int(parts[0]), indent)}:", indent)
                self._inside([int(parts[1])], indent, "if not {}: break")
            else:
                self._line(f"if not {self.text(check, indent)}: break", indent)

    def _inside(self, read: list[int], indent: str, line: str) -> None:
        """A line one level in; what is computed for it is not known outside."""
        outer = dict(self.texts)
        inner = indent + "    "
        self._line(line.format(*(self.text(node, inner) for node in read)), inner)
        self.texts = outer

    def _row(self, ending: Ending, indent: str = "    ") -> str:
        parts = [repr(r) if isinstance(r, str) else self.text(r, indent) for r in ending.results]
        return "(" + "".join(f"{part}, " for part in parts) + ")"

    def text(self, node: int, indent: str, store: bool = False) -> str:
        """Source that reads a node: a name, or what computes it where that is the only reader."""
        found = self.texts.get(node)
        if found is not None:
            return found
        if self.heights.get(node, 0) > DEEP:
            self._store_below(node, indent)
        operation, *parts = self.flow.nodes[node]
        if operation in ("const", "input"):
            value = parts[0]
            text = f"a{value}" if operation == "input" else repr(value)
            self.texts[node] = f"({text})" if text.startswith("-") else text
            return self.texts[node]
        if operation == "item":
            return self._item(node, int(parts[1]), indent)
        if operation in ("sind", "cosd"):
            return self._sine_and_cosine(int(parts[0]), node, indent)
        if operation == "directiond" or (operation == "call" and parts[0] == "atan2d"):
            return self._direction(node, int(parts[-2]), int(parts[-1]), indent)
        source = self._source(str(operation), parts, indent)
        if self.reads[node] == 1 and not store:
            return source
        self._line(f"t{node} = {source}", indent)
        self.texts[node] = f"t{node}"
        return self.texts[node]

    def _store_below(self, node: int, indent: str) -> None:
        """Lines for nodes below one at regular heights, so that no text nests deeper than Python reads."""
        found, waiting = set[int](), [node]
        while waiting:
            new = {o for o in operands(self.flow, waiting.pop()) if o not in self.texts} - found
            waiting += new
            found |= new
        for below in sorted(found):
            if self.heights[below] % DEEP == 0 and self.heights[below] and below not in self.texts:
                self.text(below, indent, store=True)

    def _sine_and_cosine(self, angle: int, node: int, indent: str) -> str:
        text = self.text(angle, indent, store=True)
        names: dict[str, str] = {}
        for operation, letter in (("sind", "s"), ("cosd", "c")):
            number = self.flow.number(operation, angle)
            if number is not None and number in self.reads:
                names[operation] = self.texts[number] = f"{letter}{angle}"
        for line in sine_and_cosine_lines(text, names.get("sind"), names.get("cosd")):
            self._line(line, indent)
        return self.texts[node]

    def _item(self, node: int, root: int, indent: str) -> str:
        """The unknowns of a block, all at once."""
        finder, *known = self.flow.nodes[root][1:]
        texts = [self.text(int(o), indent) for o in known]
        names = []
        for place in range(len(self.flow.finders[int(finder)].start)):
            item = self.flow.number("item", place, root)
            if item in self.reads:
                self.texts[item] = f"t{item}"
            names.append(f"t{item}" if item in self.reads else "_")
        self._line(f"{', '.join(names)}, = f_{finder}({', '.join(texts)})", indent)
        return self.texts[node]

    def _direction(self, node: int, y: int, x: int, indent: str) -> str:
        for line in direction_lines(f"t{node}", self.text(y, indent), self.text(x, indent)):
            self._line(line, indent)
        self.texts[node] = f"t{node}"
        return self.texts[node]

    def _source(self, operation: str, operands: list[Any], indent: str) -> str:
        if operation in ("call", "root"):
            arguments = ", ".join(self.text(int(o), indent) for o in operands[1:])
            return f"f_{operands[0]}({arguments})"
        if operation == "max":
            one, other = (self.text(int(o), indent, store=True) for o in operands)
            return f"({one} if {one} > {other} else {other})"
        parts = [self.text(int(o), indent) for o in operands]
        if operation in _BINARY:
            return f"({parts[0]} {_BINARY[operation]} {parts[1]})"
        if operation == "neg":
            below = self.flow.nodes[int(operands[0])]
            if below[0] == "sub" and int(operands[0]) not in self.texts:
                return f"({' - '.join(self.text(int(o), indent) for o in below[:0:-1])})"
            return f"(-{parts[0]})"
        if operation == "not":
            return f"(not {parts[0]})"
        if operation == "sooner":
            return f"({parts[0]} or {parts[1]})"
        if operation == "where":
            return f"({parts[1]} if {parts[0]} else {parts[2]})"
        return f"{operation}({', '.join(parts)})"


def reads(program: Program) -> dict[int, int]:
    """How often each node that matters is read."""
    count: dict[int, int] = {}
    waiting: list[int] = []

    def read(node: int) -> None:
        if node not in count:
            count[node] = 0
            waiting.append(node)
        count[node] += 1

    order = program.order
    alone = program._replace(endings=program.alone).wanted
    for node in (*program.wanted, *alone, *order.told, *(node for key in order.keys for node in key)):
        read(node)
    for node, _, _ in order.usual:
        read(node)
    while waiting:
        for operand in operands(program.flow, waiting.pop()):
            read(operand)
    return count
