"""Peers on the equations and on the closed form: scipy, casadi, jax, sympy, as far as installed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.speed import symbols
from benchmarks.speed.task import NEARBY

PEERS = ("numba", "cffi", "casadi", "jax")


def absent() -> list[str]:
    """Peers that are not installed."""
    return [name for name in PEERS if find_spec(name) is None]


def fsolve(direction: str, with_jacobian: bool) -> Callable[..., Any]:
    """``f(number)`` gives the five unknowns, from a point nearby or a ``start``."""
    jacobian = symbols.jacobian(direction) if with_jacobian else None
    solve, nearby = fsolve_on(symbols.residuals(direction), jacobian), np.array(NEARBY[direction])
    return lambda number, start=nearby: solve(number, start)


def fsolve_on(
    residual: Callable[..., Any], jacobian: Callable[..., Any] | None
) -> Callable[[float, Any], Any]:
    """``f(number, start)`` gives the unknowns of ``residual(number, *unknowns)``, with its
    ``jacobian`` or without; raises ArithmeticError where fsolve says that it has none."""
    from scipy.optimize import fsolve

    def solve(number: float, start: Any) -> Any:
        slopes = None if jacobian is None else lambda u: jacobian(number, *u.tolist())
        found, _, outcome, said = fsolve(
            lambda u: residual(number, *u.tolist()), start, fprime=slopes, full_output=True
        )
        if outcome != 1:
            raise ArithmeticError(said)
        return found

    return solve


def nsolve(direction: str) -> Callable[[float], Any]:
    import sympy as sp

    equations = symbols.equations(direction)

    def solve(number: float) -> Any:
        here = [e.subs(symbols.INPUT, number) for e in equations]
        return sp.nsolve(here, symbols.UNKNOWNS, NEARBY[direction])

    return solve


@cache
def _casadi(direction: str) -> tuple[Any, Any, Any, Any]:
    """Symbols and the same expressions in casadi: input, closed form, unknowns, equations."""
    import casadi
    import sympy as sp

    modules = [{name: getattr(casadi, name) for name in ("sin", "cos", "sqrt", "acos", "atan2")}]
    x, u = casadi.SX.sym("x"), casadi.SX.sym("u", 5)
    closed = sp.lambdify(symbols.INPUT, symbols.closed_form(direction), modules, cse=True)(x)
    zeros = sp.lambdify(
        (symbols.INPUT, *symbols.UNKNOWNS), symbols.equations(direction), modules, cse=True
    )
    return x, casadi.vertcat(*closed), u, casadi.vertcat(*zeros(x, *casadi.vertsplit(u)))


def casadi_function(direction: str) -> Callable[[Any], Any]:
    import casadi

    x, closed, _, _ = _casadi(direction)
    function: Callable[[Any], Any] = casadi.Function("closed", [x], [closed])
    return function


def casadi_map(direction: str, rows: int) -> Callable[[Any], Any]:
    mapped = casadi_function(direction).map(rows)  # type: ignore[attr-defined]
    return lambda column: mapped(column.reshape(1, -1)).full()


def casadi_rootfinder(direction: str) -> Callable[[float], Any]:
    import casadi

    x, _, u, equations = _casadi(direction)
    find = casadi.rootfinder("find", "newton", {"x": u, "p": x, "g": equations})
    start = casadi.DM(NEARBY[direction])
    return lambda number: find(start, number)


def jax_function(direction: str) -> Callable[[Any], Any]:
    import jax
    import sympy as sp

    jax.config.update("jax_enable_x64", True)
    names = {"sin": "sin", "cos": "cos", "sqrt": "sqrt", "acos": "arccos", "atan2": "arctan2"}
    modules = [{name: getattr(jax.numpy, theirs) for name, theirs in names.items()}]
    compiled = jax.jit(
        sp.lambdify(symbols.INPUT, symbols.closed_form(direction), modules, cse=True)
    )
    return lambda x: jax.block_until_ready(compiled(x))
