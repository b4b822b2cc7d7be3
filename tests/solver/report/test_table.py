"""Text tables."""

from __future__ import annotations

from solver.report import table, width


def test_columns_are_as_wide_as_their_widest_cell() -> None:
    assert table(("A", "Long"), [("abc", "1"), ("", "2")]).split("\n") == [
        "A    Long",
        "---  ----",
        "abc  1",
        "     2",
    ]


def test_a_least_width_keeps_the_next_column_in_its_place() -> None:
    short, long = (table(("N", "U"), [(number, "mm")], least=(8,)) for number in ("1", "12345678"))
    assert short.splitlines()[2].index("mm") == long.splitlines()[2].index("mm")


def test_a_table_without_rows_is_its_header() -> None:
    assert table(("A", "B"), []) == "A  B\n-  -"


def test_wide_and_combining_characters_take_their_cells() -> None:
    assert width("角度") == 4
    assert width("e\u0301") == 1
    lines = table((), [("角", "x"), ("ab", "y")]).split("\n")
    assert [width(line) for line in lines] == [5, 5]


def test_a_cell_cannot_move_the_cursor() -> None:
    assert table((), [("a\x1b[31m\nb", "c")]) == "a [31m b  c"
