"""The site: ``sphinx-build -W docs FOLDER``. Pages stay as they are in the repository."""

from __future__ import annotations

import os
import re
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

from solver.editor.lexer import SheetLexer

project = "Backsolve"
author = "the Backsolve contributors"
version = release = version_of("backsolve")

extensions = ["myst_parser"]
myst_heading_anchors = 4
exclude_patterns = ["generate.py"]
suppress_warnings = ["misc.highlighting_failure"]

html_theme = "furo"
html_title = "Backsolve"
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"source_repository": "", "top_of_page_buttons": []}

ROOT = Path(__file__).parent.parent
TEXTS = {"index": ROOT / "README.md", "changelog": ROOT / "CHANGELOG.md"}
"""Pages that begin with a file of the repository."""

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?:)([^)#\s]+)(#[^)]*)?\)")
PAGES = {"README.md": "index.md", "CHANGELOG.md": "changelog.md"}


def placed(app: object, name: str, source: list[str]) -> None:
    """Links lead to pages of the site; other files of the repository are named without a link."""
    folder = ROOT / "docs"
    texts = [source[0]]
    if name in TEXTS:
        folder, texts = ROOT, [TEXTS[name].read_text(encoding="utf-8"), *texts]

    def link(match: re.Match[str]) -> str:
        mark, text, target, anchor = match[1], match[2], match[3], match[4] or ""
        place = os.path.relpath(folder / target, ROOT)
        page = PAGES.get(place, place.removeprefix("docs/") if place.startswith("docs/") else "")
        return f"{mark}[{text}]({page}{anchor})" if page else text

    source[0] = "\n\n".join([LINK.sub(link, text) for text in texts])


def setup(app: Any) -> None:
    app.connect("source-read", placed)
    app.add_lexer("tk", SheetLexer)
