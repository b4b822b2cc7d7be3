"""The canonical print, and that it says the same as the sheet."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rulesheets.files import read_source
from rulesheets.format import (
    format_condition,
    format_expression,
    format_number,
    format_rule,
    format_sheet,
)
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source
from rulesheets.syntax.nodes import Name, Negative, Number, Power, Product, RuleSheet, Sum
from tests.rulesheets.sheets import bodies, conditions, expressions, sheets

MODELS = Path(__file__).parent.parent.parent / "models"


def read(text: str) -> RuleSheet:
    return parse(Source("sheet.tk", text))


def rule(text: str):
    return read(text).rules[0].body


@settings(max_examples=30, deadline=None)
@given(sheets)
def test_a_formatted_sheet_reads_back_as_itself(sheet: RuleSheet) -> None:
    assert read(format_sheet(sheet)) == sheet


@settings(max_examples=20, deadline=None)
@given(sheets)
def test_formatting_twice_changes_nothing(sheet: RuleSheet) -> None:
    text = format_sheet(sheet)
    assert format_sheet(read(text)) == text


@settings(max_examples=100, deadline=None)
@given(expressions)
def test_expressions_read_back(expression) -> None:
    assert rule(f"zz = {format_expression(expression)}").right == (expression,)


@settings(max_examples=60, deadline=None)
@given(conditions)
def test_conditions_read_back(condition) -> None:
    assert rule(f"if {format_condition(condition)} then zz = 1").condition == condition


@settings(max_examples=60, deadline=None)
@given(bodies)
def test_rules_read_back(body) -> None:
    assert rule(format_rule(body)) == body


@given(st.floats(0, allow_nan=False, allow_infinity=False))
def test_numbers_keep_every_bit(value: float) -> None:
    assert float(format_number(value)) == value


@pytest.mark.parametrize(
    ("value", "text"),
    [(3.0, "3"), (0.1, "0.1"), (1e-5, "1e-5"), (1e22, "1e22"), (1e15, "1000000000000000")],
)
def test_numbers_are_short(value: float, text: str) -> None:
    assert format_number(value) == text


@pytest.mark.parametrize(
    "text",
    [
        "a - b + c",
        "a - (b + c)",
        "m*9.81[m/s^2] + 5.67e-8[W/m^2-K^4]",
        "-a^2",
        "(-a)^2",
        "a^b^c",
        "(a^b)^c",
        "2^-3",
        "a/b*c",
        "a/(b*c)",
        "a*-b",
        "-(a*b)",
        "f(a, b)^2",
        "sqrt((a - b)^2 + c^2)",
        "pi*r^2",
        "a + -b*c",
    ],
)
def test_parentheses_stand_only_where_needed(text: str) -> None:
    assert format_expression(rule(f"zz = {text}").right[0]) == text


def test_negative_numbers_of_other_stages_are_parenthesised_in_powers() -> None:
    assert format_expression(Power(Number(-2.0), Number(2.0))) == "(-2)^2"
    assert format_expression(Product(Number(-2.0), Name("x"))) == "-2*x"
    assert format_expression(Sum((Name("x"), Negative(Number(-2.0))))) == "x - -2"


def test_the_whole_layout() -> None:
    sheet = read(
        """
" A crank ; by hand
USE "a.tk","b.tk" ; functions
Variables
branch='open " open or crossed
omegaAO = -15 [rad/s->rpm]
" angles

thetaAO ~ +30 in [ -180 , 180 ] " of AO
xB > 0
Rules " the relations
CALL Position ( thetaAO ; xA , xB )
if branch='open then xB-xA=+sqrt(AB^2-(yB-yA)^2) " open
 else xB-xA=-sqrt(AB^2-(yB-yA)^2) " crossed

x = 1 " one
" above f
function f(a;x)
parameters AB ; shared
rules
x=a
"""
    )
    assert format_sheet(sheet) == (
        """" A crank ; by hand
use "a.tk", "b.tk"  " functions

variables
  branch  = 'open                                " open or crossed
  omegaAO = -15                  [rad/s -> rpm]
  " angles

  thetaAO ~ 30    in [-180, 180]                 " of AO
  xB              > 0

rules
  " the relations
  call position(thetaAO; xA, xB)
  if branch = 'open then xB - xA = sqrt(AB^2 - (yB - yA)^2)
                    else xB - xA = -sqrt(AB^2 - (yB - yA)^2)  " open; crossed

  x = 1                                                       " one

" above f
function f(a; x)
parameters AB  " shared
rules
  x = a
"""
    )


def test_long_chains_stand_arm_by_arm() -> None:
    text = (
        "if a > 1 then x = 1 else if a > 2 then x = a_very_long_name else if a > 3 then x = 3 "
        "else x = 4"
    )
    assert format_sheet(read(text)).splitlines()[1:] == [
        "  if a > 1 then x = 1",
        "    else if a > 2 then x = a_very_long_name",
        "    else if a > 3 then x = 3",
        "    else x = 4",
    ]


@pytest.mark.parametrize(
    "path", sorted(MODELS.glob("**/*.tk")), ids=lambda path: str(path.relative_to(MODELS))
)
def test_models_keep_their_meaning(path: Path) -> None:
    sheet = parse(read_source(path))
    text = format_sheet(sheet)
    assert read(text) == sheet
    assert format_sheet(read(text)) == text
