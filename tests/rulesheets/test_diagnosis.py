"""The renderer: where the caret stands, what is cut, what is coloured; and the catalogue."""

from __future__ import annotations

import pickle
import re
import traceback

import pytest

import rulesheets
from rulesheets.diagnosis import (
    Diagnosis,
    Label,
    RuleSheetError,
    Severity,
    catalogue,
    error,
    render,
)
from rulesheets.syntax import Source, Span


def at(text: str, marked: str, name: str = "s.tk") -> Span:
    start = text.index(marked)
    return Span(Source(name, text), start, start + len(marked))


def caret_column(lines: list[str], index: int) -> tuple[int, int]:
    found = re.search(r"\^+", lines[index])
    assert found is not None
    return found.start(), found.end()


def test_the_page() -> None:
    text = "a = b\nvAB = -omegaAB AB\n"
    diagnosis = error(
        "E105",
        None,
        Label(at(text, "omegaAB AB"), "side by side"),
        Label(at(text, "b\n"), "first"),
        notes=("write omegaAB*AB", "really"),
    )
    assert render(diagnosis).splitlines() == [
        "error[E105]: a product needs a `*`",
        " --> s.tk:2:8",
        "  |",
        "2 | vAB = -omegaAB AB",
        "  |        ^^^^^^^^^^ side by side",
        " --> s.tk:1:5",
        "  |",
        "1 | a = b",
        "  |     ^ first",
        "  |",
        "  = help: write omegaAB*AB",
        "  = note: really",
    ]


def test_without_a_place() -> None:
    assert render(Diagnosis("S520", Severity.WARNING, "odd")) == "warning[S520]: odd"


def test_the_gutter_is_as_wide_as_the_largest_line_number() -> None:
    text = "x = 1\n" * 120 + "here"
    lines = render(error("E101", "m", Label(at(text, "here")), Label(at(text, "x")))).splitlines()
    assert lines[3] == "121 | here"
    assert lines[7] == "  1 | x = 1"


@pytest.mark.parametrize("before", ["", "a\t", "\t\t", "é = ", "x" * 500 + " "])
@pytest.mark.parametrize("after", ["", " + 1", "\tz", " " + "y" * 500])
def test_the_caret_stands_below_what_it_means(before: str, after: str) -> None:
    text = f"one = 1\n{before}MARKED{after}\nthree = 3"
    lines = render(error("E101", "m", Label(at(text, "MARKED")))).splitlines()
    start, end = caret_column(lines, 4)
    assert lines[3][start:end] == "MARKED"
    assert len(lines[3]) < 150


def test_a_mark_longer_than_the_page_is_cut() -> None:
    text = "x = " + "y" * 1000
    lines = render(error("E101", "m", Label(at(text, "y" * 1000), "long"))).splitlines()
    assert len(lines[3]) < 150
    assert lines[4].endswith("^ long")


def test_a_mark_over_several_lines_shows_its_first() -> None:
    lines = render(error("E101", "m", Label(at("a = (b\n + c)", "(b\n + c)")))).splitlines()
    assert lines[3:5] == ["1 | a = (b", "  |     ^^"]


def test_places_beyond_the_end_have_a_caret() -> None:
    source = Source("s.tk", "a =")
    lines = render(error("E101", "m", Label(Span(source, 3, 4)))).splitlines()
    assert lines[3:5] == ["1 | a =", "  |    ^"]


def test_messages_of_absurd_length_are_cut() -> None:
    assert len(render(error("E101", "m" * 10_000, notes=("n" * 10_000,)))) < 1200


def test_colour_changes_nothing_but_colour() -> None:
    diagnosis = error("E101", "m", Label(at("a = b", "b"), "label"), notes=("help",))
    coloured = render(diagnosis, color=True)
    assert "\x1b[" in coloured
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == render(diagnosis)


def test_the_title_is_the_message_unless_one_is_given() -> None:
    assert error("E109").message == catalogue()["E109"].title
    assert error("E109", "other").message == "other"


def test_an_error_reads_as_its_messages() -> None:
    assert str(RuleSheetError(error("E109", "one"), error("E101", "two"))) == "one\ntwo"


@pytest.mark.parametrize("code", sorted(catalogue()))
def test_catalogue_entries_are_sentences(code: str) -> None:
    entry = catalogue()[code]
    assert re.fullmatch(r"[ESW][1-6]\d\d", code)
    assert not entry.title.endswith(".")
    assert entry.cause.endswith((".", "]", "?"))
    assert entry.fix.endswith((".", "`"))


def test_a_traceback_ends_with_place_and_cure() -> None:
    with pytest.raises(rulesheets.RuleSheetError) as caught:
        rulesheets.loads("y = 2x")
    shown = "".join(traceback.format_exception_only(caught.value))
    assert "y = 2x" in shown
    assert shown.rstrip().endswith("= help: write 2*x")
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.diagnoses == caught.value.diagnoses
