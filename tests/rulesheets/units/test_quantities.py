"""Values given and shown in other units, and the check of rules against the units of their
variables."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets import RuleSheetError
from rulesheets.format import format_sheet
from rulesheets.inputs import parse_input
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source
from rulesheets.units import check
from rulesheets.units.check import check_units, inferred
from solver.report.sheet import sheet_rows

LENS = """variables
  f = 50  [mm]
  u = 203.2 [mm]
  v       [mm -> in]
rules
  1/f = 1/u + 1/v
"""


@pytest.mark.parametrize("given", ["8 in", "8in", "8 [in]", "0.2032m", (8, "in"), (20.32, "cm")])
def test_a_value_is_converted_to_the_unit_of_its_variable(given: object) -> None:
    model = rulesheets.loads(LENS)
    assert solver.solve(model, {"u": given})["v"] == pytest.approx(
        solver.solve(model)["v"], rel=1e-15
    )


@pytest.mark.parametrize(
    "given", ["180 1/min", "180 min^-1", "180[1/min]", (180, "1/min"), "180 1 / min"]
)
def test_the_unit_of_a_value_may_be_an_inverse(given: object) -> None:
    model = rulesheets.loads("variables\n f [1/s]\nrules\n T = 1/f")
    assert solver.solve(model, {"f": given})["f"] == pytest.approx(3.0, rel=1e-15)


def test_a_pint_quantity_is_taken() -> None:
    pint = pytest.importorskip("pint")
    model = rulesheets.loads(LENS)
    given = {"u": pint.UnitRegistry().Quantity(8, "inch")}
    assert solver.solve(model, given)["v"] == pytest.approx(solver.solve(model)["v"], rel=1e-14)


def test_a_tolerance_is_a_difference() -> None:
    model = rulesheets.loads("variables\n T = 20 [degC]\nrules\n T = T")
    value, tolerance = parse_input("68 ± 9 degF", None, model.variables["T"])
    assert (value, tolerance and tolerance.size) == (20.0, 5.0)


def test_an_output_is_shown_in_its_display_unit() -> None:
    result = solver.solve(rulesheets.loads(LENS))
    row = next(row for row in sheet_rows(result) if row.name == "v")
    assert row.unit == "in"
    assert row.outputs == (pytest.approx(1 / (1 / 50 - 1 / 203.2) / 25.4, rel=1e-15),)


@pytest.mark.parametrize(
    ("sheet", "code"),
    [
        ("variables\n x [smoot]", "E460"),
        ("variables\n x = 3 [1/0]", "E460"),
        ("variables\n x [m^(1/0)]", "E460"),
        ("variables\n x [m -> kg]", "E461"),
        ("variables\n x = 3 [m -> inn]", "E460"),
    ],
)
def test_a_wrong_unit_of_a_sheet_is_told(sheet: str, code: str) -> None:
    with pytest.raises(RuleSheetError) as wrong:
        rulesheets.loads(f"{sheet}\nrules\n x = 2*y")
    assert [d.code for d in wrong.value.diagnoses] == [code]
    assert wrong.value.diagnoses[0].labels[0].span.line == 2


@pytest.mark.parametrize(
    ("unit", "note"),
    [
        ("kJ/kgK", "write kg-K for a product of units"),
        ("W/m2K", "write m2-K for a product of units"),
        ("Nmm", "write N-mm for a product of units"),
        ("Pas", "write Pa-s for a product of units"),
        ("lbs", "did you mean lb?"),
        ("hrs", "did you mean hr?"),
        ("VAR", "did you mean var?"),
        ("KN", "did you mean kN?"),
        ("kpa", "did you mean kPa?"),
    ],
)
def test_a_product_without_its_sign_is_parted(unit: str, note: str) -> None:
    with pytest.raises(RuleSheetError) as wrong:
        rulesheets.loads(f"variables\n x [{unit}]\nrules\n x = 2*y")
    assert wrong.value.diagnoses[0].notes == (note,)


@pytest.mark.parametrize("given", ["8 kg", "8 inn", (8, "s")])
def test_a_wrong_unit_of_an_input_is_told(given: object) -> None:
    with pytest.raises(RuleSheetError):
        solver.solve(rulesheets.loads(LENS), {"u": given})


def model_of(variables: str, rules: str) -> rulesheets.Model:
    head = "\n".join(f" {row}" for row in variables.split(","))
    return rulesheets.loads(f"variables\n{head}\nrules\n{rules}")


def warnings(variables: str, rules: str) -> list[str]:
    return [one.message for one in check_units(model_of(variables, rules))]


@pytest.mark.parametrize(
    ("variables", "rules"),
    [
        ("F [N],m [kg],a [m/s^2]", "F = m*a"),
        ("E [J],m [kg],v [m/s]", "E = m*v^2/2"),
        ("F [kN],m [kg],a [m/s^2]", "F = m*a/1000"),
        ("v [km/h],s [m],t [s]", "v = 3.6*s/t"),
        ("x [m],D [m]", "x/D = ln(y)"),
        ("T [K],t [degC]", "T = t + 273.15"),
        ("c [m],a [m],b [m]", "c = sqrt(a^2 + b^2)"),
        ("Re,v [m/s],D [m],nu [m^2/s]", "Re = v*D/nu\nf = 64/Re"),
        ("th [deg],x [m],r [m]", "x = r*cosd(th)"),
        ("N [kN],A [mm^2],s [MPa]", "s = 1000*N/A"),
        ("y [mm],x [mm]", 'y = x^2  " unchecked: holds in mm alone'),
    ],
)
def test_rules_that_fit_are_not_warned_of(variables: str, rules: str) -> None:
    assert warnings(variables, rules) == []


@pytest.mark.parametrize(
    ("variables", "rules", "said"),
    [
        ("N [N],A [mm^2]", "x = N + A", "the units do not fit"),
        ("F [kN],m [kg],a [m/s^2]", "F = m*a", "factor of 1000"),
        ("x [m],y", "y = exp(x)", "exp takes a number, and x is in m"),
        ("th [rad],x [m],r [m]", "x = r*cosd(th)", "cosd takes an angle in deg"),
        ("p [N/m],q [N/m^2],w [m]", "p = s*w\nq = s/w", "the units do not fit"),
        ("L [m],d [mm],A [m^2]", "A = L*d", "factor of 1000"),
    ],
)
def test_rules_that_do_not_fit_are_warned_of(variables: str, rules: str, said: str) -> None:
    (message,) = warnings(variables, rules)
    assert said in message


@pytest.mark.parametrize("name", rulesheets.shipped_models())
def test_the_shipped_models_have_units_that_fit(name: str) -> None:
    assert check_units(rulesheets.load(name)) == ()


def test_a_number_of_a_row_is_converted_to_its_unit() -> None:
    rows = "x = 3[in] [mm]\n T = -40[degF] [K]\n y = 2[in]\n z = 1[m] ± 1[in] [mm]\n w ~ 1[ft] [in]"
    variables = rulesheets.loads(f"variables\n {rows}\nrules\n w = x + y").variables
    assert (variables["x"].value, variables["T"].value, variables["z"].value) == (
        76.2,
        233.15,
        1000.0,
    )
    assert (variables["y"].value, variables["y"].unit) == (2.0, "in")
    assert variables["z"].tolerance is not None and variables["z"].tolerance.size == 25.4
    assert variables["w"].guess == 12.0


def test_a_number_of_a_rule_is_used_as_written() -> None:
    model = rulesheets.loads("variables\n m = 2 [kg]\n F [kN]\nrules\n F = m*9.81[m/s^2]/1000")
    assert solver.solve(model)["F"] == pytest.approx(0.01962, rel=1e-15)
    assert check_units(model) == ()


def test_a_number_with_a_unit_does_not_explain_a_factor() -> None:
    (message,) = warnings("F [kN],m [kg]", "F = m*1000[m/s^2]")
    assert "factor of 1000" in message
    (message,) = warnings("F [kN],m [kg]", "F = m*9.81[m/s]")
    assert "the units do not fit" in message


@pytest.mark.parametrize(
    ("sheet", "code", "line"),
    [
        ("variables\n x = 2*3[in] [mm]\nrules\n x = y", "E461", 2),
        ("variables\n x = 3[kg] [mm]\nrules\n x = y", "E461", 2),
        ("variables\n x > 2*3[in] [mm]\nrules\n x = y", "E121", 2),
        ("x = 3*y\ny = 9.81[smoot]*x", "E460", 2),
        ("x = 3 [mm]", "E101", 1),
    ],
)
def test_a_misplaced_unit_of_a_number_is_told(sheet: str, code: str, line: int) -> None:
    with pytest.raises(RuleSheetError) as wrong:
        rulesheets.loads(sheet)
    assert [d.code for d in wrong.value.diagnoses] == [code]
    assert wrong.value.diagnoses[0].labels[0].span.line == line


@pytest.mark.parametrize(
    ("variables", "rules"),
    [
        ("K [EUR],K0 [EUR],n [yr],p [%]", "K = K0*(1 + p/100)^n"),
        ("s [MPa],M [N m],d [mm]", "s = 32000*M/(pi*d^3)"),
        ("R,T [K],b", "R = exp(b*(T/300 - 1/298.15*300))"),
        ("g [dB],v", "g = 20*log(v)"),
    ],
)
def test_usual_formulas_are_not_warned_of(variables: str, rules: str) -> None:
    assert warnings(variables, rules) == []


def test_the_unit_of_a_constant_is_proposed() -> None:
    model = rulesheets.loads("variables\n h [m]\n v [m/s]\nrules\n h = v^2/(2*9.81)")
    (found,) = check_units(model)
    assert any("9.81[m/s^2]" in note for note in found.notes)
    assert check_units(model, sure=True) == ()


def test_a_constant_may_have_a_unit_also_where_others_follow_from_its_rule() -> None:
    model = model_of("p [kPa],T [degC]", "y*p = 0.6108*exp(17.27*T/(T + 237.3))\ny = n1/(n1 + 3)")
    assert [one.code for one in check_units(model)] == ["W601"]
    assert check_units(model, sure=True) == ()


def test_the_everyday_sheets_have_no_sure_mistakes() -> None:
    sheets = sorted((Path(__file__).parents[2] / "everyday").glob("*/*.tk"))
    found = {sheet.name: check_units(rulesheets.load(sheet), sure=True) for sheet in sheets}
    assert len(found) > 100
    assert {name: list(some) for name, some in found.items() if some} == {}


OWN = """units
  smoot = 1.7018 m       " the length of a bridge is measured in them
  EUR   = 1.08 USD
  widget
  degRe = 1.25 K + 273.15

