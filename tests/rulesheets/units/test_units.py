"""Unit texts against definitions of NIST Special Publication 811 (2008), appendix B, and against
pint."""

from __future__ import annotations

import math
import subprocess
import sys
from fractions import Fraction
from importlib import import_module

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
from rulesheets.library import Library, Unit, UnitError, convert, library

names = import_module("rulesheets.library")

EXACT = {
    "in": ("m", "0.0254"),
    "ft": ("m", "0.3048"),
    "yd": ("m", "0.9144"),
    "mi": ("m", "1609.344"),
    "nmi": ("m", "1852"),
    "mil": ("m", "0.0000254"),
    "acre": ("m^2", "4046.8564224"),
    "gal": ("m^3", "0.003785411784"),
    "bbl": ("m^3", "0.158987294928"),
    "lb": ("kg", "0.45359237"),
    "oz": ("kg", "0.028349523125"),
    "ton": ("kg", "907.18474"),
    "kgf": ("N", "9.80665"),
    "lbf": ("N", "4.4482216152605"),
    "kip": ("N", "4448.2216152605"),
    "atm": ("Pa", "101325"),
    "bar": ("Pa", "100000"),
    "at": ("Pa", "98066.5"),
    "cal": ("J", "4.184"),
    "Btu": ("J", "1055.05585262"),
    "kWh": ("J", "3600000"),
    "erg": ("J", "1e-7"),
    "mph": ("m/s", "0.44704"),
    "kn": ("km/h", "1.852"),
    "P": ("Pa s", "0.1"),
    "St": ("m^2/s", "0.0001"),
    "degR": ("K", "5/9"),
    "Btu/lb-R": ("kJ/kg-K", "4.1868"),
    "gpm": ("L/min", "3.785411784"),
    "hp": ("W", "745.69987158227022"),
    "cfm": ("m^3/h", "1.69901079552"),
}


@pytest.mark.parametrize("name", EXACT)
def test_factors_are_those_of_the_standard(name: str) -> None:
    other, factor = EXACT[name]
    one, unit = library().unit(name), library().unit(other)
    assert one.bases == unit.bases
    assert one.factor / unit.factor == Fraction(factor)


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("W/m^2-K", "W/(m^2 K)"),
        ("W/m^2*K", "W K/m^2"),
        ("kJ/kg·K", "kJ/(kg*K)"),
        ("m3", "m^3"),
        ("m²", "m*m"),
        ("s⁻¹", "1/s"),
        ("N-m", "J"),
        ("kJ/kg{CH4}", "kJ/kg"),
        (r"kJ/kg\CH4", "kJ/kg"),
        ("m^(1/2)-m^0.5", "m"),
        ("kg/s/m", "kg/(s-m)"),
        ("-", ""),
        ("rev/min", "rpm"),
        ("1.5/3 m", "0.5 m"),
    ],
)
def test_texts_are_read_as_engineers_write_them(text: str, same: str) -> None:
    assert library().unit(text) == library().unit(same)


@pytest.mark.parametrize(
    ("text", "message", "name"),
    [
        ("smoot", "no unit is called smoot", "smoot"),
        ("N/qq", "no unit is called qq", "qq"),
        ("m^", "an exponent is missing", ""),
        ("^2", "an exponent has nothing before it", ""),
        ("(m", "a parenthesis is not closed", ""),
        ("m+s", "`+s` is not read", ""),
    ],
)
def test_what_is_no_unit_is_told(text: str, message: str, name: str) -> None:
    with pytest.raises(UnitError) as wrong:
        library().unit(text)
    assert (str(wrong.value), wrong.value.name) == (message, name)


@pytest.mark.parametrize(
    ("number", "source", "target", "expected"),
    [
        (68.0, "degF", "degC", 20.0),
        (-40.0, "°C", "°F", -40.0),
        (0.0, "degC", "K", 273.15),
        (0.0, "psig", "atm", 1.0),
        (491.67, "R", "degC", 0.0),
    ],
)
def test_scales_that_begin_elsewhere(
    number: float, source: str, target: str, expected: float
) -> None:
    assert convert(number, library().unit(source), library().unit(target)) == pytest.approx(
        expected, abs=1e-13
    )


