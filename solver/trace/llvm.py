"""A program as machine code: one loop over the rows, made by LLVM (extra ``jit``), on every core.

The loop has no branches, so that LLVM can take several rows at once: sines and cosines of degrees and arc
tangents are polynomials of their own (those of ``arrays.py``, and a Chebyshev fit of degree 11 for the arc
tangent within 22.5 degrees, error below 2e-18), selections are selections. Code is kept on disk by its
content, so that a pattern is compiled once for a machine.
"""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets import store
from solver.trace.arrays import COSINE, RADIAN, SINE, Take
from solver.trace.flow import Flow
from solver.trace.graph import LEAVES, LOGICAL, TOLERANCE, NotCompilable, operands, schedule

DEGREE = 57.29577951308232
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

_BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_COMPARE = {"lt": "olt", "le": "ole", "eq": "oeq"}
_INTRINSIC = {
    "sqrt": "sqrt",
    "abs": "fabs",
    "rint": "rint",
    "sin": "sin",
    "cos": "cos",
    "pow": "pow",
    "call exp": "exp",
    "call ln": "log",
    "call log": "log10",
    "call log10": "log10",
}
_LIBRARY = ("expm1", "log1p")
"""Functions of the mathematical library that LLVM has no name of its own for."""
_INTRINSICS = ("sqrt", "fabs", "rint", "sin", "cos", "exp", "log", "log10")


