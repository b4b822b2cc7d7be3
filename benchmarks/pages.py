"""Tables in Markdown, and the places in pages that a benchmark writes them to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parent.parent


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with its columns in line; all but the first are flush right."""
    table = [list(map(str, row)) for row in (head, *rows)]
    widths = [max(len(row[k]) for row in table) for k in range(len(head))]
    lines = [
        " | ".join(
            [
                row[0].ljust(widths[0]),
                *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)),
            ]
        )
        for row in table
    ]
    rule = " | ".join(["-" * widths[0], *("-" * (w - 1) + ":" for w in widths[1:])])
    return "\n".join(f"| {line} |" for line in (lines[0], rule, *lines[1:]))


def place(path: Path, mark: str, text: str) -> bool:
    """Put text between ``<!-- MARK -->`` and ``<!-- end -->``; False where there is no such
    place."""
    before = path.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- {re.escape(mark)} -->\n).*?(<!-- end -->)", re.DOTALL)
    after, count = pattern.subn(lambda match: f"{match[1]}\n{text}\n\n{match[2]}", before)
    if count:
        path.write_text(after, encoding="utf-8")
    return bool(count)
