"""A program as Python source: one solve on floats, straight down."""

from __future__ import annotations

import math

from rulesheets.functions import TABLE
from rulesheets.functions.degrees import sincosd
from solver.compiled.flow import TOLERANCE

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import Any, TypeAlias

    from rulesheets.model import Value
    from solver.compiled.flow import Flow
    from solver.compiled.program import Ending, Program

    Row: TypeAlias = tuple[Value, ...]

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
_FUNCTIONS: dict[str, object] = {
    "sqrt": math.sqrt,
    "abs": abs,
    "pow": math.pow,
    "sin": math.sin,
    "cos": math.cos,
    "float": float,
    "sincosd": sincosd,
    "direction": TABLE["atan2"].value,
    "directiond": TABLE["atan2d"].value,
    "rint": lambda x: float(round(x)),
    "sorted": sorted,
    "len": len,
    "ArithmeticError": ArithmeticError,
    "ValueError": ValueError,
    "TypeError": TypeError,
}


def compile_scalar(program: Program, all_answers: bool = False) -> Callable[..., Any]:
    """``f(*numbers)`` gives the wanted values of the primary answer, or None where the program does not tell.

    With ``all_answers`` a list of them, the primary first.
    """
    source = scalar_source(program, all_answers)
    names = {node[1] for node in program.flow.nodes if node[0] == "call"}
    namespace: dict[str, Any] = {"__builtins__": {}, **_FUNCTIONS, "near": _near}
    namespace.update({f"f_{name}": TABLE[str(name)].value for name in names})
    namespace.update({f"f_{place}": finder.scalar for place, finder in enumerate(program.flow.finders)})
    exec(compile(source, "<compiled path>", "exec"), namespace)
    return namespace["solve"]  # type: ignore[no-any-return]


def scalar_source(program: Program, all_answers: bool = False) -> str:
    """The Python source of a program."""
    return _Writer(program, all_answers).source()


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

    def source(self) -> str:
        arguments = [f"a{i}" for i in range(self.program.inputs)]
        only = self.program.endings[0]
        if len(self.program.endings) == 1 and only.gone == self.flow.false:
            self._conditions(only, "    ")
            row = self._row(only)
            self._line(f"return [{row}]" if self.all_answers else f"return {row}", "    ")
        else:
            self._line("found = []", "    ")
            shared = set.intersection(*(set(ending.holds) for ending in self.program.endings))
            self._require([check for check in only.holds if check in shared], "    ")
            for ending in self.program.endings:
                self._ending(ending, shared)
            self._line("if not found: return None", "    ")
            self._line("found = sorted(found)" if len(self.program.endings) > 1 else "", "    ")
            self._line(
                "return [row for _, row in found]" if self.all_answers else "return found[0][1]", "    "
            )
        symbols = dict(self.program.symbols)
        inputs = [f"        if a{place} != {said!r}: return None" for place, said in symbols.items()]
        numbers = [place for place in range(self.program.inputs) if place not in symbols]
        inputs += [f"        a{place} = float(a{place})" for place in numbers]
        body = "\n".join([*inputs, *("    " + line for line in self.lines)])
        return (
            f"def solve({', '.join(arguments)}):\n    try:\n{body}\n"
            "    except (ArithmeticError, ValueError, TypeError):\n        return None\n"
        )

    def _line(self, text: str, indent: str) -> None:
        if text:
            self.lines.append(indent + text)

    def _ending(self, ending: Ending, shared: set[int]) -> None:
        outer = dict(self.texts)
        gone = self.text(ending.gone, "    ")
        if ending.gone != self.flow.false:
            self._line(f"if not {gone}:", "    ")
            indent = "        "
        else:
            indent = "    "
        self._conditions(ending, indent, shared)
        key = "".join(f"{self.text(node, indent)}, " for node in ending.order)
        row = self._row(ending, indent)
        self._line(f"found.append((({key}), {row}))", indent)
        if indent != "    ":
            self.texts = outer  # what was computed inside is not known outside

    def _conditions(self, ending: Ending, indent: str, known: Iterable[int] = ()) -> None:
        self._require([check for check in ending.holds if check not in set(known)], indent)
        total = " + ".join(self.text(node, indent, store=True) for node in ending.finite)
        if total:
            self._line(f"total = {total}", indent)
            self._line("if total - total != 0.0: return None", indent)

    def _require(self, checks: Iterable[int], indent: str) -> None:
        for check in checks:
            node = self.flow.nodes[check]
            if node[0] == "not":
                self._line(f"if {self.text(int(node[1]), indent)}: return None", indent)
            else:
                self._line(f"if not {self.text(check, indent)}: return None", indent)

    def _row(self, ending: Ending, indent: str = "    ") -> str:
        parts = [repr(r) if isinstance(r, str) else self.text(r, indent) for r in ending.results]
        return "(" + "".join(f"{part}, " for part in parts) + ")"

    def text(self, node: int, indent: str, store: bool = False) -> str:
        """Source that reads a node: a name, or what computes it where that is the only reader."""
        found = self.texts.get(node)
        if found is not None:
            return found
        operation, *operands = self.flow.nodes[node]
        if operation in ("const", "input"):
            value = operands[0]
            text = f"a{value}" if operation == "input" else repr(value)
            self.texts[node] = f"({text})" if text.startswith("-") else text
            return self.texts[node]
        if operation in ("sind", "cosd"):
            return self._sine_and_cosine(int(operands[0]), node, indent)
        source = self._source(str(operation), operands, indent)
        if self.reads[node] == 1 and not store:
            return source
        self._line(f"t{node} = {source}", indent)
        self.texts[node] = f"t{node}"
        return self.texts[node]

    def _sine_and_cosine(self, angle: int, node: int, indent: str) -> str:
        pair = {
            self.flow.nodes[n][0]: n
            for n in self.reads
            if self.flow.nodes[n] in (("sind", angle), ("cosd", angle))
        }
        self._line(f"s{angle}, c{angle} = sincosd({self.text(angle, indent)})", indent)
        for operation, number in pair.items():
            self.texts[number] = f"{'s' if operation == 'sind' else 'c'}{angle}"
        return self.texts[node]

    def _source(self, operation: str, operands: list[Any], indent: str) -> str:
        if operation in ("call", "root"):
            arguments = ", ".join(self.text(int(o), indent) for o in operands[1:])
            return f"f_{operands[0]}({arguments})"
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

    for ending in program.endings:
        for node in (*ending.holds, *ending.finite, *ending.order, ending.gone):
            read(node)
        for result in ending.results:
            if isinstance(result, int):
                read(result)
    while waiting:
        operation, *operands = program.flow.nodes[waiting.pop()]
        if operation not in ("const", "input"):
            for operand in operands[1:] if operation in ("call", "root") else operands:
                read(int(operand))
    return count
