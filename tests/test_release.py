"""What is said of the release agrees with itself: version, citation, changelog, licence."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION = PROJECT["version"]


def test_the_citation_names_this_version() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert (
        f"\nversion: {VERSION}\n" in citation and f"\nlicense: {PROJECT['license']}\n" in citation
    )


def test_the_extension_for_vs_code_has_this_version() -> None:
    package = (ROOT / "solver/editor/vscode/package.json").read_text(encoding="utf-8")
    assert f'"version": "{VERSION}"' in package


def test_the_changelog_keeps_its_form() -> None:
    """Releases under ``## [x.y.z] - date`` or Unreleased; in them only the kinds of change of the
    format."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    heads = re.findall(r"^## (.+)$", text, re.MULTILINE)
    assert heads[0] == "Unreleased"
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ - \d{4}-\d\d-\d\d", head) for head in heads[1:])
    kinds = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
    assert set(re.findall(r"^### (.+)$", text, re.MULTILINE)) <= kinds


def test_everything_extra_is_in_the_test_extra() -> None:
    """Except what is for the site, a cluster or a browser, which CI installs on its own."""
    extras = set(PROJECT["optional-dependencies"]) - {"test", "dev", "docs", "browser", "dask"}
    (ours,) = [
        one for one in PROJECT["optional-dependencies"]["test"] if one.startswith("backsolve[")
    ]
    assert set(ours.removeprefix("backsolve[").removesuffix("]").split(",")) == extras
