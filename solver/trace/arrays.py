"""A program as numpy source: rows in blocks that stay in the cache, every result into a buffer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions.arrays import ARRAYS
from solver.trace.flow import Flow
from solver.trace.graph import LEAVES, LOGICAL, TOLERANCE, Schedule, operands, schedule

Array: TypeAlias = NDArray[Any]
Take: TypeAlias = Callable[[int, int], None]

DEGREE = 57.29577951308232
BLOCK = 16384
"""Rows of a block: a few dozen buffers of them fit into the second- or third-level cache."""

_UFUNCS = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "sqrt": np.sqrt,
    "abs": np.absolute,
    "rint": np.rint,
    "max": lambda a, b, out: np.maximum(a, b, out=out),
    "pow": np.power,
    "expm1": np.expm1,
    "log1p": np.log1p,
    "sin": np.sin,
    "cos": np.cos,
    "lt": np.less,
    "le": np.less_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "xor": np.not_equal,
    "finite": np.isfinite,
}


class ArrayKernel:
    """Computes some nodes of a graph for arrays of inputs (n,)."""

    def __init__(self, flow: Flow, wanted: Sequence[int]) -> None:
        self.flow, self.wanted = flow, tuple(wanted)
        # Conditions stand last, and come first: what they read is read again soon.
        writer = _Writer(flow, self.wanted, schedule(flow, self.wanted[::-1]))
        namespace: dict[str, Any] = dict(writer.namespace)
        self.source = writer.source()
        exec(compile(self.source, "<compiled path>", "exec"), namespace)
        self._block: Callable[..., None] = namespace["block"]
        self.taken = writer.taken
        self._room: list[tuple[list[Array], list[Array], SineAndCosine]] = []

    def __call__(self, columns: Sequence[Array], results: Sequence[Array], take: Take | None = None) -> None:
        """Fill ``results`` (an array (n,) for each wanted node) from the columns (n,) of the inputs; ``take``
        is told the ends of rows that are done.
        """
        count = len(results[0])
        size = min(BLOCK, count)
        if self._room and size == BLOCK:
            room = self._room.pop()
        else:
            masks = [np.empty(size, dtype=bool) for _ in range(self.taken["m"])]
            room = [np.empty(size) for _ in range(self.taken["b"])], masks, SineAndCosine(size)
        buffers, masks, scratch = room
        with np.errstate(all="ignore"):
            for start in range(0, count, size):
                rows = slice(start, min(start + size, count))
                if rows.stop - start < size:
                    short = rows.stop - start
                    buffers = [buffer[:short] for buffer in buffers]
                    masks = [mask[:short] for mask in masks]
                    scratch = SineAndCosine(short)
                self._block([c[rows] for c in columns], [r[rows] for r in results], buffers, masks, scratch)
                if take is not None:
                    take(rows.start, rows.stop)
        if size == BLOCK:
            self._room = [room]


class _Writer:
    """Lines of the block function; registers are taken again once nothing reads them any more."""

    def __init__(self, flow: Flow, wanted: tuple[int, ...], plan: Schedule) -> None:
        self.flow, self.plan = flow, plan
        self.outputs: dict[int, int] = {}
        for place, node in reversed(list(enumerate(wanted))):
            self.outputs.setdefault(node, place)
        self.wanted = wanted
        self.names: dict[int, str] = {}
        self.free: dict[str, list[str]] = {"b": [], "m": []}
        self.taken = {"b": 0, "m": 0}
        self.namespace: dict[str, Any] = {f"{name}_": f for name, f in _UFUNCS.items()}
        self.namespace.update(inf=np.inf, nan=np.nan)  # constants that have overflowed
        self.namespace.update(copy_=np.copyto, near_=_near, atan2_=np.arctan2)
        self.lines: list[str] = []
        for at, node in enumerate(plan.order):
            self._emit(at, node)
        for place, node in enumerate(wanted):
            if flow.nodes[node][0] in LEAVES or self.outputs[node] != place:
                self.lines.append(f"copy_(r{place}, {self._read(node)})")

    def source(self) -> str:
        inputs = sorted(int(node[1]) for node in self.flow.nodes if node[0] == "input")
        head = [
            *(f"x{i} = columns[{i}]" for i in inputs),
            *(f"r{i} = results[{i}]" for i in range(len(self.wanted))),
            *(f"b{i} = buffers[{i}]" for i in range(self.taken["b"])),
            *(f"m{i} = masks[{i}]" for i in range(self.taken["m"])),
        ]
        body = "\n".join(f"    {line}" for line in [*head, *self.lines]) or "    pass"
        return f"def block(columns, results, buffers, masks, sincosd):\n{body}\n"

    def _read(self, node: int) -> str:
        operation, *rest = self.flow.nodes[node]
        if operation == "const":
            return repr(rest[0])
        return f"x{rest[0]}" if operation == "input" else self.names[node]

    def _emit(self, at: int, node: int) -> None:
        if node in self.names:
            return
        operation, *rest = self.flow.nodes[node]
        if operation == "not" and self._is_last(at, node):
            return
        read = [self._read(o) for o in operands(self.flow, node)]
        if operation in ("sind", "cosd"):
            self._circular(at, int(rest[0]), read[0])
            return
        if operation == "root":
            self.namespace[f"root_{rest[0]}"] = self.flow.finders[int(rest[0])].array
            self.lines.append(f"v{node} = root_{rest[0]}({', '.join(read)})")
            self._release(at, node)
            self.names[node] = f"v{node}"
            return
        if operation == "where":
            # The register of an alternative that is not read again can take the result.
            target = self._register(node)
            if (read[1], read[2]) == ("1.0", "0.0"):
                self.lines.append(f"copy_({target}, {read[0]})")
            else:
                self.lines.append(f"copy_({target}, {read[2]})")
                self.lines.append(f"copy_({target}, {read[1]}, where={read[0]})")
            self._release(at, node)
            return
        self._release(at, node)
        target = self._register(node)
        if operation in ("direction", "directiond"):
            self.lines.append(f"atan2_({', '.join((*read, target))})")
            if operation == "directiond":
                self.lines.append(f"mul_({target}, {DEGREE!r}, {target})")
        elif operation == "item":
            self.lines.append(f"copy_({target}, {read[0]}[{rest[0]}])")
        elif operation == "call":
            self.namespace[f"f_{rest[0]}"] = ARRAYS[str(rest[0])]
            self.lines.append(f"copy_({target}, f_{rest[0]}({', '.join(read)}))")
        else:
            self.lines.append(f"{operation}_({', '.join((*read, target))})")

    def _is_last(self, at: int, node: int) -> bool:
        """Make an equality that was computed just now, for nothing else, its opposite."""
        (inside,) = operands(self.flow, node)
        line, name = self.lines[-1] if self.lines else "", self.names.get(inside, "")
        if not line.startswith("eq_(") or not line.endswith(f" {name})") or self.plan.last[inside] != at:
            return False
        if name[0] != "m" or node in self.outputs:
            return False
        self.lines[-1] = "ne_" + line.removeprefix("eq_")
        self.names[node] = name
        return True

    def _circular(self, at: int, angle: int, text: str) -> None:
        pair = [n for n in self.plan.order if self.flow.nodes[n] in (("sind", angle), ("cosd", angle))]
        names = {str(self.flow.nodes[n][0]): self._register(n) for n in pair}
        sine, cosine = names.get("sind", "None"), names.get("cosd", "None")
        self.lines.append(f"sincosd({text}, {sine}, {cosine})")
        for node in pair:
            self._release(at, node)

    def _register(self, node: int) -> str:
        if node in self.outputs:
            name = f"r{self.outputs[node]}"
        else:
            operation, *rest = self.flow.nodes[node]
            selected = self.flow.nodes[int(rest[1])][0] if operation == "where" else operation
            kind = "m" if selected in LOGICAL else "b"
            if self.free[kind]:
                name = self.free[kind].pop()
            else:
                name = f"{kind}{self.taken[kind]}"
                self.taken[kind] += 1
        self.names[node] = name
        return name

    def _release(self, at: int, node: int) -> None:
        """Give back the registers that are read here for the last time."""
        for operand in dict.fromkeys(operands(self.flow, node)):
            name = self.names.get(operand)
            if name is not None and self.plan.last[operand] == at and name[0] in "bm":
                self.free[name[0]].append(name)


def _near(a: Array, b: Array, out: Array) -> None:
    np.less_equal(np.abs(a - b), TOLERANCE * np.maximum(np.abs(a), np.abs(b)), out)


RADIAN = 0.017453292519943295
SINE = (
    1.591805913698281e-10,
    -2.5051130870968297e-08,
    2.755731609787775e-06,
    -0.0001984126983674956,
    0.008333333333330943,
    -0.1666666666666665,
)
COSINE = (
    -1.1382588535352522e-11,
    2.0876145659059344e-09,
    -2.755731726880539e-07,
    2.4801587298760048e-05,
    -0.0013888888888887393,
    0.041666666666666664,
)
FAR = 1e15
"""Beyond this many degrees the number of right angles is no longer exact in the product."""


class SineAndCosine:
    """Buffers for blocks of ``size`` rows, and the function that uses them."""

    def __init__(self, size: int) -> None:
        self.buffers = tuple(np.empty(size) for _ in range(6))

    def __call__(self, degrees: Array | float, sine: Array | None, cosine: Array | None) -> None:
        """Write the sine and the cosine of ``degrees`` (n,) where they are asked for."""
        quarters, rest, square, s, c, spare = self.buffers
        multiply, add, subtract = np.multiply, np.add, np.subtract
        if np.max(degrees) > FAR or np.min(degrees) < -FAR:
            degrees = np.fmod(degrees, 360.0)
        multiply(degrees, 1.0 / 90.0, quarters)
        np.rint(quarters, quarters)
        multiply(quarters, 90.0, rest)
        subtract(degrees, rest, rest)
        multiply(rest, RADIAN, rest)
        multiply(rest, rest, square)
        _horner(SINE, square, s)
        multiply(s, square, s)
        multiply(s, rest, s)
        add(rest, s, s)
        _horner(COSINE, square, c)
        multiply(square, square, spare)
        multiply(c, spare, c)
        multiply(square, 0.5, square)
        subtract(c, square, c)
        add(c, 1.0, c)
        # The turn by m right angles, m from -2 to 2: cosine 1 - |m|, sine m (2 - |m|).
        multiply(quarters, 0.25, spare)
        np.rint(spare, spare)
        multiply(spare, 4.0, spare)
        subtract(quarters, spare, quarters)
        np.absolute(quarters, spare)
        subtract(2.0, spare, rest)
        multiply(quarters, rest, quarters)
        subtract(1.0, spare, spare)
        if sine is not None:
            multiply(s, spare, square)
            multiply(c, quarters, rest)
            add(square, rest, sine)
        if cosine is not None:
            multiply(c, spare, square)
            multiply(s, quarters, rest)
            subtract(square, rest, cosine)


def _horner(coefficients: tuple[float, ...], x: Array, out: Array) -> None:
    np.multiply(x, coefficients[0], out)
    for coefficient in coefficients[1:-1]:
        np.add(out, coefficient, out)
        np.multiply(out, x, out)
    np.add(out, coefficients[-1], out)
