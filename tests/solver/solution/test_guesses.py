"""A guess says which answer comes first; what is an answer depends on no guess."""

from __future__ import annotations

from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

PISTON = rulesheets.load("piston_engine")
DRIVEN = {"vP": -9.4392776642657, "phi": None}
"""Two directions of the guide have this speed; with one of them, three numbers are 0."""


@cache
def unguessed() -> solver.Result:
    return solver.solve(PISTON, DRIVEN)


@settings(max_examples=20, deadline=None)
@given(
    st.sampled_from(["yP", "yp", "yp1", "phi", "sP", "omegaBP"]),
    st.floats(-20.0, 8.0),
    st.sampled_from([1.0, -1.0]),
)
def test_a_guess_of_any_size_leaves_the_answers_as_they_are(
    name: str, power: float, sign: float
) -> None:
    alone = unguessed()
    assert alone.complete and len(alone.solutions) == 2
    guessed = solver.solve(PISTON, DRIVEN, guesses={name: sign * 10.0**power})
    assert guessed.complete
    assert sorted(s["phi"] for s in guessed.solutions) == pytest.approx(
        sorted(s["phi"] for s in alone.solutions), abs=1e-9
    )


@pytest.mark.parametrize("answer", [0, 1])
def test_the_numbers_of_an_answer_lead_back_to_it(answer: int) -> None:
    """What rounding leaves of a 0 is a guess like any other."""
    found = unguessed().solutions[answer]
    numbers = {n: v for n, v in found.items() if isinstance(v, float) and n not in ("vP", "OB")}
    again = solver.solve(PISTON, DRIVEN, guesses=numbers)
    assert len(again.solutions) == 2
    assert again["phi"] == pytest.approx(found["phi"], abs=1e-9)
