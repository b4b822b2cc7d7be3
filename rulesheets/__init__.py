"""The rule sheet language: text in, equations out.

>>> import rulesheets
>>> model = rulesheets.loads("V = I*R")
>>> list(model.variables)
['V', 'I', 'R']
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rulesheets.algebra import sympy_equations
    from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity
    from rulesheets.loading import load, loads, shipped_models
    from rulesheets.model import Equation, Model, Premise, Value, Variable
    from rulesheets.source import Source, Span

_HOMES = {
    "sympy_equations": "algebra",
    "Diagnosis": "diagnosis",
    "Label": "diagnosis",
    "RuleSheetError": "diagnosis",
    "Severity": "diagnosis",
    "load": "loading",
    "loads": "loading",
    "shipped_models": "loading",
    "Equation": "model",
    "Model": "model",
    "Premise": "model",
    "Value": "model",
    "Variable": "model",
    "Source": "source",
    "Span": "source",
}

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
    "load",
    "loads",
    "shipped_models",
    "sympy_equations",
]


def __getattr__(name: str) -> Any:
    """Import what is asked for, and no more: the parser and sympy cost their time only where used."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    found = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = found
    return found
