"""A model that was kept is the model that was built: every node, every place."""

from __future__ import annotations

import os
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
from rulesheets import kept, loading, store
from rulesheets.diagnosis import RuleSheetError
from rulesheets.model import Equation, Model
from rulesheets.nodes import Negative, Number, RuleSheet
from rulesheets.packing import Packing, Unpackable, Unpacking
from rulesheets.program import Program
from rulesheets.record import replace
from rulesheets.source import Source, Span
from tests.rulesheets.sheets import expressions

MODELS = rulesheets.shipped_models()
SOURCE = Source("<text>", "x")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "store"
    monkeypatch.setenv("BACKSOLVE_CACHE", str(place))
    return place


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the models that had to be built."""
    names: list[str] = []

    def keep(model: Any, *rest: Any) -> Any:
        names.append(model.name)
        return kept.keep_model(model, *rest)

    monkeypatch.setattr(loading, "keep_model", keep)
    return names


def whole(value: Any) -> Any:
    """A value with all fields of its records, those included that equality ignores."""
    if isinstance(value, Source):
        return value.name, hash(value.text)
    if hasattr(value, "__record__"):
        return type(value).__qualname__, [whole(getattr(value, name)) for name in type(value).__match_args__]
    if isinstance(value, tuple):
        return tuple(map(whole, value))
    if isinstance(value, Mapping):
        return {name: whole(item) for name, item in value.items()}
    return type(value), repr(value)


@pytest.mark.parametrize("name", MODELS)
def test_a_kept_model_is_the_built_one(name: str, folder: Path, built: list[str]) -> None:
    fresh, again = rulesheets.load(name), rulesheets.load(name)
    assert built == [fresh.name]
    assert [equation.names for equation in again.equations] == [
        equation.names for equation in fresh.equations
    ]
    assert whole(again) == whole(fresh)
    assert whole(pickle.loads(pickle.dumps(rulesheets.load(name)))) == whole(fresh)


@given(st.lists(st.tuples(expressions, expressions), min_size=1, max_size=4))
@settings(max_examples=30, deadline=None)
def test_any_expression_comes_back(sides: list[tuple[Any, Any]]) -> None:
    packing = Packing()
    packed = packing.pack(tuple(sides))
    assert whole(Unpacking(packing.classes).unpack(packed)) == whole(tuple(sides))


def test_only_records_of_this_program_are_packed_and_made() -> None:
    with pytest.raises(Unpackable):
        Packing().pack((1, object()))
    for name in ("os:system", "rulesheets.loading:load", "rulesheets.nodes:nothing", "builtins:eval"):
        with pytest.raises(Unpackable):
            Unpacking([name])


def sheet(folder: Path, **files: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.tk").write_text(text)
    return folder / "main.tk"


def codes(path: Path) -> list[str]:
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.load(path)
    return [diagnosis.code for diagnosis in caught.value.diagnoses]


MAIN = 'use "area.tk"\ncall area(r; A)\nr = 2\n'
AREA = "function area(r; A)\nrules\n  A = pi()*r^2\n"


def test_a_change_of_any_file_is_noticed(tmp_path: Path, folder: Path, built: list[str]) -> None:
    path = sheet(tmp_path / "a", main=MAIN, area=AREA)
    assert len(rulesheets.load(path).equations) == len(rulesheets.load(path).equations) == 2
    sheet(tmp_path / "a", area=AREA + "  2*r = 1 + r\n")
    assert len(rulesheets.load(path).equations) == 3
    sheet(tmp_path / "a", main=MAIN + "q = 1\n")
    assert len(rulesheets.load(path).equations) == 4
    assert built == ["main"] * 3
    sheet(tmp_path / "a", main=MAIN)
    rulesheets.load(path)
    assert built == ["main"] * 3


def test_a_used_file_that_is_gone_is_told_as_ever(tmp_path: Path, folder: Path) -> None:
    path = sheet(tmp_path / "a", main=MAIN, area=AREA)
    rulesheets.load(path)
    (tmp_path / "a" / "area.tk").unlink()
    assert codes(path) == ["E306"]
    (tmp_path / "a" / "area.tk").mkdir()
    assert codes(path) == ["E302"]


def test_files_that_come_to_use_each_other_in_a_circle_are_told(tmp_path: Path, folder: Path) -> None:
    use = 'use "more.tk"\n'
    path = sheet(tmp_path / "a", main=MAIN, area=use + AREA, more="function more(a; b)\nrules\n  a = b\n")
    rulesheets.load(path)
    (tmp_path / "a" / "more.tk").unlink()
    (tmp_path / "a" / "more.tk").symlink_to("area.tk")
    assert codes(path) == ["E307"]


def test_names_and_places_are_those_of_this_load(
    tmp_path: Path, folder: Path, built: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = sheet(tmp_path / "a", main=MAIN, area=AREA)
    rulesheets.load(path)
    monkeypatch.chdir(tmp_path)
    again = rulesheets.load("a/main.tk")
    assert len(built) == 1
    files = [equation.rule.file for equation in again.equations]
    assert (again.name, files) == ("main", [os.path.join("a", "area.tk"), "a/main.tk"])


def test_the_same_main_sheet_in_two_folders_is_two_models(
    tmp_path: Path, folder: Path, built: list[str]
) -> None:
    one = sheet(tmp_path / "one", main=MAIN, area=AREA)
    two = sheet(tmp_path / "two", main=MAIN, area=AREA + "  q = 1\n")
    for _ in range(2):
        assert len(rulesheets.load(one).equations) == 2
        assert len(rulesheets.load(two).equations) == 3
    assert len(built) == 2


def test_a_damaged_entry_is_written_anew(tmp_path: Path, folder: Path, built: list[str]) -> None:
    path = sheet(tmp_path / "a", main=MAIN, area=AREA)
    fresh = rulesheets.load(path)
    (entry,) = folder.glob("model-*")
    entry.write_bytes(entry.read_bytes()[:-1])
    assert whole(rulesheets.load(path)) == whole(fresh)
    assert whole(rulesheets.load(path)) == whole(fresh)
    assert len(built) == 2


def test_what_is_nested_as_deeply_as_can_be_is_kept(tmp_path: Path, folder: Path, built: list[str]) -> None:
    path = sheet(tmp_path / "a", main="x = " + "sqrt(" * 90 + "y" + ")" * 90 + "\n")
    assert whole(rulesheets.load(path)) == whole(rulesheets.load(path))
    assert len(built) == 1


def test_what_cannot_be_packed_is_not_kept(folder: Path) -> None:
    expression: Any = Number(1.0)
    for _ in range(2000):
        expression = Negative(expression)
    there = Span(SOURCE, 0, 1)
    model = Model("deep", {}, (Equation(0, expression, Number(1.0), (), there),), ())
    assert kept.keep_model(model, SOURCE, "", Program(RuleSheet(), {})) is model
    assert store.usage() == (0, 0)


def test_long_texts_are_kept_and_short_ones_read(folder: Path) -> None:
    rulesheets.loads("x = 1")
    assert store.usage()[0] == 0
    text = "\n".join(f"x{i} = x{i + 1}" for i in range(2000))
    assert whole(rulesheets.loads(text)) == whole(rulesheets.loads(text))
    assert len(list(folder.glob("model-*"))) == 1


def test_models_say_which_texts_they_come_from(tmp_path: Path, folder: Path) -> None:
    one = rulesheets.load(sheet(tmp_path / "one", main=MAIN, area=AREA))
    two = rulesheets.load(sheet(tmp_path / "two", main=MAIN, area=AREA))
    three = rulesheets.load(sheet(tmp_path / "three", main=MAIN, area=AREA + "\n"))
    assert one.digest == two.digest != three.digest
    assert one.digest
    assert replace(one, variables={}).digest == rulesheets.loads("x = 1").digest == b""
