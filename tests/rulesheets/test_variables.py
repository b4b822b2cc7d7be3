"""Variable sheets as CSV, values as text, and the overriding of inputs."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets import RuleSheetError, loads
from rulesheets.inputs import override, parse_value
from rulesheets.variables import VariableSheet, read_variable_sheet

MODEL = loads(
    "variables\n  branch = 'open\n  AO = 3 [m]\n  theta = -30 in [-180, 180]\n  r > 0\n  xA ~ 2\n"
    "rules\n  call crank(theta; xA, r)\n"
    "function crank(t; x, r)\nparameters AO, branch\nrules\n"
    "  yB = AO*sind(t)\n  x = AO*cosd(t)\n  r = yB^2\n  if branch = 'open then s = yB\n",
    name="crank",
)


def codes(caught: pytest.ExceptionInfo[RuleSheetError]) -> list[str]:
    return [diagnosis.code for diagnosis in caught.value.diagnoses]


def read(tmp_path, text: str) -> VariableSheet:
    path = tmp_path / "sheet.csv"
    path.write_text(text, encoding="utf-8")
    return read_variable_sheet(path, MODEL)


def test_values_symbols_blanks_guesses_and_comments(tmp_path):
    sheet = read(
        tmp_path,
        "St,Input,Name,Output,Unit,Comment\n"
        ",'open,branch,,,\n,2*3,AO,,m,length\nC,this row only comments,,,,\n"
        ",,theta,53.1,,\nG,1.5,xA,,,\n,,,,,\n",
    )
    assert sheet.inputs == {"branch": "open", "AO": 6.0, "theta": None, "xA": None}
    assert sheet.guesses == {"xA": 1.5}


def test_capitals_order_and_missing_columns_do_not_matter(tmp_path):
    assert read(tmp_path, "NAME,input\nAO,4\n").inputs == {"AO": 4.0}


def test_bom_semicolons_and_windows_lines(tmp_path):
    assert read(tmp_path, "\ufeffName;Input\r\nAO;4\r\n").inputs == {"AO": 4.0}


def test_locals_are_named_in_full(tmp_path):
    assert read(tmp_path, "Name,Input\ncrank.yB,1\n").inputs == {"crank.yB": 1.0}


@pytest.mark.parametrize(
    ("text", "code", "line", "column"),
    [
        ("St,Input\n,3\n", "E410", None, None),
        ("", "E410", None, None),
        ("Name,Imput\nAO,3\n", "E411", 1, 6),
        ("Name,Input,input\nAO,3,4\n", "E411", 1, 12),
        ("Name,Input,St\nAO,3,X\n", "E412", 2, 6),
        ("Name,Input,St\nAO,3,L\n", "E412", 2, 6),
        ("Name,Input\n,3\n", "E413", 2, 1),
        ("Name,Input\nAO,3\nAO,4\n", "E414", 3, 1),
        ("Name,Input\nAO,3,4\n", "E415", 2, 1),
        ("Name,Input,Unit\nAO,3,kg\n", "E461", 2, 4),
        ("Name,Input\nA0,3\n", "E407", 2, 1),
        ("Name,Input\nAO,1/0\n", "E402", 2, 4),
        ("Name,Input\nAO,nan\n", "E402", 2, 4),
        ("Name,Input\nAO,3+\n", "E406", 2, 4),
        ("Name,Input\nAO,2*theta\n", "E401", None, None),
        ("Name,Input,St\nAO,open,G\n", "E404", 2, 4),
    ],
)
def test_what_is_wrong_is_told_with_its_place(tmp_path, text, code, line, column):
    with pytest.raises(RuleSheetError) as caught:
        read(tmp_path, text)
    assert codes(caught) == [code]
    if line is not None:
        span = caught.value.diagnoses[0].labels[0].span
        assert (span.line, span.column) == (line, column)


def test_rows_of_no_variable_are_told_beside_the_others(tmp_path):
    with pytest.raises(RuleSheetError) as caught:
        read(tmp_path, "Name,Input,St\nAO,3,L\n,3,\nA0,3,\nAB,3,X\n")
    assert codes(caught) == ["E412", "E413", "E407", "E412"]


def test_all_wrong_rows_are_told_at_once(tmp_path):
    with pytest.raises(RuleSheetError) as caught:
        read(tmp_path, "Name,Input\nA0,3\nAO,1/0\n")
    assert codes(caught) == ["E407", "E402"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3", 3.0),
        (" -30 ", -30.0),
        ("+.5", 0.5),
        ("1e-3", 1e-3),
        ("2*3", 6.0),
        ("pi", math.pi),
        ("pi()/2", math.pi / 2),
        ("sqrt(16)", 4.0),
        ("'open", "open"),
        ("open", "open"),
        ("'pi", "pi"),
        ("-(2+1)", -3.0),
    ],
)
def test_values_as_text(text, value):
    assert parse_value(text) == value


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "E406"),
        ("abc+", "E406"),
        ("1_000", "E406"),
        ("3 4", "E406"),
        ("x = 3", "E406"),
        ("2*x", "E401"),
        ("inf", "E402"),
        ("-nan", "E402"),
        ("1e999", "E402"),
        ("ln(0)", "E402"),
        ("sqr(4)", "E201"),
        ("sqrt(1, 2)", "E203"),
        ("2*'open", "E211"),
    ],
)
def test_texts_that_are_no_values(text, code):
    with pytest.raises(RuleSheetError) as caught:
        parse_value(text)
    assert codes(caught) == [code]


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_float_is_read_as_it_is_written(number):
    assert parse_value(repr(number)) == number


def test_inputs_are_the_sheets_overridden_by_the_callers():
    inputs = override(MODEL, {"theta": 45, "branch": None, "xA": 2.5}, {"r": 7})
    assert inputs.values == {"AO": 3.0, "theta": 45.0, "xA": 2.5}
    assert inputs.guesses == {"xA": 2.0, "r": 7.0}
    assert override(MODEL).values == {"branch": "open", "AO": 3.0, "theta": -30.0}


def test_symbols_are_read_with_and_without_their_apostrophe():
    assert override(MODEL, {"branch": "'crossed"}).values["branch"] == "crossed"
    assert override(MODEL, {"branch": "crossed"}).values["branch"] == "crossed"


@pytest.mark.parametrize(
    ("inputs", "guesses", "code", "note"),
    [
        ({"thta": 3}, {}, "E407", "did you mean theta?"),
        ({"yB": 3}, {}, "E407", "its full name is crank.yB"),
        ({"thta": None}, {}, "E407", "did you mean theta?"),
        ({}, {"ao": 3}, "E407", "did you mean AO?"),
        ({"theta": math.nan}, {}, "E402", None),
        ({"AO": math.inf}, {}, "E402", None),
        ({"theta": 181}, {}, "E403", None),
        ({"r": 0}, {}, "E403", None),
        ({"AO": "3"}, {}, "E406", None),
        ({}, {"AO": math.inf}, "E402", None),
        ({}, {"AO": "open"}, "E404", None),
    ],
)
def test_wrong_inputs_are_refused(inputs, guesses, code, note):
    with pytest.raises(RuleSheetError) as caught:
        override(MODEL, inputs, guesses)
    assert codes(caught) == [code]
    assert note is None or note in caught.value.diagnoses[0].notes


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("eta = Po/Pi\nPi = U*I", {"eta", "Po", "Pi", "U", "I"}),
        ('variables\n  PI = 4 [W] " power\nrules\n  eta = Po/PI', {"eta", "Po", "PI"}),
        ("r = a/pi\n  Pi=3*pi", {"r", "a", "Pi"}),
        ("charge = pI - pH\npI = (pK1 + pK2)/2", {"charge", "pI", "pH", "pK1", "pK2"}),
        ("eta = Pi/r\nr = Pi*PI", {"eta", "r"}),
    ],
)
def test_a_row_or_a_rule_that_begins_with_pi_in_capitals_names_a_variable(
    text: str, names: set[str]
):
    assert loads(text).variables.keys() == names


def test_the_ends_of_a_range_belong_to_it_unless_they_are_open():
    assert override(MODEL, {"theta": 180}).values["theta"] == 180.0
    assert override(MODEL, {"r": 5e-324}).values["r"] == 5e-324
