"""Other solvers on the same equations: scipy, casadi, gekko and sympy, by name.

Those that are not installed are left out, and named. scipy's and sympy's get the exact Jacobian.
Every search runs in a process of its own, so that one that hangs or crashes is ended and counted.
"""

from __future__ import annotations

import importlib
import math
import multiprocessing
import os
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any, TypeAlias

Vector: TypeAlias = Sequence[float]


@dataclass(frozen=True)
class Equations:
    """``residuals(x, m)`` in n unknowns, by the functions of a namespace m (see
    ``standard.Residuals``)."""

    residuals: Callable[[Sequence[Any], Any], list[Any]]
    n: int


@dataclass(frozen=True)
class End:
    """What a solver returned: whether it calls that a root, and the processor time. No x: it
    raised."""

    success: bool
    x: tuple[float, ...] | None
    seconds: float
    said: str = ""


Solve: TypeAlias = Callable[[Equations, Vector], "tuple[bool, Sequence[float] | None]"]

NOT_TRIED = "not tried"
MOST_FOR_SYMPY = 4
"""Unknowns up to which ``sympy.nsolve`` is tried: it works in multiple precision and takes seconds
beyond."""


def peers() -> dict[str, Solve]:
    """The solvers that are installed, by name."""
    everyone: dict[str, tuple[str, Solve]] = {
        "scipy hybr": ("scipy", lambda e, s: _scipy_root(e, s, "hybr")),
        "scipy lm": ("scipy", lambda e, s: _scipy_root(e, s, "lm")),
        "scipy least_squares": ("scipy", _scipy_least_squares),
        "casadi newton": ("casadi", lambda e, s: _casadi(e, s, "newton")),
        "casadi fast_newton": ("casadi", lambda e, s: _casadi(e, s, "fast_newton")),
        "casadi kinsol": ("casadi", lambda e, s: _casadi(e, s, "kinsol")),
        "gekko": ("gekko", _gekko),
        "sympy nsolve": ("sympy", _sympy),
    }
    found = {
        name: solve for name, (package, solve) in everyone.items() if find_spec(package) is not None
    }
    for package in {everyone[name][0] for name in found} | {"scipy.optimize"}:
        importlib.import_module(package)  # once, so that no search pays for it
    return found


def absent() -> list[str]:
    return [name for name in ("scipy", "casadi", "gekko", "sympy") if find_spec(name) is None]


def run(solve: Solve, equations: Equations, start: Vector, limit: float = 120.0) -> End:
    """One search in a forked process, ended after ``limit`` seconds by the clock."""
    receiver, sender = multiprocessing.get_context("fork").Pipe(duplex=False)

    def child() -> None:
        warnings.simplefilter("ignore")
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1), os.dup2(silent, 2)
        began = time.process_time()
        try:
            success, x = solve(equations, start)
            found = None if x is None else tuple(float(v) for v in x)
            finite = found is not None and all(map(math.isfinite, found))
            sender.send(
                End(
                    bool(success) and finite, found if finite else None, time.process_time() - began
                )
            )
        except NotImplementedError as reason:
            sender.send(End(False, None, math.nan, f"{NOT_TRIED}: {reason}"))
        except Exception as error:
            said = f"{type(error).__name__}: {error}".splitlines()[0][:100]
            sender.send(End(False, None, time.process_time() - began, said))

    process = multiprocessing.get_context("fork").Process(target=child, daemon=True)
    process.start()
    sender.close()
    if receiver.poll(limit):
        try:
            end: End = receiver.recv()
        except EOFError:
            end = End(False, None, math.nan, "crashed")
    else:
        end = End(False, None, limit, "time limit")
        process.kill()
    process.join()
    return end


# --- the functions that systems are made of, for each of them ---


_SHARED = ("exp", "sin", "cos", "atan", "sqrt")


def _functions(
    module: Any, pi: Any, where: Callable[..., Any], expm1_over: Callable[..., Any]
) -> Any:
    """The functions of a module under the names that the systems use."""
    shared = {name: getattr(module, name) for name in _SHARED}
    return SimpleNamespace(**shared, pi=pi, where=where, expm1_over=expm1_over)


def _chosen(v: Any, positive: Any, negative: Any) -> Any:
    return positive if v > 0 else negative


