"""A program as machine code: one loop over the rows, made by LLVM (extra ``jit``), on every core.

The loop has no branches, so that LLVM can take several rows at once: sines and cosines of degrees
and arc tangents are polynomials of their own (those of ``arrays.py``, and a Chebyshev fit of degree
11 for the arc tangent within 22.5 degrees, error below 2e-18), selections are selections. Code is
kept on disk by its content, so that a pattern is compiled once for a machine.
"""

from __future__ import annotations

import ctypes
import os
import re
import struct
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets import store
from solver.trace.arrays import FORMS
from solver.trace.flow import Flow
from solver.trace.graph import (
    DEGREE,
    OPERATIONS,
    Graph,
    NotCompilable,
    copied,
    intrinsic,
    schedule,
)

TANGENT = (
    0.01627194475162406,
    -0.034558092551413795,
    0.04551108126325172,
    -0.052303478730160745,
    0.058789145444006215,
    -0.06666423628069258,
    0.0769229630497447,
    -0.09090908751076636,
    0.11111111105106705,
    -0.14285714285659326,
    0.199999999999998,
    -0.3333333333333333,
)
EIGHTH = 0.41421356237309503
"""The tangent of 22.5 degrees."""

_NAMED = {"exp": "exp", "ln": "log", "log": "log10", "log10": "log10"}
"""Functions of the language by their names in LLVM."""
_HALF_PI = 1.5707963267948966
_INFINITE = "0x7FF0000000000000"
_CALL = re.compile(r"call (.*)")


def _direction(flow: Graph, y: int, x: int, right: float, scale: float) -> int:
    """The direction of (x, y): ``right`` is a right angle, ``scale`` turns radians into its
    unit."""
    op = flow.raw
    ay, ax = op("abs", y), op("abs", x)
    steep = op("lt", ax, ay)
    t = op("div", op("where", steep, ax, ay), op("where", steep, ay, ax))
    far = op("lt", EIGHTH, t)
    u = op("where", far, op("div", op("sub", t, 1.0), op("add", t, 1.0)), t)
    z = op("mul", u, u)
    angle = op("add", u, op("mul", u, op("mul", z, flow.horner(TANGENT, z))))
    if scale != 1.0:
        angle = op("mul", angle, scale)
    angle = op("add", angle, op("where", far, right / 2, 0.0))
    angle = op("where", steep, op("sub", right, angle), angle)
    angle = op("where", op("lt", x, 0.0), op("sub", 2.0 * right, angle), angle)
    return op("where", op("eq", y, 0.0), angle, op("copysign", angle, y))


def _arc(flow: Graph, x: int, cosine: bool, right: float, scale: float) -> int:
    """Arc sine and cosine by the direction of (sqrt(1 - x²), x)."""
    op = flow.raw
    other = op("sqrt", op("mul", op("sub", 1.0, x), op("add", 1.0, x)))
    return _direction(flow, *((other, x) if cosine else (x, other)), right, scale)


def _forms(unit: str, right: float, scale: float) -> dict[str, Callable[..., int]]:
    """The forms of functions that give an angle in a unit."""
    return {
        f"direction{unit}": lambda flow, y, x: _direction(flow, y, x, right, scale),
        f"call atan2{unit}": lambda flow, y, x: _direction(flow, y, x, right, scale),
        f"call atan{unit}": lambda flow, x: _direction(flow, x, flow.constant(1.0), right, scale),
        f"call asin{unit}": lambda flow, x: _arc(flow, x, False, right, scale),
        f"call acos{unit}": lambda flow, x: _arc(flow, x, True, right, scale),
    }


_ANGLES = FORMS | _forms("", _HALF_PI, 1.0) | _forms("d", 90.0, DEGREE)
"""Functions that are written as other operations."""


