"""Files, folders, shipped names and the functions that sheets use."""

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

import pytest

import rulesheets
from rulesheets import RuleSheetError, load, loading, loads
from rulesheets.files import find_sheet, shipped_models
from rulesheets.functions import TABLE
from rulesheets.library import library
from rulesheets.parse.sections import parse
from rulesheets.syntax.nodes import Name


def codes(caught: pytest.ExceptionInfo[RuleSheetError]) -> list[str]:
    return [diagnosis.code for diagnosis in caught.value.diagnoses]


@pytest.fixture
def crank(tmp_path):
    folder = tmp_path / "crank"
    (folder / "parts").mkdir(parents=True)
    (folder / "model.tk").write_text('use "parts/pin.tk", "parts/rod.tk"\n\nx = pin(30) + rod(2)\n')
    (folder / "parts" / "pin.tk").write_text(
        'use "rod.tk"\n\nfunction pin(a; b)\nrules\n  b = rod(a) + 1\n'
    )
    (folder / "parts" / "rod.tk").write_text("function rod(a; b)\nrules\n  b = 2*a\n")
    return folder


def test_a_file_a_folder_and_a_path_object_load_the_same_model(crank):
    models = [load(crank / "model.tk"), load(str(crank)), load(crank)]
    assert {model.name for model in models} == {"crank"}
    assert len({model.equations for model in models}) == 1


def test_use_is_relative_to_the_file_that_names_it_and_reads_a_file_once(crank):
    model = load(crank)
    assert "pin.rod.b" in model.variables
    assert {os.path.basename(item.rule.file) for item in model.equations} == {
        "model.tk",
        "pin.tk",
        "rod.tk",
    }


def test_a_text_uses_files_relative_to_its_base(crank):
    model = loads('use "rod.tk"\ny = rod(x) + 1', base=crank / "parts")
    assert list(model.variables) == ["y", "x", "rod.b"]


def test_a_missing_file_in_use_is_refused(crank):
    (crank / "model.tk").write_text('use "parts/pim.tk"\ny = pin(x)\n')
    with pytest.raises(RuleSheetError) as caught:
        load(crank)
    assert "E306" in codes(caught)
    assert "did you mean pin.tk?" in caught.value.diagnoses[0].notes


def test_a_circle_of_uses_is_refused(crank):
    (crank / "parts" / "rod.tk").write_text('use "pin.tk"\nfunction rod(a; b)\nrules\n  b = 2*a\n')
    with pytest.raises(RuleSheetError) as caught:
        load(crank)
    assert "E307" in codes(caught)


def test_a_long_chain_of_uses_is_followed(tmp_path):
    for k in range(300):
        (tmp_path / f"f{k}.tk").write_text(
            f'use "f{k + 1}.tk"\nfunction f{k}(a; b)\nrules\n  b = a\n'
        )
    (tmp_path / "f300.tk").write_text("function f300(a; b)\nrules\n  b = 2*a\n")
    assert len(loads('use "f0.tk"\ny = f300(x)', base=tmp_path).equations) == 1


def test_an_unknown_bare_name_is_refused():
    with pytest.raises(RuleSheetError) as caught:
        load("no_such_linkage_anywhere")
    assert codes(caught) == ["E309"]


def test_shipped_models_are_found_by_name():
    assert "offset_slider_crank" in shipped_models()
    assert find_sheet("offset_slider_crank").endswith("model.tk")
    assert load("offset_slider_crank").name == "offset_slider_crank"


def test_a_missing_path_is_refused(tmp_path):
    with pytest.raises(RuleSheetError):
        load(tmp_path / "nothing.tk")


def test_everything_wrong_is_told_at_once():
    with pytest.raises(RuleSheetError) as caught:
        loads("y = sqr(x)\nz = atan2d(1)\nsin = 2")
    assert sorted(codes(caught)) == ["E201", "E203", "E210"]


def test_variables_keep_the_order_of_the_section_then_of_the_rules():
    model = loads(
        'variables\n  b = 2 [mm]  " width\n  a ~ 3\n  unused\nrules\n  c = a + b\n  d = c\n'
    )
    assert list(model.variables) == ["b", "a", "unused", "c", "d"]
    assert [item.posted for item in model.variables.values()] == [True] * 5
    assert model.variables["b"].value == 2.0
    assert model.variables["b"].unit == "mm"
    assert model.variables["b"].comment.strip() == "width"
    assert (model.variables["a"].value, model.variables["a"].guess) == (None, 3.0)


def test_inputs_are_evaluated_once():
    model = loads(
        "variables\n  a = 2*3 + sqrt(16)\n  b = 'open\n  c = -30\n  d = pi()\nrules\n  a = c"
    )
    values = {name: item.value for name, item in model.variables.items()}
    assert values == {"a": 10.0, "b": "open", "c": -30.0, "d": 3.141592653589793}


@pytest.mark.parametrize("name", ["y0", "y1", "j1", "gamma", "beta", "step", "e", "sum"])
def test_names_that_sheets_need_stay_free(name):
    assert name in loads(f"{name} + 1 = x").variables


def test_a_declared_variable_may_share_the_name_of_a_function_of_the_sheet():
    model = loads(
        "variables\n  area\nrules\n  area = 2*area(x)\nfunction area(a; b)\nrules\n  b = a^2\n"
    )
    assert list(model.variables) == ["area", "x", "area.b"]


def test_every_public_name_is_there():
    for name in rulesheets.__all__:
        assert getattr(rulesheets, name) is not None
    with pytest.raises(AttributeError):
        rulesheets.nothing_of_the_kind  # noqa: B018


