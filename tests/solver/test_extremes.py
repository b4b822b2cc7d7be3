"""Numbers at the ends of the floats, and unknowns with more whole turns than can be listed."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver import Result, Status


def solve(rules: str, variables: str = "", **inputs: Any) -> Result:
    text = f"variables\n{variables}\nrules\n{rules}\n" if variables else f"{rules}\n"
    return solver.solve(rulesheets.loads(text), inputs)


def test_a_step_that_overflows_in_floats_is_taken_in_more_digits() -> None:
    result = solve("w^2/x^1.5 = 0.25", x=1e240)
    assert [solution["w"] for solution in result.solutions] == pytest.approx(
        [5e179, -5e179], rel=1e-15
    )


def test_a_value_beyond_floats_is_not_called_impossible() -> None:
    result = solve("ln(x) = 800")
    assert str(result.status) == "failed"
    assert [diagnosis.code for diagnosis in result.diagnoses] == ["S551"]


def test_nothing_is_proven_absent_where_no_search_looks() -> None:
    result = solve("x - sin(x) = 1e200")
    assert str(result.status) != "infeasible"


def test_answers_of_any_size_are_put_in_order() -> None:
    result = solve("x^2 = 1e300", variables="x ~ 1")
    assert [solution["x"] for solution in result.solutions] == pytest.approx(
        [1e150, -1e150], rel=1e-15
    )
    assert str(solve("x^2/1e250 = 1e280", variables="x ~ 1e-150").status) == "solved"


def test_a_pole_that_floats_step_over_is_no_value() -> None:
    """tan(pi/2) has none, although the float next to π/2 has a tangent."""
    assert str(solve("tan(pi/2) = x").status) != "solved"


@pytest.mark.parametrize("term", ["0*z", "k*z", "z*0"])
def test_a_term_that_vanishes_leads_nowhere_and_proves_nothing(term: str) -> None:
    inputs = {"k": 0.0} if "k" in term else {}
    result = solve(f"d/z^4 = -0.125\n360*d + {term} = -720", **inputs)
    found = sorted(float(str(solution["z"])) for solution in result.solutions)
    assert found == pytest.approx([-2.0, 2.0], rel=1e-14)
    assert all(solution["d"] == -2.0 for solution in result.solutions)


def test_an_exponent_that_vanishes_leads_nowhere_and_proves_nothing() -> None:
    result = solve("c*exp(0*a) = 4\nc^0.5*a^2 = 18")
    assert sorted(float(str(solution["a"])) for solution in result.solutions) == pytest.approx(
        [-3.0, 3.0]
    )


def test_a_rule_that_does_not_depend_on_its_unknown_holds_to_rounding() -> None:
    """z comes from one rule; the other holds for it but for the last digit, whatever c is."""
    result = solve("7*z = 0.1\n0*c - pi*z = -pi*0.1/7\nc^3 = 8")
    assert str(result.status) == "solved"
    assert result["c"] == pytest.approx(2.0)


@pytest.mark.parametrize("exponent", [120, 200, 290])
def test_roots_of_polynomials_of_any_size(exponent: int) -> None:
    result = solve(f"((d - d) + d*d)^3 = 1e{exponent}")
    root = 10.0 ** (exponent / 6)
    assert [solution["d"] for solution in result.solutions] == pytest.approx(
        [root, -root], rel=1e-12
    )


def test_a_window_of_more_turns_than_can_be_counted() -> None:
    assert str(solve("sin(1e300*x) = 0.5", variables="x in [-10, 10]").status) != "infeasible"


def test_known_numbers_whose_square_overflows() -> None:
    assert str(solve("asin(d/z) = 2", z=1.7e308).status) != "solved"


def test_an_angle_tied_to_a_number_by_a_sum_is_no_mere_angle() -> None:
    """Whole turns of x make a difference to b, so that x is not looked for within one turn."""
    result = solve("b + x = 10\nsin(x) + b = 2")
    assert [solution["x"] for solution in result.solutions] == pytest.approx(
        [8.678736792814396], rel=1e-12
    )
    assert result["b"] == pytest.approx(2 - math.sin(8.678736792814396), rel=1e-12)


def test_constants_of_a_compiled_path_that_overflow() -> None:
    sheet = (
        "variables\nc = -2.2531715901509086e-69\nx ~ -6.76e+254\nd\nw\nrules\nw + d = -8.59e-93\n"
    )
    rules = (
        "((c + w)*x) + ((d/1e-3)*(c/x)) = 2.9741864989991993e+186\nd^-1 = -1.1641443538998836e+92\n"
    )
    plan = solver.prepare(rulesheets.loads(sheet + rules), inputs=["c"], want=["d", "w", "x"])
    for c in (-2.2531715901509086e-69, -2.253e-69, -2.3e-69):
        assert plan(c)[0] == pytest.approx(1 / -1.1641443538998836e92, rel=1e-14)


@settings(max_examples=15, deadline=None)
@given(
    st.integers(-250, 250),
    st.integers(-200, 200),
    st.sampled_from([(1, 2), (-1, 3), (0, 5), (-4, -1), (0, -7)]),
)
def test_quadratics_of_any_size_have_both_roots(
    level: int, size: int, roots: tuple[int, int]
) -> None:
    """a·(x − p)(x − q), in powers of 2: squares of its coefficients are no floats, its roots
    are."""
    one, other = sorted(r * 2.0**size for r in roots)
    a = 2.0 ** max(-1000, min(1000, level - 2 * size))
    b, c = -a * (one + other), a * one * other
    assume(all(number == 0.0 or 1e-300 < abs(number) < 1e300 for number in (a, b, c)))
    result = solver.solve(rulesheets.loads("a*x^2 + b*x + c = 0"), {"a": a, "b": b, "c": c})
    found = sorted(answer["x"] for answer in result.solutions)
    assert found == pytest.approx([one, other], rel=1e-13, abs=0.0)


@pytest.mark.parametrize("b", [1e-170, -3e-165, 1e-300])
def test_a_root_whose_square_is_below_floats_is_an_answer(b: float) -> None:
    result = solver.solve(rulesheets.loads("x^2 = b*x"), {"b": b})
    assert sorted(answer["x"] for answer in result.solutions) == sorted([0.0, b])


def test_a_rule_of_numbers_whose_inverse_is_no_float() -> None:
    text = "x = 1e-16\n(x - (d - 7))*1e150 = 1e-150\n(d - x)*4.9e-324 = 1e-16"
    assert str(solver.solve(rulesheets.loads(text)).status) == "inconsistent"


@settings(max_examples=12, deadline=None)
@given(st.integers(-20, 20), st.integers(-20, 20), st.sampled_from([1.0, 1.37, 7.2]))
def test_an_unknown_that_floats_lose_beside_the_other_is_no_reason_to_drop_an_answer(
    level: int, drop: int, leading: float
) -> None:
    """2 x² - s x = r² with a = 2 x - s: at the large root a is nothing beside x."""
    s, r = leading * 10.0**level, 10.0 ** (level - abs(drop))
    text = "a + x - 3*x = -s\nsqrt(a*x + (a - a)) = r"
    result = solver.solve(rulesheets.loads(text), {"s": s, "r": r})
    with mpmath.workdps(400):
        root = mpmath.sqrt(mpmath.mpf(s) ** 2 + 8 * mpmath.mpf(r) ** 2)
        expected = sorted(float((s + sign * root) / 4) for sign in (-1, 1))
    found = sorted(answer["x"] for answer in result.solutions)
    assert str(result.status) == "solved"
    assert found == pytest.approx(expected, rel=1e-12, abs=0.0) or not result.complete


@pytest.mark.parametrize(
    ("rules", "answer"),
    [
        ("0*x + y + 1e16*z = 0\n0.1*x + y + 0*z = 0\n0.1*x + y + z = 1", (1e17, -1e16, 1.0)),
        ("x + 1e-9*y = 0\ny + z = 0\n1e-9*x + y + z = 1", (1e9, -1e18, 1e18)),
    ],
)
def test_linear_rules_of_unlike_sizes_do_not_contradict(
    rules: str, answer: tuple[float, ...]
) -> None:
    result = solve(rules)
    assert result.status is Status.SOLVED
    assert [result[name] for name in "xyz"] == pytest.approx(answer, rel=1e-15)


@pytest.mark.parametrize(
    "rules",
    [
        "0*x + 0*y = 0\n0*x + 1e-9*y = -1e300",
        "0*x + y + 1e100*z = 0\n0*x + 0*y + z = -1e300\nx + 0*y + 0*z = 0",
    ],
)
def test_linear_rules_whose_answer_no_float_holds(rules: str) -> None:
    result = solve(rules)
    assert result.status is Status.FAILED
    assert [(note.code, note.variables) for note in result.diagnoses] == [("S551", ("y",))]


def test_rules_that_contradict_beside_the_largest_float() -> None:
    result = solve("0*x + 1*y + 0*z = 1\n(0*x + 1*y + 0*z)*1 = 1e308\n0*x + 0*y + 0*z = 0")
    assert result.status is Status.INCONSISTENT


@pytest.mark.parametrize("power", [3, 40])
def test_a_term_below_floats_does_not_stand_against_the_others(power: int) -> None:
    result = solve(f"x + b = b^{power}", b=1e-300)
    assert result.status is Status.SOLVED
    assert result["x"] == -1e-300


COEFFICIENTS = (0, 0, 1, -1, 3, "0.1", "-7.5", "1e-9", "1e16", "1e-16", "1e20", "-1e-20")
RIGHT_SIDES = (0, 1, "-0.3", "1e-9", "1e16", "1e20", "-1e-20")


def test_rules_that_contradict_as_they_are_written() -> None:
    """x = -1e-36*y, so that 1e16*x + z is 0; as floats its factors leave 1e-37 of it."""
    result = solve("1e20*x + 1e-16*y = 0\nz = 1e-20*y\n1e16*x + z = 1")
    assert result.status is Status.INCONSISTENT


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_linear_rules_with_answers_up_to_1e60(data: st.DataObject) -> None:
    """Some a multiple of another, so that they leave something free or contradict one another.

    Whether they do is a matter of the decimals as they are written: -1e-16 times 1e-20 is no float.
    """
    n = data.draw(st.integers(2, 3))
    rows = [[str(data.draw(st.sampled_from(COEFFICIENTS))) for _ in range(n)] for _ in range(n)]
    matrix = [[Fraction(float(a)) for a in row] for row in rows]
    factor = data.draw(st.sampled_from(("", "1", "-1", "-4.5", "1e20")))
    lefts = [" + ".join(f"{a}*{name}" for a, name in zip(row, "xyz", strict=False)) for row in rows]
    if factor:
        lefts[1] = f"({lefts[0]})*{factor}"
        matrix[1] = [a * Fraction(float(factor)) for a in matrix[0]]
    rights = [str(data.draw(st.sampled_from(RIGHT_SIDES))) for _ in range(n)]
    result = solve(
        "\n".join(f"{left} = {right}" for left, right in zip(lefts, rights, strict=True))
    )
    for solution in result.solutions:
        assert all(map(math.isfinite, solution.values()))
        for row, right in zip(matrix, rights, strict=True):
            read = [(a, solution.get(v)) for v, a in zip("xyz", row, strict=False) if a]
            if all(isinstance(number, float) for _, number in read):
                terms = [a * Fraction(number) for a, number in read]
                below = sum(abs(a) for a, _ in read) * Fraction(
                    2**-1022
                )  # of numbers that are no floats
                slack = Fraction(2**-46) * (sum(map(abs, terms)) + below)
                assert abs(sum(terms) - Fraction(float(right))) <= slack
    if result.status in (Status.INFEASIBLE, Status.INCONSISTENT):
        written = [[Fraction(a) for a in row] for row in rows]
        if factor:
            written[1] = [a * Fraction(factor) for a in written[0]]
        assert rank(written) < n


def rank(matrix: list[list[Fraction]]) -> int:
    found, rows = 0, [row[:] for row in matrix]
    for column in range(len(matrix[0])):
        top = next((row for row in rows if row[column]), None)
        if top is not None:
            rows.remove(top)
            rows = [
                [a - row[column] / top[column] * b for a, b in zip(row, top, strict=True)]
                for row in rows
            ]
            found += 1
    return found


@pytest.mark.parametrize(
    ("rule", "answer"),
    [("x = a/sqrt(a*b)", 1.0), ("x = atan2d(a*b, a*a)", 45.0), ("x = ln(a*a/b)", None)],
)
def test_a_known_number_that_is_0_for_want_of_smaller_floats_is_not_0(
    rule: str, answer: float | None
) -> None:
    result = solve(rule, a=1e-300, b=1e-300)
    assert result.status is Status.SOLVED
    assert result["x"] == pytest.approx(math.log(1e-300) if answer is None else answer, rel=1e-15)


@pytest.mark.parametrize(
    ("rule", "status"),
    [
        ("x = a/sqrt(a*b)", Status.SINGULAR),  # 0/0
        ("x = atan2d(a*b, a*a)", Status.INFEASIBLE),
        ("x = ln(a*b)", Status.INFEASIBLE),
    ],
)
def test_a_known_number_that_is_0_is(rule: str, status: Status) -> None:
    assert solve(rule, a=0.0, b=1e-300).status is status


def test_a_supplement_next_to_0_is_an_answer() -> None:
    """sin(-2) rounded, and the exact sine of y - 2 for two values of y in a turn."""
    with mpmath.workdps(60):
        principal = mpmath.asin(mpmath.mpf(-0.9092974268256817))
        expected = [2 + principal, 2 - mpmath.pi - principal]
    result = solve("sin(y - 2) = -0.9092974268256817")
    assert result.complete
    found = sorted(solution["y"] for solution in result.solutions)
    assert found == pytest.approx(sorted(float(y) for y in expected), rel=1e-15, abs=0.0)


def test_an_exponent_too_large_for_digits_stops_no_search() -> None:
    rules = "N = K*exp(ln(N0/K)*exp(-b*t))\ndN = b*N*ln(K/N)\ntinf = ln(ln(K/N0))/b"
    assert solve(rules, N0=500, K=20000, t=25, dN=630).status is Status.FAILED


@pytest.mark.parametrize("x", [700.0, 705.5, 708.0, 712.5, 717.0, 730.0, 744.0, 750.0])
def test_a_part_may_overflow_where_the_value_does_not(x: float) -> None:
    found = solver.solve(rulesheets.loads("y = 28/(1 + 28/(35*exp(-x)))"), {"x": x})
    with mpmath.workdps(40):
        exact = 28 / (1 + 28 / (35 * mpmath.exp(-mpmath.mpf(x))))
    assert str(found.status) == "solved"
    assert abs(found["y"] - exact) <= 2e-15 * exact + 5e-324
