"""Rules of one shape: they differ in names and numbers only, as the rules of a network do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Equation, Model
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    operands,
    rebuilt,
)

Array: TypeAlias = NDArray[np.float64]
Shape: TypeAlias = tuple[Any, ...]

MOST = 10_000
"""Shapes that are kept at a time, so that rules of one shape share it."""
_INTERNED: dict[Shape, Shape] = {}


class Family(NamedTuple):
    """Rules of one shape: their ``places`` (m,) among all rules, the first of them, the ``columns`` (k, m) of
    its names, in order of first appearance, and of theirs among all names, and the ``numbers`` (c, m) that
    stand in them, in the order of the text."""

    places: NDArray[np.intp]
    first: Equation
    columns: NDArray[np.intp]
    numbers: Array


class Alike(NamedTuple):
    """Rules by their shapes, in order of first appearance, and the names that they read."""

    names: tuple[str, ...]
    families: tuple[Family, ...]


def alike(model: Model, equations: Sequence[Equation]) -> Alike:
    """The rules by their shapes (found once for the same rules)."""
    known: dict[tuple[int, ...], Alike] = model.__dict__.setdefault("_alike", {})
    key = tuple([equation.index for equation in equations])
    if key not in known:
        known[key] = _grouped(equations)
    return known[key]


def _grouped(equations: Sequence[Equation]) -> Alike:
    found: dict[Shape, list[tuple[int, list[float]]]] = {}
    for place, equation in enumerate(equations):
        shape, numbers = shape_of(equation)
        found.setdefault(shape, []).append((place, numbers))
    column = {name: place for place, name in enumerate(dict.fromkeys(n for e in equations for n in e.names))}
    grouped = []
    for members in found.values():
        rules = [equations[place] for place, _ in members]
        columns = [[column[name] for name in rule.names] for rule in rules]
        grouped.append(
            Family(
                np.array([place for place, _ in members], dtype=np.intp),
                rules[0],
                np.array(columns, dtype=np.intp).reshape(len(rules), -1).T,
                np.array([numbers for _, numbers in members], dtype=float).reshape(len(rules), -1).T,
            )
        )
    return Alike(tuple(column), tuple(grouped))


def shape_of(equation: Equation) -> tuple[Shape, list[float]]:
    """The operations of both sides with names by their order, and the numbers; exponents belong to both.

    Found once for an equation.
    """
    found: tuple[Shape, list[float]] | None = equation.__dict__.get("_shape")
    if found is None:
        shape, numbers = _shape(equation)
        if len(_INTERNED) >= MOST:
            _INTERNED.clear()
        found = equation.__dict__["_shape"] = _INTERNED.setdefault(shape, shape), numbers
    return found


def _shape(equation: Equation) -> tuple[Shape, list[float]]:
    order = {name: place for place, name in enumerate(equation.names)}
    shape: list[Any] = []
    numbers: list[float] = []
    stack: list[Expression] = [equation.right, equation.left]
    while stack:
        node = stack.pop()
        kind = type(node)
        if isinstance(node, Name):
            shape.append(order[node.name])
            continue
        shape.append(kind)
        if isinstance(node, Number):
            numbers.append(node.value)
        elif isinstance(node, Product | Quotient):
            stack += (node.right, node.left)
        elif isinstance(node, Sum | Call):
            parts = operands(node)
            shape += (len(parts), node.function if isinstance(node, Call) else None)
            stack += parts[::-1]
        elif isinstance(node, Symbol):
            shape.append(node.name)
        else:
            if isinstance(node, Power) and isinstance(node.exponent, Number):
                shape.append(node.exponent.value)
            stack += operands(node)[::-1]
    return tuple(shape), numbers


def template(rule: Equation) -> tuple[Expression, Expression]:
    """Both sides with names told by their order (``#0``) and numbers by theirs (``#.0``), but for exponents,
    which belong to the shape."""
    names, numbers = {name: Name(f"#{k}") for k, name in enumerate(rule.names)}, count()
    return _template(rule.left, names, numbers), _template(rule.right, names, numbers)


def _template(form: Expression, names: dict[str, Name], numbers: Iterator[int]) -> Expression:
    if isinstance(form, Number):
        return Name(f"#.{next(numbers)}")
    if isinstance(form, Name):
        return names[form.name]
    parts = [
        (part, next(numbers))[0]
        if isinstance(form, Power) and part is form.exponent and isinstance(part, Number)
        else _template(part, names, numbers)
        for part in operands(form)
    ]
    return rebuilt(form, tuple(parts))
