"""Discriminants to twice the digits of a float, and what they keep near dead centre."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.nodes import Expression, Name, Negative, Number, Power, Product, Sum
from solver.compiled.array import ArrayKernel
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.native import NativeKernel, available
from solver.compiled.twofold import Twofold
from tests.oracles.slider_crank import Crank, crank_angles, forward

MODEL = Path(__file__).parents[3] / "models" / "offset_slider_crank" / "model.tk"
numbers = st.floats(-1e3, 1e3).map(lambda x: x if abs(x) > 1e-6 else 0.1)
polynomials = st.recursive(
    st.one_of(st.sampled_from([Name("x"), Name("y"), Name("c")]), numbers.map(Number)),
    lambda inside: st.one_of(
        st.builds(lambda a, b: Sum((a, b)), inside, inside),
        st.builds(lambda a, b: Sum((a, Negative(b))), inside, inside),
        st.builds(Product, inside, inside),
        st.builds(lambda a: Power(a, Number(2.0)), inside),
    ),
    max_leaves=5,
)


def exact(expression: Expression, values: Mapping[str, float]) -> tuple[Fraction, Fraction]:
    """The value, and that of the same expression with every term positive."""
    match expression:
        case Number(value):
            return Fraction(value), abs(Fraction(value))
        case Name(name):
            return Fraction(values[name]), abs(Fraction(values[name]))
        case Negative(operand):
            value, size = exact(operand, values)
            return -value, size
        case Sum(terms):
            pairs = [exact(term, values) for term in terms]
            return sum((v for v, _ in pairs), Fraction(0)), sum((s for _, s in pairs), Fraction(0))
        case Product(left, right):
            (a, m), (b, n) = exact(left, values), exact(right, values)
            return a * b, m * n
        case Power(base, _):
            value, size = exact(base, values)
            return value**2, size**2
        case _:
            raise AssertionError(expression)


@settings(max_examples=40, deadline=None)
@given(polynomials, numbers, numbers, numbers)
def test_a_polynomial_has_twice_the_digits(expression: Expression, x: float, y: float, c: float) -> None:
    flow = Flow()
    pair = Twofold(flow).pair(expression, {"x": flow.input(0), "y": flow.input(1), "c": flow.constant(c)})
    value, size = exact(expression, {"x": x, "y": y, "c": c})
    for kernel in (ArrayKernel, *([NativeKernel] if available() else [])):
        found = [np.empty(1), np.empty(1)]
        kernel(flow, pair)([np.array([x]), np.array([y])], found)
        total = Fraction(float(found[0][0])) + Fraction(float(found[1][0]))
        assert abs(total - value) <= size * Fraction(1, 2**97) + Fraction(1, 10**300)


def test_only_polynomials_of_exact_numbers_are_taken() -> None:
    flow = Flow()
    values = {"x": flow.add("sqrt", flow.input(0)), "c": flow.call("cosd", flow.constant(7.0))}
    for expression in (Name("x"), Name("c"), rulesheets.loads("z = sind(x)\n").equations[0].right):
        with pytest.raises(NotCompilable):
            Twofold(flow).pair(expression, values)


WANT = ("thetaAO", "thetaAB", "omegaAB", "vB", "aB", "alphaAB")
END = math.sqrt((3.0 + 8.0) ** 2 - 4.0)
"""Of the stroke of the slider; the rod and the crank are in line there."""


def states(x: float) -> list[dict[str, Any]]:
    angles = crank_angles(3.0, 8.0, 2.0, x)
    found = [(angle, forward(Crank(3.0, 8.0, 2.0, -15.0, -10.0, angle))) for angle in angles]  # type: ignore[arg-type]
    return [{"thetaAO": angle, **{name: state[name] for name in WANT[1:]}} for angle, state in found]


def error(row: tuple[Any, ...], modes: list[dict[str, Any]]) -> float:
    """The worst relative error of a row, beside the mode that it is of."""
    with mpmath.workdps(50):
        return min(
            max(float(abs(_apart(name, row[k], mode[name]) / mode[name])) for k, name in enumerate(WANT))
            for mode in modes
        )


def _apart(name: str, found: float, exact: Any) -> Any:
    apart = mpmath.mpf(float(found)) - exact
    return apart - 360 * mpmath.nint(apart / 360) if name.startswith("theta") else apart


def test_all_digits_are_kept_on_the_way_to_dead_centre() -> None:
    """Against fifty digits, at relative distances of 1e-1 … 1e-15 from it: calls, arrays and machine code."""
    positions = [END * (1.0 - distance) for distance in (1e-1, 1e-3, 1e-5, 1.3e-6, 1e-7, 1e-15)]
    modes = [states(x) for x in positions]
    plan = solver.prepare(rulesheets.load(MODEL), ["xB"], WANT, {"thetaAO": None})
    plan.all(9.79)
    for x, exact_modes in zip(positions, modes, strict=True):
        rows = plan.all(x)
        assert len(rows) == 2
        assert max(error(row, exact_modes) for row in (plan(x), *rows)) <= 1e-12
    for jit in (False, True) if available() else (False,):
        table = plan.sweep(positions, jit=jit)
        codes, answers = plan.sweep_all(positions, jit=jit)
        assert not table.status.any() and not codes.any() and set(answers.counts) == {2}
        for place, exact_modes in enumerate(modes):
            assert error(tuple(table[name][place] for name in WANT), exact_modes) <= 1e-12
            for at in (2 * place, 2 * place + 1):
                assert error(tuple(column[at] for column in answers.values), exact_modes) <= 1e-12
