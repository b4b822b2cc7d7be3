"""The rule sheet language: text in, equations out.

>>> import rulesheets
>>> model = rulesheets.loads("V = I*R")
>>> list(model.variables)
['V', 'I', 'R']

Names are fetched on first use: help and mistakes in a command need none of them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rulesheets.algebra import sympy_equations
    from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity
    from rulesheets.files import shipped_models
    from rulesheets.inputs import in_unit
    from rulesheets.loading import load, loads
    from rulesheets.model import Equation, Model, Premise, Value, Variable
    from rulesheets.registered import function
    from rulesheets.syntax import Source, Span

__all__ = ["Diagnosis", "Equation", "Label", "Model", "Premise", "RuleSheetError", "Severity"]
__all__ += ["Source", "Span", "Value", "Variable", "function", "in_unit", "load", "loads"]
__all__ += ["shipped_models", "sympy_equations"]


def fetched(
    package: str, names: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package, for names by the modules they come from."""
    homes = {name: home for home, listed in names.items() for name in listed.split()}

    def fetch(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        found = sys.modules[package].__dict__[name] = getattr(import_module(homes[name]), name)
        return found

    return fetch, lambda: sorted(homes)


__getattr__, __dir__ = fetched(
    __name__,
    {
        "rulesheets.algebra": "sympy_equations",
        "rulesheets.inputs": "in_unit",
        "rulesheets.diagnosis": "Diagnosis Label RuleSheetError Severity",
        "rulesheets.registered": "function",
        "rulesheets.files": "shipped_models",
        "rulesheets.loading": "load loads",
        "rulesheets.model": "Equation Model Premise Value Variable",
        "rulesheets.syntax": "Source Span",
    },
)
