"""The functions of the language in sympy: as mathematics, and as names to be printed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import sympy

from rulesheets.functions import TABLE, Function
from rulesheets.functions.row import Forms

Form: TypeAlias = Callable[..., Any]


def _form(row: Function) -> Form:
    match row.sympy:
        case None:
            return _named(row)
        case str() as name:
            form: Form = getattr(sympy, name)
            return form
        case form:
            return partial(form, sympy)


def _named(row: Function) -> Form:
    return lambda *arguments: sympy.Function(row.name)(*arguments)


def _printed(row: Function) -> Form:
    match row.name:
        case "pi":
            return lambda: sympy.pi
        case "sqrt":
            return lambda x: sympy.sqrt(x, evaluate=False)
        case "abs":
            return lambda x: sympy.Abs(x, evaluate=False)
        case _:
            return _named(row)


MATHEMATICS = Forms(TABLE, _form)
"""Every function as sympy has it; angles of the degree functions in degrees."""
PRINTED = Forms(TABLE, _printed)
"""The same by their names in the language, so that a printed rule reads like the sheet."""
