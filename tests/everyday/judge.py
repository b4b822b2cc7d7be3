"""Judges an answer from the text of a sheet, in fifty digits and apart from the product.

A rule holds at given numbers if its backward error |F| / Σ|∂F/∂v·v| is within the contract's bound:
numbers within a few units of the last place of those reported satisfy it exactly.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import CodeType
from typing import Any

import mpmath

DIGITS = 50
BOUND = 80 * 2.0**-52
STEP = mpmath.mpf(10) ** -18
STEPS, SMALL = 5, 1e-12

Values = Mapping[str, float | str]


def _degrees(function: Any) -> Any:
    return lambda angle: function(angle * mpmath.pi / 180)


def _in_degrees(function: Any) -> Any:
    return lambda *sides: function(*sides) * 180 / mpmath.pi


FUNCTIONS: dict[str, Any] = {
    **{
        name: getattr(mpmath, name)
        for name in ("sqrt", "exp", "ln", "sin", "cos", "tan", "asin", "acos")
    },
    **{
        name: getattr(mpmath, name)
        for name in ("atan", "atan2", "sinh", "cosh", "tanh", "erf", "erfc", "gamma")
    },
    **{name + "d": _degrees(getattr(mpmath, name)) for name in ("sin", "cos", "tan")},
    **{
        name + "d": _in_degrees(getattr(mpmath, name)) for name in ("asin", "acos", "atan", "atan2")
    },
    "log": mpmath.log10,
    "log10": mpmath.log10,
    "abs": abs,
    "min": min,
    "max": max,
    "round": lambda x: mpmath.sign(x) * mpmath.floor(abs(x) + mpmath.mpf(1) / 2),
    "mod": lambda x, y: mpmath.sign(x) * (abs(x) % abs(y)),
    "pi": mpmath.pi,
}


def rules(text: str) -> Iterator[str]:
    """The rules of a sheet that has one of a line; lines before any head are rules."""
    section = "rules"
    for line in text.splitlines():
        line = re.split(r'["]', line)[0].strip()
        if line in ("rules", "variables"):
            section = line
        elif section == "rules" and line:
            yield line


@cache
def _compiled(expression: str) -> CodeType:
    """Code of an expression of the language, every number in it an mpf of its nearest float."""
    text = re.sub(
        r"(?<![\w.])(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", r"mpf(\g<0>)", expression.replace("^", "**")
    )
    return compile(text, expression, "eval")


@cache
def _names(rule: str) -> set[str]:
    words = set(re.findall(r"(?<![\w.'])[^\W\d]\w*", rule))
    return words - FUNCTIONS.keys() - {"if", "then", "else", "and", "or", "not"}


_GLOBALS = {**FUNCTIONS, "mpf": mpmath.mpf}


def _value(expression: str, values: Mapping[str, Any]) -> Any:
    return eval(_compiled(expression.strip()), _GLOBALS, values)


def _exact(values: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: mpmath.mpf(v) if isinstance(v, (float, int)) else v
        for name, v in values.items()
        if not isinstance(v, str)
    }


def _condition(condition: str, values: Values) -> bool:
    text = re.sub(r"(?<![<>=])=(?!=)", "==", condition).replace("<>", "!=")
    return bool(_value(re.sub(r"'(\w+)", r"'\1'", text), values))


def _active(rule: str, values: Values) -> str | None:
    """The equation or requirement that a rule comes to at these values."""
    while match := re.fullmatch(r"if (.*?) then (.*?)(?: else (.*))?", rule):
        condition, then, otherwise = match.groups()
        rule = then if _condition(condition, values) else otherwise or ""
    return rule or None


def holds(rule: str, values: Values, bound: float = BOUND) -> bool:
    """Whether a rule holds at an answer; one whose value is not real does not."""
    active = _active(rule, values)
    if active is None:
        return True
    if re.search(r"[<>]", active):
        return _condition(active, values)
    left, right = active.split("=")
    with mpmath.workdps(DIGITS):
        at = _exact(values)
        try:
            miss = _value(left, at) - _value(right, at)
            return bool(
                abs(miss) <= bound * sum(abs(slope(active, at, name)) for name in _names(active))
            )
        except (ZeroDivisionError, ValueError, TypeError):
            return False


def slope(rule: str, values: Mapping[str, Any], name: str) -> Any:
    """How far the sides of an equation part where a variable grows, by the share that it grows."""
    if name not in _names(rule):
        return mpmath.mpf(0)
    sides, step = rule.split("="), abs(values[name]) * STEP
    above, below = (
        [_value(side, {**values, name: values[name] + h}) for side in sides] for h in (step, -step)
    )
    return (above[0] - above[1] - below[0] + below[1]) / (2 * STEP)


def broken(text: str, values: Values) -> list[str]:
    """Rules of a sheet that an answer breaks; one with a name that has no value is not judged."""
    return [
        rule for rule in rules(text) if _names(rule) <= values.keys() and not holds(rule, values)
    ]


def distance_to_root(text: str, values: Values, unknown: Sequence[str]) -> float:
    """How far Newton's method in fifty digits moves an answer, as a share of a value; 0 if it
    cannot.

    Next to a removable 0/0, rounding makes rules hold where none of their roots is.
    """
    equations = [
        rule for rule in (_active(rule, values) for rule in rules(text)) if rule and "=" in rule
    ]
    moving = [name for name in unknown if isinstance(values.get(name), float) and values[name]]
    at, start = {**values, **_exact(values)}, dict(values)
    with mpmath.workdps(DIGITS):
        try:
            for _ in range(STEPS):
                miss = [
                    _value(left, at) - _value(right, at)
                    for left, right in (e.split("=") for e in equations)
                ]
                slopes = mpmath.matrix(
                    [[slope(rule, at, name) for name in moving] for rule in equations]
                )
                step = mpmath.lu_solve(slopes, -mpmath.matrix(miss))
                at.update(
                    (name, at[name] * (1 + share)) for name, share in zip(moving, step, strict=True)
                )
                if max(map(abs, step), default=0) < SMALL:
                    break  # the next one would square it
        except (ZeroDivisionError, ValueError, TypeError):
            return 0.0
        return float(max((abs(at[name] / start[name] - 1) for name in moving), default=0))