def numbers() -> Any:
    """For Python floats."""
    return _functions(math, math.pi, _chosen, lambda v: -math.expm1(-v * v) / v if v else 0.0)


def digits() -> Any:
    """For mpmath, at its working precision."""
    import mpmath

    return _functions(
        mpmath, mpmath.pi, _chosen, lambda v: -mpmath.expm1(-v * v) / v if v else mpmath.mpf(0)
    )


def _symbols() -> Any:
    import sympy

    return _functions(
        sympy,
        sympy.pi,
        lambda v, positive, negative: sympy.Piecewise((positive, v > 0), (negative, True)),
        lambda v: (1 - sympy.exp(-v * v)) / v,
    )


@cache
def symbolic(equations: Equations) -> tuple[Any, Any, Any]:
    """Unknowns, residuals (n, 1) and Jacobian (n, n) of sympy."""
    import sympy

    x = sympy.symbols(f"x1:{equations.n + 1}", real=True)
    residuals = sympy.Matrix([sympy.sympify(r) for r in equations.residuals(x, _symbols())])
    return x, residuals, residuals.jacobian(x)


@cache
def compiled(equations: Equations) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Residuals (n,) and Jacobian (n, n) on numpy arrays."""
    import numpy
    import sympy

    x, residuals, jacobian = symbolic(equations)
    both = (
        sympy.lambdify([x], residuals.T, "numpy", cse=True),
        sympy.lambdify([x], jacobian, "numpy", cse=True),
    )

    def values(v: Any) -> Any:
        return numpy.asarray(both[0](v), dtype=float).ravel()

    def slopes(v: Any) -> Any:
        return numpy.asarray(both[1](v), dtype=float).reshape(equations.n, equations.n)

    return values, slopes


# --- the solvers ---


def _scipy_root(equations: Equations, start: Vector, method: str) -> tuple[bool, Sequence[float]]:
    from scipy.optimize import root

    values, slopes = compiled(equations)
    found = root(values, start, jac=slopes, method=method, tol=1e-13)
    return found.success, found.x


def _scipy_least_squares(equations: Equations, start: Vector) -> tuple[bool, Sequence[float]]:
    """Success is what it says of itself: a minimum of the sum of squares, small or not."""
    from scipy.optimize import least_squares

    values, slopes = compiled(equations)
    found = least_squares(
        values, start, jac=slopes, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=2000
    )
    return found.success, found.x


def _casadi(equations: Equations, start: Vector, plugin: str) -> tuple[bool, Sequence[float]]:
    import casadi

    x = casadi.SX.sym("x", equations.n)
    functions = _functions(
        casadi,
        math.pi,
        lambda v, positive, negative: casadi.if_else(v > 0, positive, negative),
        lambda v: casadi.if_else(v == 0, 0, -casadi.expm1(-v * v) / v),
    )
    residuals = casadi.vertcat(*equations.residuals([x[j] for j in range(equations.n)], functions))
    settings = {"error_on_fail": True} if plugin != "fast_newton" else {}
    finder = casadi.rootfinder("finder", plugin, {"x": x, "g": residuals}, settings)
    found = finder(x0=list(start), p=[])["x"]
    return bool(finder.stats().get("success", True)), [float(v) for v in found.full().ravel()]


def _gekko(equations: Equations, start: Vector) -> tuple[bool, Sequence[float]]:
    from gekko import GEKKO

    model = GEKKO(remote=False)
    x = [model.Var(value=v) for v in start]
    functions = _functions(
        model,
        math.pi,
        lambda v, positive, negative: model.if2(v, negative, positive),
        lambda v: (1 - model.exp(-v * v)) / v,
    )
    for residual in equations.residuals(x, functions):
        model.Equation(residual == 0)
    model.options.RTOL = model.options.OTOL = 1e-10
    model.solve(disp=False)
    return model.options.APPSTATUS == 1, [v.value[0] for v in x]


def _sympy(equations: Equations, start: Vector) -> tuple[bool, Sequence[float] | None]:
    import sympy

    if equations.n > MOST_FOR_SYMPY:
        raise NotImplementedError(f"more than {MOST_FOR_SYMPY} unknowns")
    x, residuals, _ = symbolic(equations)
    found = sympy.nsolve(list(residuals), x, list(start))
    return True, [float(v) for v in (found if equations.n > 1 else [found])]