class _Writer:
    """Lines of the loop body, one value each. ``module`` is one with the function
    ``rows(start, end, inputs…, outputs…)``, which fills the wanted nodes.

    Raises NotCompilable where the graph has a function that the loop cannot hold.
    """

    def __init__(self, flow: Flow, wanted: tuple[int, ...], inputs: list[int]) -> None:
        self.flow, self.wanted, self.inputs = flow, wanted, inputs
        self.lines: list[str] = []
        self.values: dict[int, str] = {}
        self.count = 0
        self.plan = schedule(flow, wanted)
        for place in inputs:
            self.values[flow.input(place)] = f"%x{place}"
        for node in self.plan.order:
            if node not in self.values:
                self._emit(node)

    def module(self) -> str:
        loads = [
            line
            for i in self.inputs
            for line in (
                f"%xp{i} = getelementptr double, ptr %in{i}, i64 %row",
                f"%x{i} = load double, ptr %xp{i}, align 8",
            )
        ]
        body = "\n  ".join([*loads, *self.lines, *self._stores()])
        arguments = ", ".join(
            [
                "i64 %start",
                "i64 %end",
                *(f"ptr noalias %in{i}" for i in self.inputs),
                *(f"ptr noalias %out{i}" for i in range(len(self.wanted))),
            ]
        )
        declarations = "\n".join(
            [
                *(f"declare double @llvm.{name}.f64(double)" for name in _INTRINSICS),
                *(f"declare double @llvm.{name}.f64(double, double)" for name in ("pow", "copysign")),
                *(f"declare double @{name}(double)" for name in _LIBRARY),
            ]
        )
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

    def _stores(self) -> Iterator[str]:
        for place, node in enumerate(self.wanted):
            if self._logical(node):
                yield f"%o{place} = zext i1 {self._read(node)} to i8"
                yield f"%op{place} = getelementptr i8, ptr %out{place}, i64 %row"
                yield f"store i8 %o{place}, ptr %op{place}, align 1"
            else:
                yield f"%op{place} = getelementptr double, ptr %out{place}, i64 %row"
                yield f"store double {self._read(node)}, ptr %op{place}, align 8"

    def _logical(self, node: int) -> bool:
        operation, *rest = self.flow.nodes[node]
        if operation == "const":
            return isinstance(rest[0], bool)
        return operation in LOGICAL or (operation == "where" and self._logical(int(rest[1])))

    def _read(self, node: int) -> str:
        operation, *rest = self.flow.nodes[node]
        if operation == "const":
            return str(rest[0]).lower() if isinstance(rest[0], bool) else _constant(float(rest[0]))
        return self.values[node]

    def _emit(self, node: int) -> None:
        operation, *rest = self.flow.nodes[node]
        if operation in LEAVES:
            return
        read = [self._read(o) for o in operands(self.flow, node)]
        name = f"call {rest[0]}" if operation == "call" else str(operation)
        if name in _BINARY:
            value = self._line(f"{_BINARY[name]} double {read[0]}, {read[1]}")
        elif name in _COMPARE:
            value = self._line(f"fcmp {_COMPARE[name]} double {read[0]}, {read[1]}")
        elif name in _INTRINSIC:
            value = self._call(_INTRINSIC[name], *read)
        elif name in ("and", "or", "xor"):
            value = self._line(f"{name} i1 {read[0]}, {read[1]}")
        elif name == "where":
            kind = "i1" if self._logical(node) else "double"
            value = self._line(f"select i1 {read[0]}, {kind} {read[1]}, {kind} {read[2]}")
        elif name in ("sind", "cosd"):
            self._circular(int(rest[0]), read[0])
            return
        else:
            special = _SPECIAL.get(name)
            if special is None:
                raise NotCompilable
            value = special(self, *read)
        self.values[node] = value

    def _line(self, text: str) -> str:
        self.count += 1
        self.lines.append(f"%v{self.count} = {text}")
        return f"%v{self.count}"

    def _op(self, operation: str, a: str | float, b: str | float) -> str:
        one, other = (_constant(x) if isinstance(x, float) else x for x in (a, b))
        return self._line(f"{operation} double {one}, {other}")

    def _call(self, name: str, *arguments: str | float) -> str:
        texts = (_constant(x) if isinstance(x, float) else x for x in arguments)
        return self._line(f"call double @llvm.{name}.f64({', '.join(f'double {text}' for text in texts)})")

    def _select(self, condition: str, one: str, other: str) -> str:
        return self._line(f"select i1 {condition}, double {one}, double {other}")

    def _horner(self, coefficients: tuple[float, ...], x: str) -> str:
        value: str | float = coefficients[0]
        for coefficient in coefficients[1:]:
            value = self._op("fadd", self._op("fmul", value, x), coefficient)
        return str(value)

    # --- functions of angles ---

    def _circular(self, angle: int, degrees: str) -> None:
        """Sine and cosine, as ``SineAndCosine`` computes them. Angles beyond 1e15 come out as nan."""
        op = self._op
        quarters = self._call("rint", op("fmul", degrees, 1.0 / 90.0))
        rest = op("fmul", op("fsub", degrees, op("fmul", quarters, 90.0)), RADIAN)
        square = op("fmul", rest, rest)
        s = op("fadd", rest, op("fmul", op("fmul", self._horner(SINE, square), square), rest))
        c = op("fmul", self._horner(COSINE, square), op("fmul", square, square))
        c = op("fadd", op("fsub", c, op("fmul", square, 0.5)), 1.0)
        whole = op("fmul", self._call("rint", op("fmul", quarters, 0.25)), 4.0)
        turn = op("fsub", quarters, whole)
        size = self._call("fabs", turn)
        sine = op("fmul", turn, op("fsub", 2.0, size))
        cosine = op("fsub", 1.0, size)
        near = self._line(f"fcmp olt double {self._call('fabs', degrees)}, {_constant(1e15)}")
        found = {
            "sind": op("fadd", op("fmul", s, cosine), op("fmul", c, sine)),
            "cosd": op("fsub", op("fmul", c, cosine), op("fmul", s, sine)),
        }
        for name, value in found.items():
            node = self.flow.node(name, angle)
            self.values[node] = self._select(near, value, _constant(float("nan")))

    def _direction(self, y: str, x: str, right: float, scale: float) -> str:
        """The direction of (x, y): ``right`` is a right angle, ``scale`` turns radians into its unit."""
        op = self._op
        ay, ax = self._call("fabs", y), self._call("fabs", x)
        steep = self._line(f"fcmp ogt double {ay}, {ax}")
        t = op("fdiv", self._select(steep, ax, ay), self._select(steep, ay, ax))
        far = self._line(f"fcmp ogt double {t}, {_constant(EIGHTH)}")
        moved = op("fdiv", op("fsub", t, 1.0), op("fadd", t, 1.0))
        u = self._select(far, moved, t)
        z = op("fmul", u, u)
        angle = op("fadd", u, op("fmul", u, op("fmul", z, self._horner(TANGENT, z))))
        if scale != 1.0:
            angle = op("fmul", angle, scale)
        angle = op("fadd", angle, self._select(far, _constant(right / 2), _constant(0.0)))
        angle = self._select(steep, op("fsub", right, angle), angle)
        left = self._line(f"fcmp olt double {x}, {_constant(0.0)}")
        angle = self._select(left, op("fsub", 2.0 * right, angle), angle)
        signed = self._call("copysign", angle, y)
        flat = self._line(f"fcmp oeq double {y}, {_constant(0.0)}")
        return self._select(flat, angle, signed)

    def _near(self, a: str, b: str) -> str:
        apart = self._call("fabs", self._op("fsub", a, b))
        one, other = self._call("fabs", a), self._call("fabs", b)
        larger = self._select(self._line(f"fcmp ogt double {one}, {other}"), one, other)
        return self._line(f"fcmp ole double {apart}, {self._op('fmul', larger, TOLERANCE)}")

    def _arc(self, x: str, cosine: bool, right: float, scale: float) -> str:
        """Arc sine and cosine by the direction of (sqrt(1 - x²), x)."""
        other = self._call("sqrt", self._op("fmul", self._op("fsub", 1.0, x), self._op("fadd", 1.0, x)))
        return self._direction(*((other, x) if cosine else (x, other)), right, scale)


