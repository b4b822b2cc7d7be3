"""Rules that touch in the decimals in which they are written, though doubles miss each other by an
ulp."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

import mpmath
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import rulesheets
import solver

FORMS = (
    "x^2 - {two}*x + {square} = 0",
    "x + {square}/x = {two}",
    "x + y = {two}\nx*y = {square}",
    "y = x^2\ny = {two}*x - {square}",
    "3*x^2 + 3*{square} = 3*{two}*x",
)


@given(st.integers(11, 999), st.sampled_from(FORMS))
def test_a_double_root_of_decimals_is_singular(number: int, form: str) -> None:
    r = Decimal(number) / 100
    result = solver.solve(rulesheets.loads(f"rules\n{form.format(two=2 * r, square=r * r)}\n"))
    assert result.status is solver.Status.SINGULAR
    assert [answer["x"] for answer in result.solutions] == [pytest.approx(float(r), rel=1e-15)]


@given(st.integers(11, 999), st.sampled_from(FORMS), st.sampled_from(("1e-12", "-1e-12")))
def test_a_last_decimal_decides(number: int, form: str, beside: str) -> None:
    r = Decimal(number) / 100
    square = r * r + Decimal(beside)
    assume(len(square.as_tuple().digits) <= 15)
    result = solver.solve(rulesheets.loads(f"rules\n{form.format(two=2 * r, square=square)}\n"))
    assert result.status is (solver.Status.INFEASIBLE if square > r * r else solver.Status.SOLVED)
    if result.solutions:
        root = float((r * r - square).sqrt())
        assert sorted(a["x"] for a in result.solutions) == pytest.approx(
            [float(r) - root, float(r) + root]
        )


@given(st.integers(11, 999))
def test_given_decimals_touch_as_written_ones_do(number: int) -> None:
    r = Decimal(number) / 100
    model = rulesheets.loads("x^2 - p*x + q = 0\n")
    result = solver.solve(model, {"p": float(2 * r), "q": float(r * r)})
    assert result.status is solver.Status.SINGULAR
    assert result["x"] == pytest.approx(float(r), rel=1e-15)


def expanded(roots: Sequence[Decimal]) -> list[Decimal]:
    """The coefficients of (x - r)(x - s) …, highest degree first."""
    found = [Decimal(1)]
    for r in roots:
        found = [a - r * b for a, b in zip([*found, Decimal(0)], [Decimal(0), *found], strict=True)]
    return found


ROOTS = st.integers(-99, 99).filter(bool).map(lambda number: Decimal(number) / 10)


@given(ROOTS, ROOTS, st.sampled_from(("rrr", "rrrr", "rrrs", "rrss", "rrs")), st.booleans())
def test_a_root_of_any_multiplicity_is_what_decimals_say(
    r: Decimal, s: Decimal, form: str, told: bool
) -> None:
    assume(abs(r - s) > Decimal("0.5"))
    coefficients = expanded([{"r": r, "s": s}[root] for root in form])
    powers = range(len(form), -1, -1)
    names = [f"c{k}" if told else f"({c})" for k, c in zip(powers, coefficients, strict=True)]
    rule = " + ".join(f"{name}*x^{k}" if k else name for name, k in zip(names, powers, strict=True))
    given_ = {name: float(c) for name, c in zip(names, coefficients, strict=True)} if told else {}
    result = solver.solve(rulesheets.loads(f"rules\n{rule} = 0\n"), given_)
    expected = sorted({float(r), float(s)} if "s" in form else {float(r)})
    assert sorted(answer["x"] for answer in result.solutions) == pytest.approx(expected, rel=1e-9)
    simple_first = form.count("s") == 1 and result["x"] == pytest.approx(float(s))
    assert result.status is (solver.Status.SOLVED if simple_first else solver.Status.SINGULAR)


@given(st.floats(1.0, 100.0), st.floats(0.01, 1.0))
def test_a_square_is_not_negative_by_rounding_alone(one: float, other: float) -> None:
    """Half a unit of the last place of z decides whether there are two values of x or none."""
    z = abs(one - 1.0 / other)
    with mpmath.workdps(50):
        square = mpmath.mpf(z) ** 2 - (one - 1 / mpmath.mpf(other)) ** 2
        assume(-0.9 * z * z * 2.0**-52 < square < 0.0)
    rules = f"rules\nz = sqrt(x^2 + (a - 1/b)^2)\na = {one!r}\nb = {other!r}\nz = {z!r}\n"
    assert solver.solve(rulesheets.loads(rules)).status is solver.Status.SINGULAR
