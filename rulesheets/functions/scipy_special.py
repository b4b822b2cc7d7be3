"""The special functions of scipy by their names there, imported when one is first called.

>>> from rulesheets.functions import scipy_special as special
>>> round(special.erf(1.0), 6)
0.842701
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def __getattr__(name: str) -> Callable[..., Any]:
    if name.startswith("_"):
        raise AttributeError(name)

    def function(*arguments: Any, **options: Any) -> Any:
        from scipy import special

        return getattr(special, name)(*arguments, **options)

    return function
