"""Newton's method in fifty digits on rules as they are written, by mpmath alone.

It shares no code with the solver: the rules are read by ``expressions.py``, and slopes are
differences. Steps are computed in three times as many digits, so that an unknown of 1e-50 beside
others has its slope.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import mpmath

from benchmarks.expressions import DIGITS, Undefined, evaluated

MOST = 60
SETTLED, STILL = mpmath.mpf(10) ** -30, mpmath.mpf(10) ** -40
HALVINGS = 40


def newton(
    rules: Sequence[str], start: Mapping[str, Any], unknowns: Sequence[str]
) -> dict[str, Any] | None:
    """The root that Newton's method reaches, halving steps that leave a domain; None if there is
    none."""
    at = {name: mpmath.mpf(value) for name, value in start.items()}
    try:
        with mpmath.workdps(3 * DIGITS):
            for _ in range(MOST):
                misses, rows = linearized(rules, at, unknowns)
                step = _solve(rows, misses)
                at = _stepped(rules, at, dict(zip(unknowns, step, strict=True)))
                moved = max(abs(d / at[n]) if d else 0 for n, d in zip(unknowns, step, strict=True))
                if moved <= STILL or (moved <= SETTLED and _holds(rules, at)):
                    return at
    except (Undefined, ZeroDivisionError, TypeError):  # mpmath swaps no row of a singular matrix
        return None
    return None


def condition(rules: Sequence[str], at: Mapping[str, Any], unknowns: Sequence[str]) -> float:
    """The largest relative change of an unknown for a relative change of the terms of one rule."""
    with mpmath.workdps(3 * DIGITS):
        try:
            _, rows = linearized(rules, at, unknowns)
            sizes = [
                sum(abs(a * at[n]) for a, n in zip(row, unknowns, strict=True)) for row in rows
            ]
            inverse = mpmath.matrix(rows) ** -1
            return max(
                float(abs(inverse[i, k]) * sizes[k] / abs(at[name]))
                for i, name in enumerate(unknowns)
                for k in range(len(rules))
            )
        except (
            Undefined,
            ZeroDivisionError,
            TypeError,
        ):  # mpmath swaps no row of a singular matrix
            return float("inf")


def linearized(
    rules: Sequence[str], at: Mapping[str, Any], unknowns: Sequence[str]
) -> tuple[list[Any], list[list[Any]]]:
    """What the rules miss by, and the slopes of that along the unknowns. Raises Undefined."""
    misses = [_miss(rule, at) for rule in rules]
    share = mpmath.mpf(10) ** (-DIGITS // 2)
    rows = []
    for rule, miss in zip(rules, misses, strict=True):
        steps = [(abs(at[n]) or mpmath.mpf(1)) * share for n in unknowns]
        read = set(re.findall(r"\w+", rule))
        rows.append(
            [
                (_miss(rule, {**at, n: at[n] + step}) - miss) / step if n in read else mpmath.mpf(0)
                for n, step in zip(unknowns, steps, strict=True)
            ]
        )
    return misses, rows


def _miss(rule: str, at: Mapping[str, Any]) -> Any:
    left, right = rule.split(" = ")
    return evaluated(left, at) - evaluated(right, at)


def _holds(rules: Sequence[str], at: Mapping[str, Any]) -> bool:
    return all(
        abs(evaluated(left, at) - evaluated(right, at))
        <= 1e-25 * (abs(evaluated(left, at)) + 1e-30)
        for left, right in (rule.split(" = ") for rule in rules)
    )


def _solve(rows: list[list[Any]], misses: list[Any]) -> list[Any]:
    return list(mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix(misses)))


def _stepped(
    rules: Sequence[str], at: Mapping[str, Any], step: Mapping[str, Any]
) -> dict[str, Any]:
    for halving in range(HALVINGS):
        ahead = {**at, **{name: at[name] - d / 2**halving for name, d in step.items()}}
        try:
            for rule in rules:
                _miss(rule, ahead)
        except Undefined:
            continue
        return ahead
    raise Undefined("step")
