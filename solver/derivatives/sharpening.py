"""An answer in many digits, and the slopes of the rules there.

The inputs are exact numbers, so the answer exists to any number of digits, however ill-conditioned its
rounding to floats is. It is reached from the float answer by Newton's method on the square part of the
active rules, block by block.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from rulesheets.evaluate import Undefined, extended_derivatives
from rulesheets.evaluate.digits import context, in_many_digits
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import Expression
from solver.accuracy.digits import ManyDigits, Work
from solver.derivatives.linearization import Linearization, SquareBlock

Extended: TypeAlias = Any
"""A number of mpmath."""

DIGITS = 100
"""Digits that are computed with."""

MAX_WORK = 10**12
FAR, ASTRAY = 1e-2, 1e-6
"""Share of its size, and of the terms that it is made of, by which an unknown may move and still be the
same answer."""


class _Blunt(ArithmeticError):
    """A block could not be sharpened: its rules are singular there."""


@dataclass(frozen=True)
class Sharp:
    """``values`` to many digits (symbols as they are); ``rows[e]`` are ∂(left − right)/∂v there.

    ``blocks`` are those that were sharpened. ``lost`` are the other unknowns: free ones, those of rough
    rules, and all that is computed from lost ones, even with a slope of 0 (``y = x^2`` where x is free
    at 0: what moves without bound times 0 is not 0).
    """

    values: Mapping[str, Any]
    rows: Mapping[int, Mapping[str, Extended]]
    blocks: tuple[SquareBlock, ...]
    lost: frozenset[str]


def sharpened(
    model: Model, linear: Linearization, values: Mapping[str, Value], inputs: Collection[str]
) -> Sharp:
    """The answer near ``values`` for ``inputs`` (names), and the slopes of its active rules there.

    A block with a function that is known in floats only is left as it is.
    """
    exact: dict[str, Any] = {n: v if isinstance(v, str) else number(v) for n, v in values.items()}
    rows: dict[int, Mapping[str, Extended]] = {}
    blocks: list[SquareBlock] = []
    sound = {*linear.unknowns, *linear.parameters}
    read = (name for e in linear.rough for name in model.equations[e].names)
    lost = {*linear.free, *(name for name in read if name not in inputs and name not in sound)}
    for block in linear.blocks:
        equations = [model.equations[e] for e in block.equations]
        try:
            if any(lost.intersection(equation.names) for equation in equations):
                raise _Blunt
            if all(in_many_digits(side) for e in equations for side in (e.left, e.right)):
                _settle(equations, linear.rows, block, exact)
                rows.update((e.index, slopes(e.left, e.right, exact)) for e in equations)
            else:
                rows.update((e.index, _numbers(linear.rows[e.index])) for e in equations)
            blocks.append(block)
        except (Undefined, _Blunt):
            lost.update(block.unknowns)
            exact.update((name, number(v)) for name in block.unknowns if isinstance(v := values[name], float))
    for index in linear.redundant:
        rule = model.equations[index]
        try:
            rows[index] = slopes(rule.left, rule.right, exact)
        except Undefined:
            continue
    return Sharp(exact, rows, tuple(blocks), frozenset(lost))


def _numbers(row: Mapping[str, float]) -> dict[str, Extended]:
    return {name: number(slope) for name, slope in row.items()}


def number(value: float) -> Extended:
    """A float as the exact number that it is."""
    return context(DIGITS).mpf(value)


def slopes(left: Expression, right: Expression, values: Mapping[str, Any]) -> dict[str, Extended]:
    """∂(left − right)/∂v for every variable in them. Raises Undefined."""
    found = extended_derivatives(left, values, DIGITS)[1]
    for name, slope in extended_derivatives(right, values, DIGITS)[1].items():
        found[name] = found[name] - slope if name in found else -slope
    return found


def _settle(
    equations: Sequence[Equation],
    rows: Mapping[int, Mapping[str, float]],
    block: SquareBlock,
    exact: dict[str, Any],
) -> None:
    """The root of a block near its float values. Raises _Blunt if there is none."""
    start = [float(exact[name]) for name in block.unknowns]
    sizes = _sizes([rows[e.index] for e in equations], block, exact)
    root = ManyDigits(equations, block.unknowns, exact, DIGITS, Work(MAX_WORK)).newton(start, sizes)
    if root is None or any(
        abs(v - x) > FAR * abs(x) + ASTRAY * size for v, x, size in zip(root, start, sizes, strict=True)
    ):
        raise _Blunt
    exact.update(zip(block.unknowns, root, strict=True))


def _sizes(rows: Sequence[Mapping[str, float]], block: SquareBlock, values: Mapping[str, Any]) -> list[float]:
    """How large the terms are that an unknown is made of: the largest Σ|∂F/∂v·v| / |∂F/∂u| of its rules."""
    found = dict.fromkeys(block.unknowns, 0.0)
    for row in rows:
        total = sum(abs(slope * float(values[name])) for name, slope in row.items())
        for name in found.keys() & row.keys():
            if row[name]:
                found[name] = max(found[name], total / abs(row[name]))
    return list(found.values())