@pytest.fixture
def parses(tmp_path, monkeypatch):
    """The texts that are parsed, of a user whose cache is empty."""
    monkeypatch.setenv("BACKSOLVE_CACHE", str(tmp_path / "cache"))
    seen: list[str] = []
    monkeypatch.setattr(
        rulesheets.parse.sections,
        "parse",
        lambda source: (seen.append(source.name), parse(source))[1],
    )
    return seen


def test_a_model_is_made_again_only_after_a_change(crank, parses):
    first = load(crank)
    assert len(parses) == 3
    again = load(crank)
    assert len(parses) == 3
    assert again == first
    assert [item.rule for item in again.equations] == [item.rule for item in first.equations]
    (crank / "parts" / "rod.tk").write_text("function rod(a; b)\nrules\n  b = 3*a\n")
    assert load(crank).equations != first.equations
    assert len(parses) == 6


def test_a_damaged_entry_is_made_again(crank, parses):
    first = load(crank)
    for entry in (crank.parent / "cache").glob("model-*"):
        entry.write_bytes(entry.read_bytes()[:-1])
    assert load(crank) == first
    assert len(parses) == 6


def test_a_kept_model_lies_where_its_files_lie(crank, parses, monkeypatch):
    """Of relative paths the same name may mean another file, and links may lead elsewhere."""
    monkeypatch.chdir(crank)
    first = load("model.tk")
    other = crank.parent / "other" / crank.name
    shutil.copytree(crank, other)
    monkeypatch.chdir(other)
    assert load("model.tk").files == tuple(
        str(other / Path(file).relative_to(crank)) for file in first.files
    )
    outside = crank.parent / "rod.tk"
    (other / "parts" / "rod.tk").rename(outside)
    (other / "parts" / "rod.tk").symlink_to(outside)
    assert load("model.tk") == first
    with pytest.raises(RuleSheetError) as caught:
        load("model.tk", within=".")
    assert codes(caught) == ["E311", "E311"]


def test_a_sheet_of_the_same_name_and_text_is_another_file(tmp_path, parses, monkeypatch):
    for folder in (tmp_path / "one", tmp_path / "other"):
        folder.mkdir()
        (folder / "sheet.tk").write_text("y = 2*x\n")
        monkeypatch.chdir(folder)
        assert load("sheet.tk").files == (str(folder / "sheet.tk"),)


def test_code_is_told_from_other_code_by_what_is_written(tmp_path):
    """What Python compiles at the first start does not make the kept models those of other code."""
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "thing.py").write_text("x = 1\n")
    first = loading.stamp.__wrapped__(str(tmp_path))
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__" / "thing.pyc").write_bytes(b"compiled")
    assert loading.stamp.__wrapped__(str(tmp_path)) == first
    (tmp_path / "room" / "thing.py").write_text("x = 20\n")
    assert loading.stamp.__wrapped__(str(tmp_path)) != first


def test_a_model_is_written_without_what_was_found_out_about_it():
    model = loads("x + 1.5*y = 2\ny + 2.5*z = 3\nz = x*y\n")
    size = len(pickle.dumps(model))
    for equation in model.equations:
        assert equation.left != equation.right
        equation.__dict__["_found"] = object
    assert len(pickle.dumps(model)) == size
    assert pickle.loads(pickle.dumps(model)) == model


def test_sheets_without_units_of_their_own_share_them():
    assert library() is loads("x = 2*y").units


def test_a_wrong_sheet_is_wrong_every_time(tmp_path, parses):
    (tmp_path / "wrong.tk").write_text("a = 2 b\nc = = 3\n")
    for _ in range(2):
        with pytest.raises(RuleSheetError) as caught:
            load(tmp_path / "wrong.tk")
        assert codes(caught) == ["E105", "E104"]


@pytest.mark.parametrize(("factors", "parsed"), [(290, 1), (3000, 2)])
def test_deep_trees_are_kept_as_far_as_sheets_have_them(tmp_path, parses, factors, parsed):
    (tmp_path / "long.tk").write_text("y = " + "*".join(["x"] * factors) + "\n")
    for _ in range(2):
        if factors < 300:
            assert load(tmp_path / "long.tk").equations[0].left == Name("y")
        else:
            with pytest.raises(RuleSheetError) as caught:
                load(tmp_path / "long.tk")
            assert codes(caught) == ["E217"]
    assert len(parses) == parsed


def test_what_a_function_in_python_says_is_not_kept(tmp_path, parses):
    (tmp_path / "range.tk").write_text("variables\nx < depth_of(1)\nrules\ny = x\n")
    with patch.dict(TABLE):
        for depth in (2.0, 3.0):
            rulesheets.function("depth_of", lambda t, depth=depth: depth)
            assert load(tmp_path / "range.tk").variables["x"].high == depth


def test_a_kept_model_needs_no_lark_and_no_checks(tmp_path, parses):
    """A command that solves it imports no parser, and no check: what there is to say was kept."""
    sheet = tmp_path / "sheet.tk"
    sheet.write_text("variables\n  F [kN]\n  m = 3 [kg]\n  a = 2 [m/s^2]\nrules\n  F = m*a/1000\n")
    assert load(sheet).unit_warnings == ()
    code = (
        "import sys; from solver.__main__ import main; main(sys.argv[1:]); "
        "print({'lark', 'rulesheets.checks', 'rulesheets.units.check'}.isdisjoint(sys.modules))"
    )
    words = [sys.executable, "-c", code, "solve", str(sheet)]
    out = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert "0.006" in out
    assert out.splitlines()[-1] == "True"
