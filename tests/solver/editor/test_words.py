"""The words of a sheet, and what is made of them: Pygments tokens and the TextMate grammar."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import solver
from rulesheets.functions import TABLE
from rulesheets.parse.sections import head_word
from solver.editor import HEADS, RESERVED, Names, Symbol, words

ROOT = Path(__file__).parents[3]
SHEETS = sorted((ROOT / "models").rglob("*.tk"))
VSCODE = ROOT / "solver" / "editor" / "vscode"

SCOPES = {
    "comment.line": "comment",
    "support.function": "builtin",
    "keyword.control": "keyword",
    "keyword.operator.word": "keyword",
    "keyword.control.section": "head",
    "keyword.control.use": "head",
    "storage.type.unit": "unit",
    "constant.other.symbol": "symbol",
    "support.type.mark": "mark",
    "entity.name.function": "function",
    "constant.numeric": "number",
    "string.quoted.double": "path",
    "constant.language": "constant",
}


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda path: "/".join(path.parts[-2:]))
def test_every_word_of_a_shipped_sheet_has_a_kind(sheet: Path) -> None:
    text = sheet.read_text(encoding="utf-8")
    found = words(text)
    assert [word.text for word in found] == [text[word.start : word.end] for word in found]
    assert not [word for word in found if word.kind == "error"]
    covered = "".join(word.text for word in found)
    assert re.sub(r"\s", "", covered) == re.sub(r"\s", "", text)


def test_a_text_that_is_no_sheet_has_words_too() -> None:
    kinds = [
        (word.kind, word.text) for word in words('variables\n x = ) $ "a (\nfunction f(x; y\n')
    ]
    assert (
        ("error", "$") in kinds and ("comment", '"a (') in kinds and ("head", "function") in kinds
    )


def test_a_name_in_a_function_is_another_than_on_the_sheet() -> None:
    names = Names("x = p\nfunction f(x; y)\nparameters p\ny = p*x\n")
    places = {named: len(found) for named, found in names.places.items()}
    assert places[Symbol("x", "")] == 1 and places[Symbol("x", "f")] == 2
    assert places[Symbol("p", "")] == 3


def test_a_point_of_a_figure_is_no_variable() -> None:
    names = Names("A = 2\nfigure f\n  point A = (A, 0)\n  point O = (0, 0)\n  slider (A, A)\n")
    places = {named: [word.start for word in found] for named, found in names.places.items()}
    assert len(places[Symbol("A", "")]) == 3 and len(places[Symbol("A", "f:")]) == 2


def test_given_names_a_variable() -> None:
    assert len(Names("x = 1\nif given('x) then y = 1 else y = 2").places[Symbol("x", "")]) == 2


def test_the_words_are_those_of_the_language() -> None:
    assert all(
        head_word(f"{head} f(x)" if head == "function" else f"{head} x") or head_word(head)
        for head in HEADS
    )
    grammar = (ROOT / "rulesheets" / "rules.lark").read_text(encoding="utf-8")
    (reserved,) = re.findall(r"NAME: /\(\?!\(\?:([a-z|]+)\)", grammar)
    assert set(reserved.split("|")) == set(RESERVED)


def test_every_function_is_explained() -> None:
    assert all(row.meaning and row.example for row in TABLE.values())


@pytest.mark.parametrize("name", list(TABLE))
def test_the_example_of_a_function_holds(name: str) -> None:
    left, right = TABLE[name].example.split(" = ")
    result = solver.solve(solver.loads(f"a = {left}\nb = {right}"))
    assert result["a"] == pytest.approx(result["b"], rel=4e-16, abs=1e-300)


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda path: "/".join(path.parts[-2:]))
def test_pygments_loses_nothing(sheet: Path) -> None:
    pygments = pytest.importorskip("pygments")
    from solver.editor.lexer import SheetLexer

    text = sheet.read_text(encoding="utf-8")
    tokens = list(pygments.lex(text, SheetLexer()))
    assert "".join(said for _, said in tokens).strip() == text.strip()
    assert not [said for kind, said in tokens if str(kind).startswith("Token.Error")]


def test_textmate_tells_words_alike() -> None:
    """With ``npm ci`` in the folder of the extension; the CI does so."""
    if not shutil.which("node") or not (VSCODE / "node_modules").is_dir():
        pytest.skip("needs node and the packages of the extension")
    command = ["node", str(Path(__file__).parent / "tokens.cjs"), str(VSCODE), *map(str, SHEETS)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    kinds = set(SCOPES.values())
    for sheet, lines in zip(SHEETS, json.loads(done.stdout), strict=True):
        theirs = [
            (SCOPES[scope.removesuffix(".tk")], said.strip())
            for line in lines
            for scope, said in line
            if scope.removesuffix(".tk") in SCOPES and said.strip()
        ]
        ours = [
            (w.kind, w.text) for w in words(sheet.read_text(encoding="utf-8")) if w.kind in kinds
        ]
        assert theirs == ours, sheet


def test_the_extension_starts_a_server_that_checks_and_ends(tmp_path: Path) -> None:
    """As VS Code runs it, but for VS Code: the protocol library of its client drives the server."""
    if not shutil.which("node") or not (VSCODE / "node_modules").is_dir():
        pytest.skip("needs node and the packages of the extension")
    pytest.importorskip("pygls")
    command = tmp_path / "backsolve"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m solver "$@"\n')
    command.chmod(0o755)
    script = Path(__file__).parent / "extension.cjs"
    words = ["node", str(script), str(VSCODE), str(command)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 0 and done.stderr == ""
    told = json.loads(done.stdout)
    assert told["codes"] == ["E104"] and told["ended"] == 0
    assert {"hoverProvider", "completionProvider", "renameProvider"} <= {*told["capabilities"]}


def test_the_extension_tells_words_as_the_language_does() -> None:
    configuration = json.loads((VSCODE / "language-configuration.json").read_text(encoding="utf-8"))
    assert configuration["comments"] == {"lineComment": '"'}
    assert not [pair for pair in configuration["autoClosingPairs"] if pair[0] in "\"'"]
    package = json.loads((VSCODE / "package.json").read_text(encoding="utf-8"))
    (language,), (grammar,) = (
        package["contributes"]["languages"],
        package["contributes"]["grammars"],
    )
    assert language["extensions"] == [".tk"] and grammar["language"] == language["id"]
    assert (VSCODE / language["configuration"]).is_file() and (VSCODE / grammar["path"]).is_file()
