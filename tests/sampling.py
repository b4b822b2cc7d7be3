"""Samples of cases for `pytest.mark.parametrize`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def sampled(cases: Sequence[Any], every: int, start: int = 0) -> list[Any]:
    """The cases, of which only every so many-th one runs without ``-m slow``."""
    return [
        case
        if place % every == start
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)
        for place, case in enumerate(cases)
    ]
