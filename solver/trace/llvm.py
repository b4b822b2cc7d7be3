"""A program as machine code: one loop over the rows, made by LLVM (extra ``jit``), on every core.

Code is kept on disk by its content, so that a pattern is compiled once for a machine.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets import store
from solver.trace.flow import Flow
from solver.trace.llvm_loop import loop_module

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
        self.source = loop_module(flow, self.wanted, self.inputs)
        self._engine, self._run = _compiled(self.source, len(self.inputs) + len(self.wanted))

    def __call__(self, columns: Sequence[Array], results: Sequence[Array]) -> None:
        """Fill ``results`` (an array (n,) for each wanted node) from the columns (n,) of the inputs."""
        arrays = [np.ascontiguousarray(columns[i], dtype=float) for i in self.inputs]
        pointers = [array.ctypes.data for array in (*arrays, *results)]
        count = len(results[0])
        threads = max(1, min(os.cpu_count() or 1, count // SHARE))
        if threads == 1:
            self._run(0, count, *pointers)
            return
        ends = [count * part // threads for part in range(threads + 1)]
        with ThreadPoolExecutor(threads) as pool:
            parts = [pool.submit(self._run, *ends[k : k + 2], *pointers) for k in range(threads)]
        for part in parts:
            part.result()


def _machine() -> Any:
    """A code generator for this machine, one for each engine, which takes it over."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    features = llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=features, opt=3, jit=True, codemodel="jitdefault"
    )


def _compiled(source: str, pointers: int) -> tuple[Any, Callable[..., None]]:
    """The engine (to keep) and the loop."""
    import llvmlite.binding as llvm

    machine = _machine()
    key = store.digest(
        b"machine code",
        llvm.get_host_cpu_name().encode(),
        llvm.get_host_cpu_features().flatten().encode(),
        repr(llvm.llvm_version_info).encode(),
        source.encode(),
    )
    kept = store.load("native", key)
    module = llvm.parse_assembly(source if kept is None else _empty(source))
    engine = llvm.create_mcjit_compiler(module, machine)
    if kept is None:
        _optimize(llvm, machine, module)
        code = machine.emit_object(module)
        store.save("native", key, code)
    else:
        code = kept
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    address = engine.get_function_address("rows")
    signature = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * pointers)
    return engine, signature(address)


def _empty(source: str) -> str:
    """A module without the loop, for an engine that is given the code."""
    return "\n".join(line for line in source.splitlines() if line.startswith("target"))


def _optimize(llvm: Any, machine: Any, module: Any) -> None:
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization = True
    tuning.loop_interleaving = True
    tuning.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
