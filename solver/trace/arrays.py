"""A program as numpy source: rows in blocks that fit the cache, every result into a buffer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions import ARRAYS
from solver.trace.flow import Flow
from solver.trace.graph import (
    DEGREE,
    LEAVES,
    OPERATIONS,
    RADIAN,
    Graph,
    Schedule,
    copied,
    schedule,
)

Array: TypeAlias = NDArray[Any]

BLOCK = 16384
"""Rows of a block: a few dozen buffers of them fit into the second- or third-level cache."""

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
LARGEST = 2.0**1023


def circular(flow: Graph, degrees: int) -> tuple[int, int]:
    """Sine and cosine, from the angle to the nearest right one; nan for angles beyond ``FAR``."""
    op = flow.raw
    quarters = op("rint", op("mul", degrees, 1.0 / 90.0))
    rest = op("mul", op("sub", degrees, op("mul", quarters, 90.0)), RADIAN)
    square = op("mul", rest, rest)
    s = op("add", rest, op("mul", op("mul", flow.horner(SINE, square), square), rest))
    c = op("mul", flow.horner(COSINE, square), op("mul", square, square))
    c = op("add", op("sub", c, op("mul", square, 0.5)), 1.0)
    # The turn by m right angles, m from -2 to 2: cosine 1 - |m|, sine m (2 - |m|).
    turn = op("sub", quarters, op("mul", op("rint", op("mul", quarters, 0.25)), 4.0))
    size = op("add", op("abs", turn), _nothing(flow, degrees))
    sine, cosine = op("mul", turn, op("sub", 2.0, size)), op("sub", 1.0, size)
    return (
        op("add", op("mul", s, cosine), op("mul", c, sine)),
        op("sub", op("mul", c, cosine), op("mul", s, sine)),
    )


def _nothing(flow: Graph, number: int) -> int:
    """0, or nan beyond ``FAR``: an overflow leaves no difference."""
    large = flow.raw("mul", number, LARGEST / FAR * 2.0)
    return flow.raw("sub", large, large)


FORMS: dict[str, Callable[..., int]] = {
    "sind": lambda flow, degrees: circular(flow, degrees)[0],
    "cosd": lambda flow, degrees: circular(flow, degrees)[1],
    "directiond": lambda flow, y, x: flow.raw("mul", flow.raw("direction", y, x), DEGREE),
}
"""Operations that are written as others."""


class ArrayKernel:
    """Computes some nodes of a graph for arrays of inputs (n,)."""

    def __init__(self, flow: Flow, wanted: Sequence[int]) -> None:
        self.flow = Flow(flow.plain)
        self.flow.finders = flow.finders
        self.wanted = tuple(copied(flow, self.flow, wanted, forms=FORMS))
        # Conditions stand last, and come first: what they read is read again soon.
        writer = _Writer(self.flow, self.wanted, schedule(self.flow, self.wanted[::-1]))
        namespace: dict[str, Any] = dict(writer.namespace)
        self.source = writer.source()
        exec(compile(self.source, "<compiled path>", "exec"), namespace)
        self._block: Callable[..., None] = namespace["block"]
        self.taken = writer.taken
        self._room: list[tuple[list[Array], list[Array]]] = []

    def __call__(self, columns: Sequence[Array], results: Sequence[Array]) -> None:
        """Fill ``results`` (an array (n,) for each wanted node) from the columns (n,) of the
        inputs."""
        count = len(results[0])
        size = min(BLOCK, count)
        if self._room and size == BLOCK:
            room = self._room.pop()
        else:
            masks = [np.empty(size, dtype=bool) for _ in range(self.taken["m"])]
            room = [np.empty(size) for _ in range(self.taken["b"])], masks
        buffers, masks = room
        with np.errstate(all="ignore"):
            for start in range(0, count, size):
                rows = slice(start, min(start + size, count))
                if rows.stop - start < size:
                    short = rows.stop - start
                    buffers = [buffer[:short] for buffer in buffers]
                    masks = [mask[:short] for mask in masks]
                self._block([c[rows] for c in columns], [r[rows] for r in results], buffers, masks)
        if size == BLOCK:
            self._room = [room]


class _Writer:
    """Lines of the block function; registers are reused after their last read."""

    def __init__(self, flow: Flow, wanted: tuple[int, ...], plan: Schedule) -> None:
        self.flow, self.plan = flow, plan
        self.outputs: dict[int, int] = {}
        for place, node in reversed(list(enumerate(wanted))):
            self.outputs.setdefault(node, place)
        self.wanted = wanted
        self.names: dict[int, str] = {}
        self.free: dict[str, list[str]] = {"b": [], "m": []}
        self.taken = {"b": 0, "m": 0}
        self.namespace: dict[str, Any] = {f"{name}_": row.array for name, row in OPERATIONS.items()}
        self.namespace.update(inf=np.inf, nan=np.nan)  # constants that have overflowed
        self.namespace.update(copy_=np.copyto)
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
        return f"def block(columns, results, buffers, masks):\n{body}\n"

    def _read(self, node: int) -> str:
        operation, *rest = self.flow.nodes[node]
        if operation == "const":
            return repr(rest[0])
        return f"x{rest[0]}" if operation == "input" else self.names[node]

    def _emit(self, at: int, node: int) -> None:
        operation, *rest = self.flow.nodes[node]
        read = [self._read(o) for o in self.flow.operands[node]]
        if operation in ("root", "unfolded"):
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
        if operation == "item":
            self.lines.append(f"copy_({target}, {read[0]}[{rest[0]}])")
        elif operation == "call":
            self.namespace[f"f_{rest[0]}"] = ARRAYS[str(rest[0])]
            self.lines.append(f"copy_({target}, f_{rest[0]}({', '.join(read)}))")
        else:
            self.lines.append(f"{operation}_({', '.join((*read, target))})")

    def _register(self, node: int) -> str:
        if node in self.outputs:
            name = f"r{self.outputs[node]}"
        else:
            kind = "m" if self.flow.logical(node) else "b"
            if not self.free[kind]:
                self.free[kind].append(f"{kind}{self.taken[kind]}")
                self.taken[kind] += 1
            name = self.free[kind].pop()
        self.names[node] = name
        return name

    def _release(self, at: int, node: int) -> None:
        """Release the registers that are read here for the last time."""
        for operand in dict.fromkeys(self.flow.operands[node]):
            name = self.names.get(operand)
            if name is not None and self.plan.last[operand] == at and name[0] in "bm":
                self.free[name[0]].append(name)
