"""The slider crank in sympy: its closed form, and the equations that solvers are given."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import sympy as sp

from benchmarks.speed.closed_forms import AB, ALPHA, AO, OFFSET, OMEGA

INPUT = sp.Symbol("input", real=True)
UNKNOWNS = sp.symbols("u0:5", real=True)


def closed_form(direction: str, every: bool = False) -> list[Any]:
    """Five expressions of the input; with ``every`` both answers backward, one after the other."""
    if direction == "forward":
        return _forward(INPUT * sp.pi / 180)
    lesser = _backward(-1)
    return [*lesser, *_backward(1)] if every else lesser


def _forward(t: Any) -> list[Any]:
    xA, yA = AO * sp.cos(t), AO * sp.sin(t)
    dx = sp.sqrt(AB**2 - (OFFSET - yA) ** 2)
    return [xA + dx, *_rates(xA, yA, dx)]


def _backward(sign: int) -> list[Any]:
    distance = sp.sqrt(INPUT**2 + OFFSET**2)
    swing = sp.acos((AO**2 + distance**2 - AB**2) / (2 * AO * distance))
    t = sp.atan2(OFFSET, INPUT) + sign * swing
    xA, yA = AO * sp.cos(t), AO * sp.sin(t)
    return [t * 180 / sp.pi, *_rates(xA, yA, INPUT - xA)]


def _rates(xA: Any, yA: Any, dx: Any) -> list[Any]:
    dy = OFFSET - yA
    omega = -OMEGA * xA / dx
    xa1, ya1 = -(OMEGA**2) * xA - ALPHA * yA, -(OMEGA**2) * yA + ALPHA * xA
    alpha = (omega**2 * dy - ya1) / dx
    return [-OMEGA * yA - omega * dy, omega, xa1 - omega**2 * dx - alpha * dy, alpha]


def equations(direction: str) -> list[Any]:
    """Five expressions of the input and the unknowns (in the order of the outputs) that must be
    zero."""
    first, v, omega, a, alpha = UNKNOWNS
    theta, x = (INPUT, first) if direction == "forward" else (first, INPUT)
    t = theta * sp.pi / 180
    xA, yA = AO * sp.cos(t), AO * sp.sin(t)
    dx, dy = x - xA, OFFSET - yA
    xa1, ya1 = -(OMEGA**2) * xA - ALPHA * yA, -(OMEGA**2) * yA + ALPHA * xA
    return [
        dx**2 + dy**2 - AB**2,
        v + OMEGA * yA + omega * dy,
        OMEGA * xA + omega * dx,
        a - xa1 + omega**2 * dx + alpha * dy,
        ya1 - omega**2 * dy + alpha * dx,
    ]


@cache
def residuals(direction: str) -> Callable[..., Any]:
    """Floats in (the input, then the unknowns), a list of five out."""
    return sp.lambdify((INPUT, *UNKNOWNS), equations(direction), "math", cse=True)


@cache
def jacobian(direction: str) -> Callable[..., Any]:
    """The same, out come five lists of derivatives by the unknowns."""
    rows = sp.Matrix(equations(direction)).jacobian(sp.Matrix(UNKNOWNS)).tolist()
    return sp.lambdify((INPUT, *UNKNOWNS), rows, "math", cse=True)


def function(direction: str, modules: str, every: bool = False) -> Callable[..., Any]:
    """The closed form by ``lambdify`` with common subexpressions shared."""
    return sp.lambdify(INPUT, closed_form(direction, every), modules, cse=True)
