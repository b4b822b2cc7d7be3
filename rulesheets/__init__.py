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
    from rulesheets.algebra import sympy_equations as sympy_equations
    from rulesheets.diagnosis import Diagnosis as Diagnosis
    from rulesheets.diagnosis import Label as Label
    from rulesheets.diagnosis import RuleSheetError as RuleSheetError
    from rulesheets.diagnosis import Severity as Severity
    from rulesheets.files import shipped_models as shipped_models
    from rulesheets.inputs import in_unit as in_unit
    from rulesheets.loading import load as load
    from rulesheets.loading import loads as loads
    from rulesheets.model import Equation as Equation
    from rulesheets.model import Model as Model
    from rulesheets.model import Premise as Premise
    from rulesheets.model import Value as Value
    from rulesheets.model import Variable as Variable
    from rulesheets.registered import function as function
    from rulesheets.syntax import Source as Source
    from rulesheets.syntax import Span as Span

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


__all__ = [*_HOMES]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'rulesheets' has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"rulesheets.{_HOMES[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted(_HOMES)