variables
  L = 364.4 [smoot -> m]
  p = 3[EUR/widget] > 0 [USD/widget]
  n = 20 [widget]
  c [USD -> EUR]
  T = 80 [degRe -> degC]

rules
  c = p*n
  A = L^2
"""


def test_a_sheet_defines_units_of_its_own() -> None:
    model = rulesheets.loads(OWN)
    result = solver.solve(model, {"n": "2 kwidget"})
    rows = {row.name: row for row in sheet_rows(result)}
    assert (rows["L"].input, rows["L"].unit) == (pytest.approx(620.13592, rel=1e-15), "m")
    assert rows["c"].outputs == (pytest.approx(6000.0, rel=1e-15),)
    assert rows["T"].input == pytest.approx(100.0, rel=1e-15)
    with pytest.raises(RuleSheetError):
        rulesheets.loads("variables\n L [smoot]\nrules\n A = L^2")


def test_an_indented_name_is_a_variable_even_if_it_is_units() -> None:
    model = rulesheets.loads("variables\n  units\n  k = 2\nrules\n  units = 3*k\n")
    assert (list(model.variables), solver.solve(model)["units"]) == (["units", "k"], 6.0)


def test_own_units_survive_a_process_and_the_formatter() -> None:
    model = pickle.loads(pickle.dumps(rulesheets.loads(OWN)))
    assert model.variables["L"].measure == rulesheets.loads(OWN).variables["L"].measure
    printed = format_sheet(parse(Source("sheet", OWN)))
    assert format_sheet(parse(Source("sheet", printed))) == printed
    assert rulesheets.loads(printed).variables == rulesheets.loads(OWN).variables


def test_a_used_file_may_bring_units(tmp_path: Path) -> None:
    (tmp_path / "money.tk").write_text("units\n  SEK = 0.09 USD\n")
    (tmp_path / "sheet.tk").write_text(
        'use "money.tk"\nvariables\n p = 100[SEK] [USD]\nrules\n q = 2*p\n'
    )
    assert solver.solve(rulesheets.load(tmp_path / "sheet.tk"))["q"] == 18.0


def test_ends_of_ranges_are_converted() -> None:
    model = rulesheets.loads(
        "variables\n T > 0[K], < 212[degF] [degC]\n x in [0, 5[in]] [mm]\nrules\n T = x"
    )
    assert [model.variables[name].low for name in ("T", "x")] == [-273.15, 0.0]
    assert [model.variables[name].high for name in ("T", "x")] == [
        pytest.approx(100.0, rel=1e-15),
        127.0,
    ]


@pytest.mark.parametrize(
    ("variables", "rules"),
    [
        ("P [W],M [N m],n [rpm]", "P = 2*pi*M*n/60"),
        ("P [kW],M [N m],n [rpm]", "P = M*n/9550"),
        ("P [kW],p [kPa],V [l],n [rpm]", "P = p*V/1000*n/120"),
        ("v [m/min],D [mm],n [rpm]", "v = pi*D*n/1000"),
        ("f [Hz],n [rpm]", "f = n/60"),
        ("w [rad/s],f [Hz]", "w = 2*pi*f"),
        ("s [m],r [m],th [deg]", "s = pi*r*th/180"),
        ("a [deg],b [rad]", "a = asind(x)\nb = acos(x)\ny = sin(b)*cosd(a)"),
        ("a [deg]", "x = sin(a*pi/180)"),
        ("L10 [Mrev],C [kN],P [kN]", "L10 = (C/P)^3"),
        ("t [s],d [m],v [m/min]", "tm = t/60\nv = d/tm"),
        ("t [s],d [day]", "tm = t/60\nth = tm/60\nd = th/24"),
        ("m [kg],v [km/h],E [kJ]", "vm = v/3.6\nE = 0.5*m*vm^2/1000"),
        ("eta [%],loss [%]", "rest = 100 - eta - loss"),
        ("i [%],K [EUR],K0 [EUR]", "K = K0*(1 + i/100)^7"),
        ("k [1/s],E [kJ/mol],R [J/mol-K],T [K]", "k = A*exp(-1000*E/(R*T))"),
        ("eff [%],A [EUR],P [EUR]", "eff = 100*((1 + i)^12 - 1)\nP = A*(1 + i)^(-3)"),
        ("x [mm],B [mm^2]", "A = x^2\nB = 2*A"),
        ("g [dB],p [W],q [W]", "g = 10*log(p/q)"),
    ],
)
def test_angles_counts_and_inferred_sizes_that_fit_are_not_warned_of(
    variables: str, rules: str
) -> None:
    assert warnings(variables, rules) == []


@pytest.mark.parametrize(
    ("variables", "rules", "factor"),
    [
        (
            "b [mm],F [kN],L [m],E [GPa],w [mm]",
            "I = b*h^3/12\nh = 2*b\nw = F*L^3/(48*E*I)",
            "1e+09",
        ),
        ("m [kg],v [m/s],P [kW],t [s]", "E = 0.5*m*v^2\nP = E/t", "1000"),
    ],
)
def test_numbers_in_a_chain_of_rules_excuse_no_other_factor(
    variables: str, rules: str, factor: str
) -> None:
    (warning,) = warnings(variables, rules)
    assert f"a factor of {factor} is missing" in warning


@pytest.mark.parametrize(
    ("variables", "rule", "cure"),
    [
        ("v [m/s],D [mm],nu [m^2/s]", "Re = v*D/nu", "give D in m, or write 1000*Re"),
        ("K [EUR],K0 [EUR],i [%]", "K = K0*(1 + i)^2", "give i as a plain number"),
        ("K [EUR],K0 [EUR],i [%],n = 5", "K = K0*(1 + i)^n", "give i as a plain number"),
        ("T1 [K],T2 [K],p1 [kPa],p2 [bar],k = 1.4", "T2 = T1*(p2/p1)^((k - 1)/k)", "p2 in kPa"),
        ("k [1/s],E [kJ/mol],R [J/mol-K],T [K]", "k = A*exp(-E/(R*T))", "give E in J/mol"),
        ("p1 [kPa],p2 [bar],w [J]", "w = w0*ln(p1/p2)", "give p2 in kPa"),
        ("x [%],y [m],z [m]", "y = z*2^x", "give x as a plain number"),
    ],
)
def test_a_pure_number_makes_up_for_no_factor(variables: str, rule: str, cure: str) -> None:
    (warning,) = check_units(model_of(variables, rule))
    assert any(cure in note for note in warning.notes)


def test_celsius_is_not_the_coulomb() -> None:
    model = model_of(
        "T_1 [C],T_2 [C],q [C],h [W/m^2],T_3 [F],C [F]", "h = eps*5.67e-8*(T_1^4 - T_2^4)"
    )
    assert [one.message for one in check_units(model) if one.code == "W604"] == [
        "T_1 and T_2 are in C, which is the coulomb",
        "T_3 is in F, which is the farad",
    ]


def test_what_rules_imply_is_named() -> None:
    rules = "Re = v*D/nu\n A = D^2\n E = m*v^2/2\n a = asind(Re)\n F = E/D\n k = q*2\n n = t/60"
    head = "variables\n v [m/s]\n D [mm]\n nu [m^2/s]\n m [kg]\n t [s]\nrules\n"
    model = rulesheets.loads(f"{head} {rules}")
    assert inferred(model) == {
        "A": "mm^2",
        "E": "J",
        "F": "kN",
        "Re": "-",
        "a": "deg",
        "n": "s or a multiple",
    }
    assert inferred(rulesheets.loads("y = 2*x")) == {}


@pytest.mark.parametrize(
    ("variables", "rules", "change"),
    [
        ("L [cm],k [W/m-K],A [m^2],h [W/m^2-K]", "R = 1/(h*A) + L/(k*A)", "give L in m"),
        ("p [kPa],F [N],d [m]", "p = F/d^2", "give p in Pa"),
        ("w [m/s],d [cm],t [s]", "w^2 = (d/t)^2", "give d in m"),
        ("P [kW],T [N-m],n [rpm]", "P = T*n", "give P in W and n in rad/s"),
        ("v [km/h],t [min],d [km]", "d = v*t", "give t in h"),
        ("price [EUR/kWh],P [kW],t [min],cost [EUR]", "cost = price*P*t", "give t in h"),
        ("A [mm^2],b [cm],h [cm]", "A = b*h", "give A in cm^2"),
        ("P [kW],T [N-m],n [rpm]", "P = T*w\nw = 2*pi*n/60", "give P in W"),
    ],
)
def test_the_unit_to_change_is_named(variables: str, rules: str, change: str) -> None:
    (warning,) = check_units(model_of(variables, rules))
    assert warning.notes[0].startswith(change)


def test_numbers_of_the_rule_are_no_part_of_what_is_missing() -> None:
    """2π/60 makes rad/s of rpm, so that 1000 is missing, for kW, and not 1000·60/2π."""
    rules = "P = T*w\nw = 2*pi*n/60"
    (warning,) = check_units(model_of("P [kW],T [N-m],n [rpm]", rules))
    assert "w is in 1000 rad/s, 2*pi*n/60 in rad/s: a factor of 1000 is missing" in warning.message


@pytest.mark.parametrize(
    ("variables", "rules", "change"),
    [
        ("P [kW],V [V],I [A],eta = 0.9", "V*I = P/eta", "give P in W"),
        ("m [kg],v [km/h],mu = 0.7,d [m]", "mu*m*9.81[m/s^2]*d = m*v^2/2", "give v in m/s"),
        (
            "z [m],D [mm],v [m/s],f = 0.02,K = 8",
            "z = (f*z/D + K)*v^2/(2*9.81[m/s^2])",
            "give D in m",
        ),
    ],
)
def test_a_given_number_makes_up_for_no_factor(variables: str, rules: str, change: str) -> None:
    (warning,) = check_units(model_of(variables, rules), sure=True)
    assert warning.notes[0].startswith(change)


def test_a_reading_of_a_temperature_scale_is_not_called_kelvin() -> None:
    model = model_of("T [degC],q [W],h [W/m^2-K],A [m^2]", "Ts = T - q*R\nR = 1/(h*A)\ndT = T - Ts")
    assert inferred(model) == {"Ts": "degC, or K of a difference", "R": "K/W", "dT": "K"}


def test_a_sheet_without_units_is_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check, "Dimensions", None)
    assert check_units(rulesheets.loads("y = 2*x + sin(x)")) == ()


def test_a_swept_column_has_a_unit_and_a_value_is_read_in_another() -> None:
    model = rulesheets.loads(LENS)
    table = solver.sweep(model, {"u": ([8.0, 16.0], "in")}, want=["v"])
    assert table["u"].tolist() == [203.2, 406.4]
    assert rulesheets.in_unit(model, "v", table["v"], "m") == pytest.approx(
        table["v"] / 1000, rel=1e-15
    )
    assert rulesheets.in_unit(model, "u", 254.0, "in") == 10.0
    with pytest.raises(RuleSheetError):
        solver.sweep(model, {"u": ([8.0], "kg")})
    pint = pytest.importorskip("pint")
    same = solver.sweep(
        model, {"u": pint.UnitRegistry().Quantity(np.array([8.0, 16.0]), "inch")}, want=["v"]
    )
    assert same["v"] == pytest.approx(table["v"], rel=1e-14)


@pytest.mark.parametrize("switch", ["step(t, t1)", "sgn(t - t1)", "step(sin(w*t), 0)"])
def test_what_switches_on_and_off_is_a_number(switch: str) -> None:
    rows = "variables\n  F [N]\n  F0 = 3 [N]\n  t = 2 [s]\n  t1 = 1 [s]\n  w = 1 [rad/s]\nrules\n"
    assert check_units(rulesheets.loads(f"{rows}  F = F0*{switch}")) == ()
    (warning,) = check_units(rulesheets.loads(f"{rows}  F = F0*step(t, F0)"))
    assert warning.code == "W601"
