"""A limit that is only approached, asked for by its decimals: the last digits of floats lead to no
answer of 1e17."""

from __future__ import annotations

from decimal import Decimal

from hypothesis import given
from hypothesis import strategies as st

import rulesheets
import solver

decimals = st.builds(
    lambda digits, places: Decimal(digits).scaleb(-places), st.integers(1, 999), st.integers(0, 3)
)


def status(text: str, **inputs: Decimal) -> str:
    given_numbers = {name: float(number) for name, number in inputs.items()}
    return str(solver.solve(rulesheets.loads(text), given_numbers).status)


@given(rate=decimals, free=st.integers(1, 200), per=st.sampled_from([1, 12, 100, 365]))
def test_the_average_rate_of_a_tax_stays_below_its_rate(rate: Decimal, free: int, per: int) -> None:
    text = f"tax = {rate}*(income - {100 * free})\naverage = {per}*tax/income"
    assert status(text, average=per * rate) == "infeasible"


@given(most=decimals, half=decimals, share=st.sampled_from([1, 2, 4, 5, 8, 10, 25, 40]))
def test_a_saturated_rate_has_no_concentration(most: Decimal, half: Decimal, share: int) -> None:
    text = f"rate = {most}*c/({share}*c + {half})"
    assert status(text, rate=most / share) == "infeasible"


APPROACHES_ONE = (
    *("tanh(t/{k})", "erf(t/{k})", "1 - exp(-t/{k})", "t/({k} + t)", "atand(t/{k})/90"),
    *("sqrt(1 - 1/(t*{k}))", "1 - {k}/t^2", "t/sqrt(t^2 + {k})"),
)


@given(most=decimals, factor=decimals, scale=decimals, form=st.sampled_from(APPROACHES_ONE))
def test_what_is_approached_is_not_attained(
    most: Decimal, factor: Decimal, scale: Decimal, form: str
) -> None:
    text = f"v = {most}*U*({form.format(k=scale)})"
    assert status(text, v=most * factor, U=factor) == "infeasible"


@given(total=decimals, part=decimals, factor=decimals)
def test_nothing_is_left_of_decimals_that_cancel(
    total: Decimal, part: Decimal, factor: Decimal
) -> None:
    model = rulesheets.loads(f"all = {part}*{factor} + {total}*rest\nrest = share^2")
    result = solver.solve(model, {"all": float(part * factor)})
    assert [(s["rest"], s["share"]) for s in result.solutions] == [(0.0, 0.0)]


@given(most=decimals, half=decimals, factor=decimals)
def test_a_saturated_rate_that_is_computed_is_no_answer(
    most: Decimal, half: Decimal, factor: Decimal
) -> None:
    """Its last place may be off by what the numbers of the rules are."""
    text = f"rate = {most}*c/(0.7*c + {half})\n{factor * Decimal('0.7')}*rate = {factor * most}"
    assert status(text) != "solved"


@given(most=decimals, half=decimals, below=st.integers(1, 10**9))
def test_next_to_the_limit_there_is_one(most: Decimal, half: Decimal, below: int) -> None:
    rate = most * (1 - Decimal(below).scaleb(-12))
    text = f"rate = {most}*c/(c + {half})"
    result = solver.solve(rulesheets.loads(text), {"rate": float(rate)})
    assert result.complete
    (answer,) = result.solutions
    exact = half * Decimal(float(rate)) / (Decimal(float(most)) - Decimal(float(rate)))
    assert abs(Decimal(answer["c"]) / exact - 1) < Decimal("1e-3")
