"""Lines that are read without argparse say what argparse says of them."""

from __future__ import annotations

from argparse import ArgumentParser
from importlib import import_module

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.cli import COMMANDS
from solver.commands.syntax import Syntax

WORDS = [
    "crank",
    "a.csv",
    "x=3",
    "",
    "-3",
    "-",
    "--",
    "--nothing",
    "-h",
    "--all=1",
    "--set=x=-3",
    "-o=f",
    "two words",
]


def syntax(command: str) -> Syntax:
    found = Syntax()
    import_module(f"solver.commands.{command}").add_arguments(found)
    return found


def by_argparse(told: Syntax, words: list[str]) -> dict[str, object] | None:
    parser = ArgumentParser(allow_abbrev=False)
    told.declare(parser)
    parser.error = None  # type: ignore[assignment, method-assign]
    try:
        return vars(parser.parse_intermixed_args(words))
    except (TypeError, SystemExit):
        return None


@pytest.mark.parametrize("command", COMMANDS)
@given(data=st.data())
@settings(max_examples=60, deadline=None)
def test_a_line_means_what_argparse_takes_it_for(command: str, data: st.DataObject) -> None:
    told = syntax(command)
    flags = [flag for argument in told.arguments for flag in argument.flags if flag.startswith("-")]
    words = data.draw(st.lists(st.sampled_from(flags + WORDS), max_size=6))
    found = told.read(words)
    if found is not None:
        assert vars(found) == by_argparse(told, words)


@pytest.mark.parametrize(
    "line",
    [
        "solve offset_slider_crank",
        "solve crank.tk inputs.csv --all --json",
        "solve --set xB=9.79 crank --clear thetaAO --want thetaAO,omegaAO --set=vB=-3 -o out.csv",
        "path crank --want x",
        "check crank",
    ],
)
def test_usual_lines_need_no_argparse(line: str) -> None:
    command, *words = line.split()
    told = syntax(command)
    found = told.read(words)
    assert found is not None
    assert vars(found) == by_argparse(told, words)


@pytest.mark.parametrize(
    "line", ["solve", "solve -h", "solve a b c", "solve a --json --csv", "solve a --nothing", "solve a --set"]
)
def test_help_and_mistakes_are_left_to_argparse(line: str) -> None:
    command, *words = line.split()
    assert syntax(command).read(words) is None


def test_what_is_read_leaves_the_declaration_as_it_is() -> None:
    told = syntax("solve")
    assert told.read(["a", "--set", "x=1"]).set == ["x=1"]  # type: ignore[union-attr]
    assert told.read(["a"]).set == []  # type: ignore[union-attr]
