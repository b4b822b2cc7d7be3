"""The rule sheet language: text in, equations out.

>>> import rulesheets
>>> model = rulesheets.loads("V = I*R")
>>> list(model.variables)
['V', 'I', 'R']

Names are fetched on first use: help and mistakes in a command need none of them.
"""

from __future__ import annotations

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

__all__ = ["Diagnosis", "Equation", "Label", "Model", "Premise", "RuleSheetError", "Severity", "Source"]
__all__ += ["Span", "Value", "Variable", "function", "in_unit", "load", "loads", "shipped_models"]
__all__ += ["sympy_equations"]

_NAMES = {
    "algebra": "sympy_equations",
    "inputs": "in_unit",
    "diagnosis": "Diagnosis Label RuleSheetError Severity",
    "registered": "function",
    "files": "shipped_models",
    "loading": "load loads",
    "model": "Equation Model Premise Value Variable",
    "syntax": "Source Span",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'rulesheets' has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"rulesheets.{_HOMES[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted(_HOMES)