def test_a_difference_has_no_beginning() -> None:
    assert convert(9.0, library().unit("degF"), library().unit("degC"), difference=True) == 5.0


def test_turns_are_exact_but_for_pi() -> None:
    assert convert(30.0, library().unit("rpm"), library().unit("rad/s")) == pytest.approx(
        math.pi, rel=1e-15
    )
    assert convert(0.25, library().unit("rev"), library().unit("deg")) == 90.0


def test_units_of_a_sheet_s_own() -> None:
    own = Library(("widget", "~crate = 12 widget", "quid = 1.25 USD"))
    assert convert(3.0, own.unit("crate"), own.unit("widget")) == 36.0
    assert own.unit("kcrate") == own.unit("12000 widget")
    assert own.unit("kUSD") == own.unit("1000 USD")


@pytest.mark.parametrize("meaning", ["1.2.3 m", "1..2 m", "1 K + 5.."])
def test_a_meaning_with_no_number_is_told(meaning: str) -> None:
    with pytest.raises(UnitError):
        Library().meant(meaning)


def test_a_meaning_may_divide_decimals() -> None:
    assert Library().meant("2.5/5 K + 1.5/3 K") == Unit(
        Fraction(1, 2), 0, {"K": Fraction(1)}, Fraction(1, 2)
    )


@pytest.mark.parametrize(
    "text", ["km^200", "km^-200", "km999999999", "1e999999999 m", "Ym^6 Ym^6", "1e-400/3 m"]
)
def test_a_unit_that_floats_cannot_turn_into_others_is_refused(text: str) -> None:
    with pytest.raises(UnitError, match="1e150"):
        Library().unit(text)
    with pytest.raises(UnitError, match="1e150"):
        Library((f"foo = {text}",)).unit("foo")


ALIKE = ("mm", "in", "ft", "km", "mi", "um", "nmi", "Mm")


@given(st.floats(-1e9, 1e9), st.sampled_from(ALIKE), st.sampled_from(ALIKE))
def test_there_and_back_is_the_same_number(number: float, source: str, target: str) -> None:
    one, other = library().unit(source), library().unit(target)
    assert convert(convert(number, one, other), other, one) == pytest.approx(
        number, rel=4.5e-16, abs=1e-300
    )


def test_pint_knows_names_that_the_library_lacks() -> None:
    pytest.importorskip("pint")
    assert float(Library().unit("kfurlong").factor) == pytest.approx(201168.0, rel=1e-5)
    with pytest.raises(UnitError):
        Library().unit("smoots")


def test_a_sheet_without_units_imports_no_pint() -> None:
    solved = "import sys, rulesheets, solver; solver.solve(rulesheets.loads('x = 2*3'))"
    code = f"{solved}; print('pint' in sys.modules)"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "False"


@pytest.mark.parametrize("text", ["kJ/kg.K", "W/(m2.K)", "ft.lbf", "in."])
def test_a_point_between_names_multiplies(text: str) -> None:
    assert library().unit(text) == library().unit(text.removesuffix(".").replace(".", "-"))


@pytest.mark.parametrize(
    ("unit", "cure"), [("J/kgK", "kg-K"), ("W/m2K", "m2-K"), ("Btu/lbF", "lb-F")]
)
def test_joined_names_are_told_apart(unit: str, cure: str) -> None:
    with pytest.raises(rulesheets.RuleSheetError) as caught:
        rulesheets.loads(f"variables\n  c [{unit}]\nrules\n  c = 2*x")
    assert caught.value.diagnoses[0].notes == (f"write {cure} for a product of units",)


def test_a_millikelvin_meant_as_metre_and_kelvin_is_told() -> None:
    """A conductivity in W/mK is in watts per millikelvin."""
    text = "variables\n  k [W/mK]\n  A [m^2]\n  T [K]\n  L [m]\n  Q [W]\nrules\n  Q = k*A*T/L"
    (warning,) = rulesheets.loads(text).unit_warnings
    assert warning.notes[0].endswith("for metre times kelvin write W/m-K")
    assert not rulesheets.loads(text.replace("mK", "m-K")).unit_warnings
