"""What ``import solver`` offers, and that it costs nothing until it is used."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import solver

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.parametrize("name", solver.__all__)
def test_every_name_leads_to_what_it_says(name: str) -> None:
    assert getattr(solver, name).__name__ == name
    assert name in dir(solver)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'solver' has no attribute 'solv'"):
        _ = solver.solv


def test_importing_both_packages_imports_nothing_heavy() -> None:
    heavy = ("numpy", "scipy", "sympy", "lark", "mpmath")
    code = f"import sys, solver, rulesheets; print({{*{heavy!r}}} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
