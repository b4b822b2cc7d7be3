"""The words of a sheet as a TextMate grammar; ``python -m tests.solver.editor.grammar`` writes the
file."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rulesheets.functions import TABLE
from solver.editor import HEADS, MARKS, RESERVED

ROOT = Path(__file__).parent.parent.parent.parent
FILE = ROOT / "solver" / "editor" / "vscode" / "syntaxes" / "tk.tmLanguage.json"


def _any(words: Iterable[str]) -> str:
    return rf"(?i:{'|'.join(sorted(words, key=lambda word: (-len(word), word)))})"


def _is(scope: str, match: str) -> dict[str, str]:
    return {"name": f"{scope}.tk", "match": match}


def grammar() -> dict[str, Any]:
    """The grammar as JSON has it; its lists of words are those of the language."""
    return {
        "name": "Rule sheet",
        "scopeName": "source.tk",
        "fileTypes": ["tk"],
        "patterns": [{"include": "#use"}, {"include": "#code"}],
        "repository": {
            "use": {
                "begin": r"^\s*(?i:(use))\b(?=\s*\")",
                "end": "$",
                "beginCaptures": {"1": {"name": "keyword.control.use.tk"}},
                "patterns": [
                    _is("string.quoted.double", r'(?:\G|(?<=,))\s*"[^"\n]*"'),
                    _is("comment.line", r'[";][^\n]*$'),
                ],
            },
            "code": {
                "patterns": [
                    _is("comment.line", r'"[^\n]*$'),
                    {"include": "#parentheses"},
                    _is("comment.line", r";[^\n]*$"),
                    {"include": "#words"},
                ]
            },
            "parentheses": {
                "begin": r"\(",
                "end": r"\)",
                "patterns": [
                    _is("comment.line", r'"[^\n]*$'),
                    {"include": "#parentheses"},
                    {"include": "#words"},
                ],
            },
            "words": {
                "patterns": [
                    _is(
                        "keyword.control.section", rf"^\s*{_any(HEADS)}\b(?=\s*(?:$|[\";]|[^\W\d]))"
                    ),
                    _is("keyword.control", rf"\b{_any(RESERVED)}\b"),
                    _is("keyword.operator.word", r"\b(?i:given)(?=\s*\()|\b(?i:in)(?=\s*\[)"),
                    _is(
                        "support.type.mark", rf"^\s*{_any(MARKS)}\b(?=\s*(?:\(|[^\W\d]\w*\s*[=(]))"
                    ),
                    _is("support.function", rf"\b{_any(TABLE)}(?=\s*\()"),
                    _is("entity.name.function", r"\b[^\W\d]\w*(?=\s*\()"),
                    _is("variable.other", r"(?:[^\W\d]\w*(?:#\d+)?\.)+[^\W\d]\w*"),
                    _is("constant.language", r"\bpi\b"),
                    _is("constant.other.symbol", r"'[^\W\d]\w*"),
                    _is("constant.numeric", r"\b(?:\d+\.?\d*|\.\d+)(?i:e[+-]?\d+)?"),
                    _is("storage.type.unit", r"\[[^\[\],\n]*\]"),
                    _is("keyword.operator", r"<>|<=|>=|±|\+/?-|[-+*/^=<>≤≥≠~%]"),
                    _is("variable.other", r"[^\W\d]\w*"),
                ]
            },
        },
    }


def written() -> str:
    """The text of the file."""
    return json.dumps(grammar(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    FILE.write_text(written(), encoding="utf-8")
