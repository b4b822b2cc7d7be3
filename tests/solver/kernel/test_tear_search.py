"""What the search of a range says of roots where floats have no value of a rule."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from solver import Status


def nearly_parallel(disguised: str, hidden: str, slope: float, rhs: float = 4.0) -> solver.Result:
    """Two lines that meet at x = (rhs - 3)/(slope - 1)."""
    rules = f"{disguised} + y = 3\na*x + y + {hidden} = {rhs}\na = {slope}"
    return solver.solve(rulesheets.loads(rules))


@pytest.mark.parametrize(
    ("disguised", "hidden"),
    [
        ("x*exp(0*y)", "0*sin(x*y)"),
        ("x*(1 + 0*y^2)", "0*cos(x*x)*x"),
        ("x*cos(0*x*y)", "0*x^3*sin(x*y)"),
    ],
)
@pytest.mark.parametrize("slope", [1.0000001, 0.99999, 1.001])
def test_a_term_without_value_far_out_hides_no_root(
    disguised: str, hidden: str, slope: float
) -> None:
    """The first box of the search that holds the root alone reaches beyond 1e200."""
    result = nearly_parallel(disguised, hidden, slope)
    assert result.status is Status.SOLVED
    assert [s["x"] for s in result.solutions] == pytest.approx([1 / (slope - 1)], rel=1e-8)


@pytest.mark.parametrize("hidden", ["0*sinh(x)", "0*exp(-x)*y", "0*sinh(x)*x"])
@pytest.mark.parametrize("slope", [0.999, 0.9985])
def test_a_root_at_which_floats_overflow_is_not_denied(hidden: str, slope: float) -> None:
    result = nearly_parallel("x*exp(0*y)", hidden, slope, rhs=4.5)
    assert result.status in (Status.SOLVED, Status.FAILED)
    assert not result.complete or result.solutions


def test_a_flat_arc_is_found_though_its_height_is_rounded() -> None:
    """1 - cos(th/2) of a small angle has half of its digits: too few for Newton's method in
    floats."""
    result = solver.solve(
        rulesheets.loads("sag = rad*(1 - cos(th/2))\ns = rad*th"),
        {"sag": 1.03541813e-07, "s": 0.00417787802122},
    )
    assert max(s["rad"] for s in result.solutions) == pytest.approx(21.072000093694758, rel=1e-12)


def test_a_root_at_the_end_of_floats_spoils_no_ordinary_one() -> None:
    """Where the radius goes to 0 the angle passes 1e99, and the sine changes its sign without
    end."""
    rules = "sag = rad*(1 - cos(th/2))\nchord = 2*rad*sin(th/2)\nratio = chord/s\ns = rad*th"
    result = solver.solve(
        rulesheets.loads(rules), {"ratio": 0.99996505771, "chord": 0.0550201795655}
    )
    assert result.status is Status.SOLVED
    assert [s["rad"] for s in result.solutions] == pytest.approx(
        [1.8999999953, -1.8999999953], rel=1e-9
    )
    assert not result.complete


@pytest.mark.parametrize(
    ("rule", "total"),
    [
        ("total = round(net*1.21*100)/100", 768.29),
        ("total = round(net*100)", 12100.0),
        ("total = int(net/0.05)*0.05", 12.35),
        ("total = round(net*121)", 12100.0),
        ("total = round(4050/(1 - 1.0045^-net))/100", 271.4),
    ],
)
def test_a_narrow_plateau_leaves_its_unknown_free(rule: str, total: float) -> None:
    """Prices to the cent: all within a ten thousandth give one total, and none of them is a double
    root."""
    result = solver.solve(rulesheets.loads(rule), {"total": total})
    assert result.status is Status.PARTIAL
    assert result.undetermined == ("net",)


def test_of_many_roots_the_ordinary_ones_are_looked_into_first() -> None:
    """Stairs of n steps of 18 cm, for which H/17.5 cm rounds to n: up to 17 of them, as
    0.18/0.175*n - n is below a half."""
    steps = {float(n) for n in range(-17, 18) if n and round(0.18 * n / 0.175) == n}
    result = solver.solve(rulesheets.loads("n = round(H/0.175)\nrise = H/n"), {"rise": 0.18})
    found = [solution["n"] for solution in result.solutions]
    assert result.status is Status.SOLVED
    assert {1.0, 2.0, 5.0, 10.0} <= set(found) <= steps
    assert result["n"] > 0.0
    assert not result.complete or set(found) == steps


EXCHANGERS = """
variables
  Ch
  Cc
rules
call hx(To1, To2, Tw2, Tw3, UA1; q1)
call hx(To2, To3, Tw1, Tw2, UA2; q2)
function hx(Thi, Tho, Tci, Tco, UA; q)
parameters Ch, Cc
rules
  q = Ch*(Thi - Tho)
  q = Cc*(Tco - Tci)
  Cmin = min(Ch, Cc)
  Cr = Cmin/max(Ch, Cc)
  NTU = UA/Cmin
  eff = (1 - exp(-NTU*(1 - Cr)))/(1 - Cr*exp(-NTU*(1 - Cr)))
  q = eff*Cmin*(Thi - Tci)
"""


def test_a_block_of_some_size_keeps_the_roots_along_its_tear() -> None:
    """The heat of the first exchanger has a maximum in the flow: two flows give it."""
    given = {"Cc": 5.016, "To1": 120.0, "Tw1": 20.0, "UA1": 3.0, "UA2": 2.5}
    model = rulesheets.loads(EXCHANGERS)
    heat = solver.solve(model, {**given, "Ch": 4.2})["q1"]
    result = solver.solve(model, {**given, "q1": heat})
    assert result.status is solver.Status.SOLVED
    flows = sorted(s["Ch"] for s in result.solutions)
    assert flows[0] == pytest.approx(4.2)
    assert len(flows) == 2
    again = solver.solve(model, {**given, "Ch": flows[1]})
    assert again["q1"] == pytest.approx(heat)