class _Writer:
    """Lines of the loop body, one value each. ``module`` is one with the function ``rows(start,
    end, inputs…, outputs…)``, which fills the wanted nodes.

    Raises NotCompilable if the graph has a function that the loop cannot hold.
    """

    def __init__(self, flow: Flow, wanted: Sequence[int], inputs: list[int]) -> None:
        self.flow, self.inputs = Flow(flow.plain), inputs
        self.flow.finders = flow.finders  # a loop cannot hold roots of blocks
        self.wanted = wanted = copied(flow, self.flow, wanted, forms=_ANGLES)
        self.lines = list[str]()
        self.values = {self.flow.input(place): f"%x{place}" for place in inputs}
        for node in schedule(self.flow, wanted).order:
            self.values[node] = self._emit(node)

    def module(self) -> str:
        body = "\n  ".join([*self._loads(), *self.lines, *self._stores()])
        arrays = [f"in{i}" for i in self.inputs] + [f"out{i}" for i in range(len(self.wanted))]
        arguments = ", ".join(
            ["i64 %start", "i64 %end", *(f"ptr noalias %{name}" for name in arrays)]
        )
        called = {re.sub(r" (%|0x)\w+", "", call) for call in _CALL.findall("\n".join(self.lines))}
        declarations = "\n".join(f"declare {one}" for one in sorted(called))
        return f"""{declarations}
define void @rows({arguments}) "prefer-vector-width"="512" {{
entry:
  %none = icmp sge i64 %start, %end
  br i1 %none, label %done, label %loop
loop:
  %row = phi i64 [ %start, %entry ], [ %next, %loop ]
  {body}
  %next = add nuw nsw i64 %row, 1
  %last = icmp eq i64 %next, %end
  br i1 %last, label %done, label %loop
done:
  ret void
}}
"""

    def _loads(self) -> Iterator[str]:
        for place in self.inputs:
            yield f"%xp{place} = getelementptr double, ptr %in{place}, i64 %row"
            yield f"%x{place} = load double, ptr %xp{place}, align 8"

    def _stores(self) -> Iterator[str]:
        for place, node in enumerate(self.wanted):
            if self.flow.logical(node):
                yield f"%o{place} = zext i1 {self._read(node)} to i8"
                yield f"%op{place} = getelementptr i8, ptr %out{place}, i64 %row"
                yield f"store i8 %o{place}, ptr %op{place}, align 1"
            else:
                yield f"%op{place} = getelementptr double, ptr %out{place}, i64 %row"
                yield f"store double {self._read(node)}, ptr %op{place}, align 8"

    def _read(self, node: int) -> str:
        operation, *rest = self.flow.nodes[node]
        if operation == "const":
            return str(rest[0]).lower() if isinstance(rest[0], bool) else _constant(float(rest[0]))
        return self.values[node]

    def _emit(self, node: int) -> str:
        operation, *rest = self.flow.nodes[node]
        read = [self._read(o) for o in self.flow.operands[node]]
        match operation:
            case "call" if rest[0] in _NAMED:
                return self._line(intrinsic(_NAMED[str(rest[0])]).format(*read))
            case "where":
                kind = "i1" if self.flow.logical(node) else "double"
                return self._line(f"select i1 {read[0]}, {kind} {read[1]}, {kind} {read[2]}")
            case "max":
                larger = self._line(f"fcmp ogt double {read[0]}, {read[1]}")
                return self._line(f"select i1 {larger}, double {read[0]}, double {read[1]}")
            case "finite":
                size = self._line(intrinsic("fabs").format(*read))
                return self._line(f"fcmp one double {size}, {_INFINITE}")
        native = OPERATIONS[str(operation)].native if operation in OPERATIONS else ""
        if not native:
            raise NotCompilable
        return self._line(native.format(*read))

    def _line(self, text: str) -> str:
        name = f"%v{len(self.lines)}"
        self.lines.append(f"{name} = {text}")
        return name


def _constant(value: float) -> str:
    """A double, bit by bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


Array: TypeAlias = NDArray[Any]

SHARE = 32_768
"""Rows that are worth a thread."""


def available() -> bool:
    """Whether LLVM is installed."""
    try:
        import llvmlite.binding  # noqa: F401
    except ImportError:
        return False
    return True


class NativeKernel:
    """Computes some nodes of a graph for arrays of inputs (n,), like ``ArrayKernel``.

    Raises NotCompilable if the graph has a function that the loop cannot hold.
    """

    def __init__(self, flow: Flow, wanted: Sequence[int]) -> None:
        self.wanted = tuple(wanted)
        self.inputs = sorted(int(node[1]) for node in flow.nodes if node[0] == "input")
        self.source = _Writer(flow, self.wanted, self.inputs).module()
        self._engine, self._run = _compiled(self.source, len(self.inputs) + len(self.wanted))

    def __call__(self, columns: Sequence[Array], results: Sequence[Array]) -> None:
        """Fill ``results`` (an array (n,) for each wanted node) from the columns (n,) of the
        inputs."""
        arrays = [np.ascontiguousarray(columns[i], dtype=float) for i in self.inputs]
        pointers = [array.ctypes.data for array in (*arrays, *results)]
        count = len(results[0])
        threads = max(1, min(os.cpu_count() or 1, count // SHARE))
        ends = [*(count // SHARE * part // threads * SHARE for part in range(threads)), count]
        with ThreadPoolExecutor(threads) as pool:
            others = [
                pool.submit(self._run, *ends[k : k + 2], *pointers) for k in range(1, threads)
            ]
            self._run(*ends[:2], *pointers)
        for part in others:
            part.result()


def _compiled(source: str, pointers: int) -> tuple[Any, Callable[..., None]]:
    """The engine (to be kept) and the loop."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    key = f"{(cpu, features, llvm.llvm_version_info)}\n{source}".encode()
    if (
        code := store.load("native", key)
    ) is not None:  # its engine takes a module without the loop
        source = "\n".join(line for line in source.splitlines() if line.startswith("target"))
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=cpu, features=features, opt=3, jit=True, codemodel="jitdefault"
    )
    module = llvm.parse_assembly(source)
    engine = llvm.create_mcjit_compiler(module, machine)
    if code is None:
        tuning = llvm.create_pipeline_tuning_options(speed_level=3)
        tuning.loop_vectorization = tuning.loop_interleaving = True
        tuning.slp_vectorization = False
        builder = llvm.create_pass_builder(machine, tuning)
        builder.getModulePassManager().run(module, builder)
        code = machine.emit_object(module)
        store.save("native", key, code)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    address = engine.get_function_address("rows")
    signature = ctypes.CFUNCTYPE(
        None, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * pointers
    )
    return engine, signature(address)
