"""The functions of the language to any number of digits, by mpmath (the only import of it).

Each precision has a context of its own (in each thread), so nothing here touches mpmath's global one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from threading import get_ident
from typing import Any

import mpmath
from mpmath.libmp import NoConvergence

from rulesheets.functions.digits import Extended
from rulesheets.functions.row import Forms, Function
from rulesheets.functions.table import TABLE

__all__ = ["Extended", "context", "functions"]


def context(digits: int) -> Any:
    """The context that works with ``digits`` decimal digits, one of each thread: mpmath changes the
    precision of a context while it computes."""
    return _context(get_ident(), digits)


@cache
def _context(thread: int, digits: int) -> Any:
    made = mpmath.MPContext()
    made.dps = digits
    return made


def functions(digits: int) -> Mapping[str, Callable[..., Extended]]:
    """A function of mpmath numbers for every row of ``TABLE``.

    Outside its domain, or without a form in many digits, one raises ValueError or ZeroDivisionError.
    """
    return _functions(get_ident(), digits)


@cache
def _functions(thread: int, digits: int) -> Mapping[str, Callable[..., Extended]]:
    return Forms(TABLE, partial(_form, context(digits)))


def _form(mp: Any, row: Function) -> Callable[..., Extended]:
    """The function over the reals: complex and infinite answers are refused."""
    match row.digits:
        case None:
            return partial(_missing, row.name)
        case str() as name:
            function = getattr(mp, name)
        case form:
            function = partial(form, mp)

    def value(*arguments: Extended) -> Extended:
        try:
            result = function(*arguments)
        except NoConvergence as endless:
            raise ValueError("no value within the limits of mpmath") from endless
        if isinstance(result, mp.mpc) or not mp.isfinite(result):
            raise ValueError("no real value")
        return mp.mpf(result)

    return value


def _missing(name: str, *arguments: Extended) -> Extended:
    raise ValueError(f"{name} is known in floats only")
