"""Short names of files."""

from __future__ import annotations

from solver.report.places import short_names


def test_a_file_name_alone_where_it_is_unique() -> None:
    assert short_names(["/m/a/x.tk", "/m/a/y.tk"]) == {"/m/a/x.tk": "x.tk", "/m/a/y.tk": "y.tk"}


def test_a_folder_where_two_files_share_a_name() -> None:
    assert short_names(["/m/a/x.tk", "/m/b/x.tk"]) == {"/m/a/x.tk": "a/x.tk", "/m/b/x.tk": "b/x.tk"}


def test_a_name_that_ends_another_is_kept_apart() -> None:
    assert short_names(["x.tk", "/m/x.tk"]) == {"x.tk": "x.tk", "/m/x.tk": "m/x.tk"}
