"""Points and differences of temperatures: what rules say of them, and how they are converted."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from rulesheets.units import differences
from rulesheets.units.check import check_units
from solver.report.sheet import sheet_rows

WALL = """variables
  T1 = 68[degF]  [degC]
  T2 = 20        [degC]
  rise = 18[degF] ± 1.8[degF] < 90[degF] [degC -> degF]
  k = 2          [W/m^2-K]
  q              [W/m^2]
rules
  rise = T1 - T2
  q = k*rise
"""


@pytest.mark.parametrize(
    ("rows", "rules", "expected"),
    [
        ("T1 [degC],T2 [degC],x [degC]", "x = T1 - T2", {"x"}),
        ("T1 [degC],T2 [degC],dT [degF]", "T1 = T2 + 1.8*dT", {"dT"}),
        ("T1 [degC],T2 [degC],x [degC]", "T1 = T2 + x", set()),
        ("T1 [degC],T2 [degC],dTm [degC]", "dTm = (T1 + T2)/2", set()),
        ("T1 [degC],T2 [degC],T [degC]", "T = (T1 + T2)/2\nm1*T1 + m2*T2 = (m1 + m2)*T", set()),
        (
            "a [K],b [K],t [K],u [K],v [K],w [K],L [K]",
            "a = t - w\nb = u - v\nL = (a - b)/ln(a/b)",
            {"a", "b", "L"},
        ),
        ("T [K],t [degC]", "T = t + 273.15", set()),
        ("rise [delta_degC],T [degC],T0 [degC]", "T = T0 + rise", {"rise"}),
        ("F [degF],C [degC]", "F = 1.8*C + 32", set()),
        ("x [m],y [m]", "x = 2*y", set()),
    ],
)
def test_rules_tell_differences_from_points(rows: str, rules: str, expected: set[str]) -> None:
    head = "".join(f" {row}\n" for row in rows.split(","))
    assert differences(rulesheets.loads(f"variables\n{head}rules\n{rules}")) == expected


def test_a_difference_is_converted_without_the_zero_of_its_scale() -> None:
    model = rulesheets.loads(WALL)
    rise = model.variables["rise"]
    assert (rise.value, rise.high, model.variables["T1"].value) == (10.0, 50.0, 20.0)
    assert rise.tolerance is not None and rise.tolerance.size == 1.0
    result = solver.solve(model, {"T1": None, "rise": "9 degF"})
    assert (result["T1"], result["q"]) == (25.0, 10.0)
    row = next(row for row in sheet_rows(result) if row.name == "rise")
    assert (row.input, row.unit) == (9.0, "degF")


@pytest.mark.parametrize(
    ("rows", "rules"),
    [
        ("p [Pa],r [kg/m^3],T [degC]", "p = r*R*(T + 273.15)"),
        ("p [Pa],r [kg/m^3],T [K],t [degC]", "p = r*R*T\nT = t + 273.15"),
        ("T [degC],R", "R = 100*(1 + a*T + b*T^2)"),
        ("T [degC],T0 [degC],q [W]", "q = U*A*(T - T0)"),
        ("T [degC],T0 [degC],T1 [degC]", "ln((T - T0)/(T1 - T0)) = -x"),
        ("T1 [degC],T2 [degC],T [degC]", "m1*c*T1 + m2*c*T2 = m*c*T\nm = m1 + m2"),
        ("T [degC],dT [K],t2 [degC]", "t = T - dT\nh = 200 + 1.3*t\nt2 = T + dT"),
        ("T [degC],q [W/m^2]", 'q = x*T^4  " unchecked'),
    ],
)
def test_temperatures_that_fit_are_not_warned_of(rows: str, rules: str) -> None:
    head = "".join(f" {row}\n" for row in rows.split(","))
    found = check_units(rulesheets.loads(f"variables\n{head}rules\n{rules}"))
    assert [one for one in found if one.code == "W603"] == []


def test_an_energy_may_be_counted_from_the_zero_of_a_scale() -> None:
    model = rulesheets.loads("variables\n T [degC]\n h [kJ/kg]\nrules\n h = c*T")
    assert [one.code for one in check_units(model)] == ["W603"]
    assert check_units(model, sure=True) == ()


def test_two_scales_in_a_difference_ask_for_one_unit() -> None:
    model = rulesheets.loads(
        "variables\n T1 [degC]\n T2 [degF]\n U [W/m^2-K]\n q [W/m^2]\nrules\n q = U*(T1 - T2)"
    )
    (warning,) = check_units(model)
    assert warning.notes == ("give these temperatures in the same unit",)
