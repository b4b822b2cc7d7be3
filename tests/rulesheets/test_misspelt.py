"""Mistakes of spelling that leave a sheet readable, or make its end unreadable."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
from rulesheets.diagnosis import RuleSheetError, closest, side_by_side
from rulesheets.functions import TABLE
from tests.everyday.corpus import Sheet, sheets
from tests.sampling import sampled

LETTERS = "abcdefghijklmnopqrstuvwxyz"
SLIPS: dict[str, Callable[[str, int, str], str]] = {
    "lost": lambda word, at, letter: word[:at] + word[at + 1 :],
    "added": lambda word, at, letter: word[:at] + letter + word[at:],
    "replaced": lambda word, at, letter: word[:at] + letter + word[at + 1 :],
    "swapped": lambda word, at, letter: word[:at] + word[at : at + 2][::-1] + word[at + 2 :],
    "case": lambda word, at, letter: word.swapcase(),
}


@given(st.permutations("tand"), st.permutations("atan2"))
def test_the_same_letters_in_another_order_are_nearest(one: list[str], other: list[str]) -> None:
    known = ("tan", "atan", "tand", "tanh", "atan2", "atand", "and")
    assert closest("".join(one), known) == "tand" or one == list("tand")
    assert closest("".join(other), known) == "atan2" or other == list("atan2")


@pytest.mark.parametrize("sheet", sampled(sheets(), 12), ids=lambda sheet: sheet.name)
def test_a_misspelt_name_is_told_where_it_stands(sheet: Sheet) -> None:
    model, draw = sheet.model, random.Random(sheet.name)
    assert not [note for note in model.notes if note.code == "E221"]
    if any(variable.span is None for variable in model.variables.values()):
        pytest.skip("not every name has a row")
    lines = sheet.text.split("\n")
    begin = next(k for k, line in enumerate(lines) if line.strip() == "rules") + 1
    words = [
        (number, found.start(), found[0])
        for number, line in enumerate(lines[begin:], begin)
        for found in re.finditer(r"(?<![\w.'])[^\W\d]\w{2,}", line.partition('"')[0])
        if found[0] in model.variables
    ]
    right = told = 0
    for kind, slip in SLIPS.items() if words else ():
        number, start, name = draw.choice(words)
        written = slip(name, draw.randrange(len(name) - 1), draw.choice(LETTERS))
        other = written in TABLE or side_by_side(written, model.variables)  # what it may mean
        if other or not re.fullmatch(r"[^\W\d]\w*", written):
            continue
        line = lines[number][:start] + written + lines[number][start + len(name) :]
        text = "\n".join([*lines[:number], line, *lines[number + 1 :]])
        (note,) = rulesheets.loads(text).notes
        place = note.labels[0].span
        assert (place.line, place.text) == (number + 1, written), kind
        told += 1
        right += note.notes == (f"is {name} meant?",)
    assert right >= told - 2


@pytest.mark.parametrize("word", ["ules", "rles", "rulse", "tules"])
@pytest.mark.parametrize("rule", ["v = 3*t", "v = 3*t + ", "if t > 3 then v = 3"])
def test_a_misspelt_head_is_told_in_its_line(word: str, rule: str) -> None:
    text = f"variables\n  t = 3\n  v\n{word}\n  {rule}\n"
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.loads(text)
    (wrong,) = caught.value.diagnoses
    assert wrong.labels[0].span.line == 4 and wrong.notes == ("did you mean rules?",)


@pytest.mark.parametrize("unit", ["kg/m-s", "W/m^2-K", "N*m", "1/m^-2", "kN-m^2*s"])
def test_signs_that_look_alike_are_read_alike_in_units(unit: str) -> None:
    alike = unit.replace("-", "−").replace("*", "×")
    written, looking = (
        rulesheets.loads(f"variables\n  a = 1 [{one}]\nrules\n  b = a\n") for one in (unit, alike)
    )
    assert written.variables["a"].measure == looking.variables["a"].measure


@pytest.mark.parametrize("kind", SLIPS)
@pytest.mark.parametrize("name", ["length", "breadth", "area"])
def test_a_misspelt_name_of_a_function_is_told_where_it_stands(kind: str, name: str) -> None:
    written = SLIPS[kind](name, 2, "q")
    rules = "area = length*breadth + half\n  half = spare/2".replace(name, written)
    head = "function f(length, breadth; area)\nparameters spare\nrules\n  "
    model = rulesheets.loads(f"spare = 4\ny = f(2, 3)\n{head}{rules}\n")
    (note,) = model.notes
    assert note.code == "E221" and note.notes == (f"is {name} meant?",)
    assert note.labels[0].span.text == written