_HALF_PI = 1.5707963267948966
_SPECIAL: dict[str, Callable[..., str]] = {
    "neg": lambda w, x: w._line(f"fneg double {x}"),
    "max": lambda w, a, b: w._select(w._line(f"fcmp ogt double {a}, {b}"), a, b),
    "not": lambda w, x: w._line(f"xor i1 {x}, true"),
    "finite": lambda w, x: w._line(f"fcmp one double {w._call('fabs', x)}, {_constant(float('inf'))}"),
    "near": _Writer._near,
    "direction": lambda w, y, x: w._direction(y, x, _HALF_PI, 1.0),
    "directiond": lambda w, y, x: w._direction(y, x, 90.0, DEGREE),
    "expm1": lambda w, x: w._line(f"call double @expm1(double {x})"),
    "log1p": lambda w, x: w._line(f"call double @log1p(double {x})"),
    "call atan2": lambda w, y, x: w._direction(y, x, _HALF_PI, 1.0),
    "call atan2d": lambda w, y, x: w._direction(y, x, 90.0, DEGREE),
    "call atand": lambda w, x: w._direction(x, _constant(1.0), 90.0, DEGREE),
    "call atan": lambda w, x: w._direction(x, _constant(1.0), _HALF_PI, 1.0),
    "call asind": lambda w, x: w._arc(x, False, 90.0, DEGREE),
    "call acosd": lambda w, x: w._arc(x, True, 90.0, DEGREE),
    "call asin": lambda w, x: w._arc(x, False, _HALF_PI, 1.0),
    "call acos": lambda w, x: w._arc(x, True, _HALF_PI, 1.0),
}


def _constant(value: float) -> str:
    """A double, bit by bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


Array: TypeAlias = NDArray[Any]

SHARE = 32_768
"""Rows that pay for a thread of their own."""


def available() -> bool:
    """Whether LLVM can be had."""
    try:
        import llvmlite.binding  # noqa: F401
    except ImportError:
        return False
    return True


class NativeKernel:
    """Computes some nodes of a graph for arrays of inputs (n,), like ``ArrayKernel``.

    Raises NotCompilable where the graph has a function that the loop cannot hold.
    """

    def __init__(self, flow: Flow, wanted: Sequence[int]) -> None:
        self.wanted = tuple(wanted)
        self.inputs = sorted(int(node[1]) for node in flow.nodes if node[0] == "input")
        self.source = _Writer(flow, self.wanted, self.inputs).module()
        self._engine, self._run = _compiled(self.source, len(self.inputs) + len(self.wanted))

    def __call__(self, columns: Sequence[Array], results: Sequence[Array], take: Take | None = None) -> None:
        """Fill ``results`` (an array (n,) for each wanted node) from the columns (n,) of the inputs; ``take``
        is told the ends of rows that are done.
        """
        arrays = [np.ascontiguousarray(columns[i], dtype=float) for i in self.inputs]
        pointers = [array.ctypes.data for array in (*arrays, *results)]
        count = len(results[0])
        threads = max(1, min(os.cpu_count() or 1, count // SHARE))

        def run(start: int, end: int) -> None:
            step = max(count, 1) if take is None else SHARE
            for at in range(start, end, step):
                self._run(at, min(at + step, end), *pointers)
                if take is not None:
                    take(at, min(at + step, end))

        ends = [*(count // SHARE * part // threads * SHARE for part in range(threads)), count]
        with ThreadPoolExecutor(threads) as pool:
            others = [pool.submit(run, *ends[k : k + 2]) for k in range(1, threads)]
            run(*ends[:2])
        for part in others:
            part.result()


def _compiled(source: str, pointers: int) -> tuple[Any, Callable[..., None]]:
    """The engine (to keep) and the loop."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    key = f"{(cpu, features, llvm.llvm_version_info)}\n{source}".encode()
    if (code := store.load("native", key)) is not None:  # its engine takes a module without the loop
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
    signature = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * pointers)
    return engine, signature(address)
