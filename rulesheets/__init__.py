"""The rule sheet language: text in, equations out.

>>> import rulesheets
>>> model = rulesheets.loads("V = I*R")
>>> list(model.variables)
['V', 'I', 'R']
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity
from rulesheets.functions.registered import function
from rulesheets.loading import load, loads, shipped_models
from rulesheets.model import Equation, Model, Premise, Value, Variable
from rulesheets.syntax.source import Source, Span
from rulesheets.units.display import in_unit

if TYPE_CHECKING:
    from rulesheets.algebra import sympy_equations

__all__ = [
    "Diagnosis",
    "Equation",
    "Label",
    "Model",
    "Premise",
    "RuleSheetError",
    "Severity",
    "Source",
    "Span",
    "Value",
    "Variable",
    "function",
    "in_unit",
    "load",
    "loads",
    "shipped_models",
    "sympy_equations",
]


def __getattr__(name: str) -> Any:
    """sympy costs its time only where it is asked for."""
    if name != "sympy_equations":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module("rulesheets.algebra").sympy_equations
