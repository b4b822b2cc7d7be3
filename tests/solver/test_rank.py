"""Rank within rounding: what drops out, or repeats itself, but for the last places of its
numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rulesheets
import solver

MODELS = Path(__file__).parent.parent.parent / "models"


def solved(text: str, inputs: dict[str, Any] | None = None) -> Any:
    return solver.solve(rulesheets.loads(text), inputs)


REPEATED = {
    "sums": ("x + y = 26.1\n3*x + 3*y = 78.3", {"x", "y"}),
    "coefficients": ("0.1*x + 0.3*y = 1\n0.7*x + 2.1*y = 7", {"x", "y"}),
    "quotients": ("x/3 + y/7 = 1\n7*x + 3*y = 21", {"x", "y"}),
    "three": ("x + y = 0.1\ny + z = 0.2\nx - z = -0.1", {"x", "y", "z"}),
    "three combined": ("x + y + z = 0.7\nx - y + 2*z = 0.1\n7*x - y + 11*z = 2.5", {"x", "y", "z"}),
    "one of three determined": ("x + y + z = 0.1\nx - y + z = 0.2\n2*x + 2*z = 0.3", {"x", "z"}),
    "large terms that cancel": ("1e9 + x + y = 1e9 + 0.1\nx + y = 0.1", {"x", "y"}),
    "products": ("x*y = 0.3\nx*y = 0.1*3", {"x", "y"}),
    "quotient and product": ("x/y = 0.7\n10*x = 7*y", {"x", "y"}),
    "computed coefficients": ("k = 0.1*3\nj = 0.3\nk*x + y = 1\nj*x + y = 1", {"x", "y"}),
    "tuples": ("(x + y, 3*x + 3*y) = (26.1, 78.3)", {"x", "y"}),
    "work of an Otto cycle, whatever the air enters at": (
        "r = 8\nb = r^0.4\nt = s*b\n1800 = 0.718*(u - t)\nv = u/b\n"
        "w = 1800 - 0.718*(v - s)\nw = 1016.5044930334881",
        {"s", "t", "u", "v"},
    ),
}


@pytest.mark.parametrize(("text", "free"), REPEATED.values(), ids=REPEATED)
def test_rules_that_repeat_one_another_but_for_rounding(text: str, free: set[str]) -> None:
    result = solved(text)
    assert str(result.status) in {"partial", "singular"}
    assert set(result.undetermined) == free
    assert {d.code for d in result.diagnoses} <= {"S511", "S542"}


AGREEING = {
    "a sum": "a = 0.1 + 0.2\na = 0.3",
    "by way of others": "b = 0.1\nc = 0.2\na = b + c\na = 0.3",
    "tuples": "(a, y) = (0.1 + 0.2, 0.7)\n(a, y) = (0.3, 0.1*7)",
    "a digit lost on the way": "d = (1e6 + a) - 1e6\nd = a\na = 0.3",
    "digits lost on the way": "d = 1e9*((1 + 1e-9*a) - 1)\na = 0.3\nd = a",
}


@pytest.mark.parametrize("text", AGREEING.values(), ids=AGREEING)
def test_checks_that_agree_but_for_rounding(text: str) -> None:
    result = solved(text)
    assert str(result.status) == "solved"
    assert result["a"] == pytest.approx(0.3, rel=1e-15)


CONTRADICTING = (
    "x + y = 26.1\n3*x + 3*y = 78.3000001",
    "x + y = 1\nx + y = 1.000000001",
    "a = 0.3\na = 0.3000000003",
    "0.1*x + 0.3*y = 1\n0.7*x + 2.1*y = 7.000000007",
)


@pytest.mark.parametrize("text", CONTRADICTING)
def test_small_contradictions_are_real_and_name_both_rules(text: str) -> None:
    result = solved(text)
    assert str(result.status) == "inconsistent"
    assert [label.span.line for label in result.diagnoses[0].labels] == [1, 2]


DROPPED = {
    "a difference": "k = 0.1*3\nj = 0.3\n(k - j)*V = 0",
    "on both sides": "k = 0.1*3\nj = 0.3\nk*V = j*V",
    "computed before": "k = 0.1*3\nj = 0.3\nd = k - j\nd*V = 0",
    "what it is divided by, too": "k = 0.1*3\nj = 0.3\nd = k - j\nd*V = k - 0.3",
}


@pytest.mark.parametrize("text", DROPPED.values(), ids=DROPPED)
def test_unknown_that_is_multiplied_by_nothing_but_rounding(text: str) -> None:
    result = solved(text)
    assert str(result.status) == "singular"
    assert result.undetermined == ("V",)
    assert result.diagnoses[0].variables == ("V",)


def test_matrix_that_is_singular_but_for_exact_numbers_is_solved() -> None:
    """1/2, 1/4 and 2^-40 have no last places: the answer rests on what was said."""
    small = 2.0**-40
    result = solved(f"x + y = 2\nx + (1 + e)*y = 2 + e\ne = {small!r}")
    assert str(result.status) == "solved"
    assert (result["x"], result["y"]) == (1.0, 1.0)


@pytest.mark.parametrize("given", [("e", "M", "E"), ("e", "M", "nu"), ("M", "E", "nu")])
def test_orbit_whose_size_nothing_tells(given: tuple[str, ...]) -> None:
    """Angles and shape alone: the equations for size and distance are homogeneous, and repeat one
    another."""
    sheet = rulesheets.load(MODELS / "kepler" / "model.tk")
    known = solver.solve(sheet, {"e": 0.1, "E": 40.0, "M": None, "a": 1.5})
    result = solver.solve(
        sheet, {"a": None, "e": None, "M": None, **{name: known[name] for name in given}}
    )
    assert str(result.status) == "singular"
    assert set(result.undetermined) == {"a", "r"}


@pytest.mark.parametrize("units", [-9, -2, -1, 0, 1, 3, 40])
def test_scale_that_two_slopes_leave_free(units: int) -> None:
    """Two numbers that say the same to a few units of the last place: no length follows, let alone
    0."""
    slope = 0.7391
    other = slope + units * 2.0**-53
    for sheet in ("y = s*x\ny = c*x", "variables\n s\n c\n x > 0\n y\nrules\n y = s*x\n y = c*x"):
        result = solved(sheet, {"s": slope, "c": other})
        assert str(result.status) in {"partial", "singular"}
        assert set(result.undetermined) == {"x", "y"}
        assert not result.complete


def test_scale_is_0_where_slopes_differ_by_more_than_rounding() -> None:
    result = solved(
        "variables\n s\n c\n x > 0\n y\nrules\n y = s*x\n y = c*x", {"s": 0.7, "c": 0.7000000007}
    )
    assert str(result.status) == "infeasible"


def test_root_that_leads_to_a_contradiction_says_nothing_of_the_other() -> None:
    """x is 2 or -2; with -2 the sums agree and leave y and z free."""
    result = solved("x^2 = 4\ny + z = -x\n3*y + 3*z = 6")
    assert str(result.status) in {"partial", "singular"}
    assert set(result.undetermined) == {"y", "z"}
    assert [solution["x"] for solution in result.solutions] == [-2.0]


CURVES = {
    "logarithms": ("x*y = p\nln(x) + ln(y) = q", {"p": 6.1, "q": 1.80828877117927}, {"x", "y"}),
    "squares": (
        "x^2 + y^2 = p\nsqrt(x^2 + y^2) = q\nz = 3*p",
        {"p": 7.0, "q": 7.0**0.5},
        {"x", "y"},
    ),
    "powers": ("x*y^2 = p\nx^3*y^6 = q", {"p": 1.3, "q": 1.3**3}, {"x", "y"}),
    "three": (
        "x*y = p\ny*z = q\nx/z = r\nx^2 + u^2 = 50",
        {"p": 1.1, "q": 0.7, "r": 1.1 / 0.7},
        {"x", "y", "z", "u"},
    ),
    "angles": (
        "variables\n a\n b\n c > 0\n d > 0\n e\nrules\n c*sind(a) = d*sind(b)\n c/d = e\n a + b = "
        "100",
        {"a": 70.3, "e": math.sin(math.radians(29.7)) / math.sin(math.radians(70.3))},
        {"c", "d"},
    ),
}


@pytest.mark.parametrize("units", [-3, 0, 3])
@pytest.mark.parametrize(("text", "inputs", "free"), CURVES.values(), ids=CURVES)
def test_curve_of_answers_that_inputs_agree_on_to_their_last_places(
    text: str, inputs: dict[str, float], free: set[str], units: int
) -> None:
    last = list(inputs)[-1]
    given = {**inputs, last: inputs[last] * (1 + units * 2.0**-52)}
    result = solved(text, given)
    assert str(result.status) in {"partial", "singular"}
    assert set(result.undetermined) == free
    named = {name for diagnosis in result.diagnoses for name in diagnosis.variables}
    assert free & named


@pytest.mark.parametrize(("text", "inputs", "free"), CURVES.values(), ids=CURVES)
def test_curve_that_inputs_deny_by_more_than_rounding(
    text: str, inputs: dict[str, float], free: set[str]
) -> None:
    last = list(inputs)[-1]
    result = solved(text, {**inputs, last: inputs[last] * (1 + 1e-9)})
    assert str(result.status) in {"inconsistent", "infeasible", "failed"}


# --- rules made dependent in decimals, which floats only nearly are ---------------------

shares = st.integers(-9, 9).filter(bool).map(lambda n: Decimal(n) / 10)


@st.composite
def dependent(draw: st.DrawFn) -> list[list[Decimal]]:
    """One or two rows of decimals, and one that is made of them; the constant stands last."""
    count = draw(st.integers(1, 2))
    rows = [[draw(shares) for _ in range(count + 2)] for _ in range(count)]
    parts = [draw(shares) for _ in range(count)]
    made = [
        sum(p * a for p, a in zip(parts, column, strict=True)) for column in zip(*rows, strict=True)
    ]
    return [*rows, [Decimal(number) for number in made]]


def sheet(rows: list[list[Decimal]]) -> str:
    names = "xyz"[: len(rows)]
    sums = (
        " + ".join(f"({a})*{name}" for a, name in zip(row[:-1], names, strict=True)) for row in rows
    )
    return "\n".join(f"{total} = {row[-1]}" for total, row in zip(sums, rows, strict=True))


def regular(rows: list[list[Decimal]]) -> bool:
    """Whether the first rows are independent, and so every two of the sheet."""
    if any(not a for row in rows for a in row[:-1]):
        return False
    return (
        all(
            abs(rows[i][0] * rows[k][1] - rows[i][1] * rows[k][0]) > Decimal("0.001")
            for i in range(len(rows))
            for k in range(i)
        )
        or len(rows) == 2
    )


@settings(max_examples=40, deadline=None)
@given(dependent())
def test_dependent_decimals_determine_nothing(rows: list[list[Decimal]]) -> None:
    assume(regular(rows))
    result = solved(sheet(rows))
    assert str(result.status) in {"partial", "singular"}, sheet(rows)
    assert result.undetermined


@settings(max_examples=40, deadline=None)
@given(dependent(), st.integers(3, 9))
def test_dependent_decimals_with_a_wrong_constant_contradict(
    rows: list[list[Decimal]], places: int
) -> None:
    assume(regular(rows))
    rows[-1][-1] += Decimal(10) ** -places
    result = solved(sheet(rows))
    assert str(result.status) == "inconsistent", sheet(rows)
    assert sorted(label.span.line for label in result.diagnoses[0].labels) == list(
        range(1, len(rows) + 1)
    )


# --- what is divided by no more than the last places of given numbers -------------------

DIVIDED = {
    "a product": "d = a - b\nd*V = 1e-3",
    "a quotient": "d = a - b\nV = 1e-3/d",
    "one rule": "V = 1e-3/(a - b)",
    "what follows": "d = a - b\nd*V = 1e-3\nW = 2*V",
}


@pytest.mark.parametrize("text", DIVIDED.values(), ids=DIVIDED)
def test_quotient_by_the_last_places_of_inputs_is_no_answer(text: str) -> None:
    """0.1 + 0.2 and 0.3 are the same number but for a unit in the last place: V may have either
    sign."""
    result = solved(text, {"a": 0.1 + 0.2, "b": 0.3})
    assert str(result.status) == "singular"
    assert {"V"} <= set(result.undetermined) <= {"V", "W"}
    assert [d.code for d in result.diagnoses] == ["S544"]


@pytest.mark.parametrize("text", DIVIDED.values(), ids=DIVIDED)
def test_quotient_by_more_than_the_last_places_is_solved(text: str) -> None:
    a, b = 0.3 + 4 * 2.0**-54, 0.3
    result = solved(text, {"a": a, "b": b})
    assert str(result.status) == "solved"
    assert result["V"] == pytest.approx(1e-3 / (a - b), rel=1e-15)


def test_difference_that_is_rounding_stands_where_nothing_is_divided_by_it() -> None:
    result = solved("d = a - b\nV = 7*d", {"a": 0.1 + 0.2, "b": 0.3})
    assert str(result.status) == "solved"
    assert result["V"] == pytest.approx(7 * 2.0**-54, rel=1e-12)


RECORDED = (
    *DIVIDED.values(),
    "d = a - b\ny = 2*d/7\nV = 3/y",
    "a*V + 1 = b*V + 3",
    "V*(a^2 - b^2) = 3",
    "V = 3/(sin(a) - sin(b))",
    "V = 3/tan(a - b)",
)


@pytest.mark.parametrize("text", RECORDED)
def test_rows_that_divide_by_the_last_places_are_no_answers_either(text: str) -> None:
    """The compiled way, learned from rows that are well determined, leaves such a row to be
    told."""
    plan = solver.prepare(rulesheets.loads(text), inputs=["a"], want=["V"], given={"b": 0.3})
    for a in (0.7, 0.8, 0.9):
        assert plan(a)[0] == pytest.approx(solved(text, {"a": a, "b": 0.3})["V"], rel=1e-12)
    assert plan.records.programs
    with pytest.raises(solver.Unsolved) as refused:
        plan(0.1 + 0.2)
    assert str(refused.value.status) == "singular"
    table = plan.sweep(numpy.array([0.7, 0.1 + 0.2, 0.9] * 10))
    assert numpy.isnan(table["V"]).tolist() == [False, True, False] * 10


def test_what_is_divided_by_in_another_case_does_not_hold_up_a_record() -> None:
    text = "if a > b then V = 1/(sqrt(a - b) - 2)\nif a <= b then V = 1/(sqrt(b - a) - 3)"
    plan = solver.prepare(rulesheets.loads(text), inputs=["a"], want=["V"], given={"b": 0.3})
    for a in (0.7, 0.1, 0.8, 0.2):
        assert plan(a)[0] == pytest.approx(solved(text, {"a": a, "b": 0.3})["V"], rel=1e-12)
    known = len(plan.records.programs)
    for a in (0.75, 0.15):
        plan(a)
    assert len(plan.records.programs) == known <= 2


def test_contradiction_beside_a_coefficient_of_any_size_is_told() -> None:
    """What the rules may miss by is far smaller than their coefficients, by more than floats
    hold."""
    text = "a*c + d/1e6 = 0.0437\na*c + d/1e6 = 1.0690"
    for a in (1e300, -1e300, 1e150, 3.0):
        result = solved(text, {"a": a, "d": 0.106})
        assert str(result.status) == "inconsistent"
        assert {label.span.line for d in result.diagnoses for label in d.labels} >= {1, 2}


def test_what_moves_least_is_named_too() -> None:
    """c moves by a share of itself that is worth telling, beside a b sixty orders larger that does
    not."""
    text = (
        "variables\nd = 4.797921057202893e-24\nb ~ 1.2349606592391611e+38\nc ~ "
        "2.9125588589441427e-24\n"
        "y ~ -2.5337591923563436e+16\nrules\n(c*b) - (b/y) = 2.611593162265802e+21\nb + y = "
        "4.61e+37\n"
        "(2/1 + (d + c))*b = 9.22e+37\n"
    )
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) in ("partial", "singular", "failed", "solved")
    assert all(diagnosis.message for diagnosis in result.diagnoses)


@pytest.mark.parametrize(("off", "status"), [(0.0, "partial"), (1e-9, "inconsistent")])
def test_rules_that_repeat_one_another_but_for_rounding_leave_free(off: float, status: str) -> None:
    """The down payment cancels in what is saved; the instalment is known to some 1e-14 of
    itself."""
    lease = rulesheets.loads(
        "pay = (P - rest/(1 + r)^n)*r/(1 - (1 + r)^(-n))\ntotal = pay*n + down\nP = price - down\n"
        "saved = price - rest - total\n"
    )
    given = {"rest": 13400.0, "r": 0.00419, "n": 29.3}
    forward = solver.solve(lease, {**given, "price": 35060.0, "down": 5000.0})
    P, saved = forward["P"], forward["saved"]
    assert isinstance(saved, float)
    result = solver.solve(lease, {**given, "P": P, "saved": saved * (1.0 + off)})
    assert str(result.status) == status


TRIANGLE = """alpha + beta + gamma = 180
a/sind(alpha) = b/sind(beta)
b/sind(beta) = c/sind(gamma)
c^2 = a^2 + b^2 - 2*a*b*cosd(gamma)
a^2 = b^2 + c^2 - 2*b*c*cosd(alpha)
b^2 = a^2 + c^2 - 2*a*c*cosd(beta)
A = a*b*sind(gamma)/2
P = a + b + c
ha = 2*A/a
"""
RIGHT = """c^2 = a^2 + b^2
sind(alpha) = a/c
cosd(alpha) = b/c
tand(alpha) = a/b
alpha + beta = 90
A = a*b/2
P = a + b + c
h = a*b/c
p = a^2/c
q = b^2/c
"""
KNOWN = {
    TRIANGLE: {"a": 7.0, "b": 8.0, "c": 5.0, "alpha": 60.0, "A": 10 * math.sqrt(3), "P": 20.0},
    RIGHT: {"a": 3.6, "b": 7.7, "c": 8.5, "A": 13.86, "P": 19.8, "p": 3.6**2 / 8.5},
}


@pytest.mark.parametrize(
    ("rules", "names"),
    [
        *((TRIANGLE, names) for names in ("c alpha P", "b alpha A", "a alpha P", "c alpha A")),
        *((RIGHT, names) for names in ("a P", "c A", "P h", "p q", "alpha P", "A P", "b p")),
    ],
)
def test_all_formulas_of_a_triangle_determine_it_from_any_of_its_quantities(
    rules: str, names: str
) -> None:
    """Sines, cosines and tangents repeat one another where they hold, and nowhere else."""
    sides = {name: KNOWN[rules][name] for name in ("a", "b", "c")}
    state = dict(solved(rules, sides).solutions[0])
    assert {n: state[n] for n in KNOWN[rules]} == pytest.approx(KNOWN[rules])
    found = solved(rules, {name: state[name] for name in names.split()})
    assert str(found.status) == "solved"
    assert any(dict(answer) == pytest.approx(state, rel=1e-6) for answer in found.solutions)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e4, 3e8, 1e15])
def test_independent_rules_are_chosen_whatever_their_numbers(scale: float) -> None:
    """Momentum and energy of a particle, each by two formulas, and its flight time in its frame."""
    rules = f"""E = m + K
    g = E/m
    g = 1/sqrt(1 - b^2)
    v = {scale}*b
    p = sqrt(E^2 - m^2)
    p = g*m*b
    t = 3/v
    own = t/g"""
    m, K = 0.511, 1.2
    g = 1 + K / m
    own = 3 / (scale * math.sqrt(1 - 1 / g**2)) / g
    for known, asked, expected in (({"m": m}, "K", K), ({"K": K}, "m", m)):
        found = solver.solve(rulesheets.loads(rules), {"own": own, **known})
        assert found[asked] == pytest.approx(expected)


@pytest.mark.parametrize("speed", [1e-6, 1.0, 30.0, 299.79, 3e8])
def test_independent_rules_are_chosen_where_most_numbers_have_no_root(speed: float) -> None:
    """The lengths of a wave in a guide, which passes only some frequencies, by two formulas."""
    rules = f"""fc = {speed}/(2*a)
    lam = {speed}/f
    lg = lam/sqrt(1 - (fc/f)^2)
    1/lam^2 = 1/lg^2 + 1/lc^2
    lc = 2*a
    vp = {speed}*lg/lam"""
    a, f = 2.0, 1.7 * speed / 4
    vp = speed / math.sqrt(1 - (speed / (2 * a * f)) ** 2)
    for known, asked, expected in (({"a": a}, "f", f), ({"f": f}, "a", a)):
        found = solver.solve(rulesheets.loads(rules), {"vp": vp, **known})
        assert str(found.status) == "solved" and found.complete
        assert found[asked] == pytest.approx(expected)


@pytest.mark.parametrize("more", ["s = 0", "s = 0\nG = 3*s + s*v", "s = 0\nG = F + s\nw = 2*G"])
@pytest.mark.parametrize("rules", [*permutations(["F = P/v", "P = F*v", "tau = v/F"])])
def test_rules_that_repeat_one_another_are_left_beside_a_quantity_of_0(
    rules: Sequence[str], more: str
) -> None:
    found = solved("\n".join([*rules, more]), {"P": 100.0, "tau": 10.0})
    assert str(found.status) == "solved" and found.complete
    assert [answer["v"] for answer in found.solutions] == pytest.approx(
        [math.sqrt(1000.0), -math.sqrt(1000.0)]
    )


@pytest.mark.parametrize("share", [0.5, 0.4])
@pytest.mark.parametrize("load", [26.4, 26.5, 27.1])
@pytest.mark.parametrize("first", [True, False])
def test_the_balance_of_all_forces_repeats_those_of_the_parts(
    share: float, load: float, first: bool
) -> None:
    """Two loads on a beam, one at an unknown place, and a check that says nothing new."""
    rules = f"""A1 = {share}*G
    B1 = (1 - {share})*G
    A2 = 30*(1 - u)
    B2 = 30*u
    A = A1 + A2 + 2.4
    B = B1 + B2 + 2.4
    w = G^2*u"""
    check = "A + B = G + 30 + 0.6*8"
    text = f"{check}\n{rules}" if first else f"{rules}\n{check}"
    found = solved(text, {"A": load, "w": 57.6})
    # u = 1 - (A - 2.4 - share*G)/30
    slope, start = share / 30, 1 - (load - 2.4) / 30
    roots = [r.real for r in numpy.roots([slope, start, 0.0, -57.6]) if abs(r.imag) < 1e-9]
    assert str(found.status) == "solved" and found.complete
    assert sorted(answer["G"] for answer in found.solutions) == pytest.approx(sorted(roots))


@pytest.mark.parametrize("beam", [2.4, 2.5, 0.7])
def test_a_balance_that_rounding_breaks_leaves_the_loads_free(beam: float) -> None:
    """Of the load G in the middle and the place of another neither is determined."""
    found = solved(f"""A1 = G/2
    B1 = G/2
    A2 = 30*(1 - u)
    B2 = 30*u
    A = A1 + A2 + {beam}
    B = B1 + B2 + {beam}
    A + B = G + 30 + {2 * beam}
    A = 26.4""")
    assert str(found.status) == "partial" and {"G", "u"} <= {*found.undetermined}
