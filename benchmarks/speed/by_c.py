"""The slider crank by hand in C, compiled here and now: ``crank.c`` through ctypes, and cffi where
it is."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.speed.closed_forms import Array, Five

SOURCE = Path(__file__).with_name("crank.c")
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")


class CCrank:
    """The functions of ``crank.c``. Raises OSError where there is no compiler."""

    def __init__(self, folder: Path) -> None:
        compiler = shutil.which("gcc") or shutil.which("cc")
        if compiler is None:
            raise OSError("there is no C compiler")
        self.library = folder / "crank.so"
        words = [compiler, *FLAGS, str(SOURCE), "-o", str(self.library), "-lm"]
        subprocess.run(words, check=True, capture_output=True)
        self._functions = ctypes.CDLL(str(self.library))

    def one(self) -> tuple[Callable[[float], Five], Callable[[float], tuple[Any, ...]]]:
        """One solve forward, and one backward with both answers."""
        if find_spec("cffi") is None:
            return self._one_by_ctypes()
        import cffi

        ffi = cffi.FFI()
        ffi.cdef("void forward_one(double, double *); void backward_one(double, double *);")
        functions, five, ten = (
            ffi.dlopen(str(self.library)),
            ffi.new("double[5]"),
            ffi.new("double[10]"),
        )
        ahead, back, unpack = functions.forward_one, functions.backward_one, ffi.unpack

        def forward(theta: float) -> Five:
            ahead(theta, five)
            return unpack(five, 5)

        def backward(x: float) -> tuple[Any, ...]:
            back(x, ten)
            return unpack(ten, 10)

        return forward, backward

    def _one_by_ctypes(self) -> tuple[Callable[[float], Five], Callable[[float], tuple[Any, ...]]]:
        five, ten = (ctypes.c_double * 5)(), (ctypes.c_double * 10)()
        ahead, back = self._functions.forward_one, self._functions.backward_one
        ahead.argtypes = back.argtypes = (ctypes.c_double, ctypes.c_void_p)

        def forward(theta: float) -> Five:
            ahead(theta, five)
            return five[:]

        def backward(x: float) -> tuple[Any, ...]:
            back(x, ten)
            return ten[:]

        return forward, backward

    def rows(self, name: str, threads: int = 1) -> Callable[[Array], list[Array]]:
        """A loop over rows by its name in the C file, its rows shared out to threads."""
        loop = self._functions[name]
        loop.argtypes = (ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 6)
        loop.restype = None

        def run(column: Array) -> list[Array]:
            out = [np.empty(len(column)) for _ in range(5)]
            pointers = [array.ctypes.data for array in (column, *out)]
            if threads == 1:
                loop(0, len(column), *pointers)
                return out
            ends = [len(column) * part // threads for part in range(threads + 1)]
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(lambda k: loop(*ends[k : k + 2], *pointers), range(threads)))
            return out

        return run
