"""Conditions: their outcomes, and the cases to assume.

Assuming whole conditions one by one would multiply cases that exclude each other. Instead the sign
of ``left - right`` of one comparison is assumed; it decides every comparison of the same two
expressions, and ``and``, ``or`` and ``not`` follow by three-valued logic (S. C. Kleene,
*Introduction to Metamathematics*, 1952, section 64).

Assumed signs must leave every quantity a value: comparisons of one expression with known numbers
bound it (``income < 1e4`` and ``income >= 4e4``), those of two unknown expressions bound their
difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice, product
from sys import float_info
from typing import TypeAlias

from rulesheets.evaluate import Undefined, holds, value
from rulesheets.model import Model, Values
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    And,
    Comparison,
    Condition,
    Expression,
    Name,
    Not,
    Number,
    Or,
    Symbol,
)


def outcomes(model: Model, values: Values, inputs: Collection[str]) -> dict[int, bool]:
    """The conditions that these values decide; one that has no value there is false."""
    found = {}
    for index, condition in enumerate(model.conditions):
        try:
            found[index] = holds(condition, values, inputs)
        except KeyError:
            continue
        except Undefined:
            found[index] = False
    return found


Pair: TypeAlias = tuple[Expression, Expression]

Sign: TypeAlias = frozenset[int]
"""The possible assumptions on a pair: the signs of left - right. ``AT_MOST`` and ``AT_LEAST`` are
one case, if equality deactivates none of the rules of that side."""

LESS, EQUAL, GREATER = (frozenset({sign}) for sign in (-1, 0, 1))
AT_MOST, AT_LEAST, DIFFERENT = LESS | EQUAL, EQUAL | GREATER, LESS | GREATER
EVERY = LESS | EQUAL | GREATER

OPERATORS = {"<": LESS, "<=": AT_MOST, "=": EQUAL, ">=": AT_LEAST, ">": GREATER, "<>": DIFFERENT}
MEANING = {sign: operator for operator, sign in OPERATORS.items()}
MIRRORED = {"=": "=", "<>": "<>", "<": ">", "<=": ">=", ">": "<", ">=": "<="}

OTHERWISE = {sign: (EVERY - sign,) for sign in MEANING} | {EQUAL: (LESS, GREATER)}
"""The opposite outcome of a comparison."""


def comparisons(condition: Condition) -> Iterator[Comparison]:
    """The comparisons in a condition, left to right."""
    return (atom for atom, _ in _polarities(condition, True))


def assumed_outcome(comparison: Comparison, signs: Mapping[Pair, Sign]) -> bool | None:
    """The outcome of a comparison under the assumed signs; None if they do not decide it."""
    pair = comparison.left, comparison.right
    pair = pair if pair in signs else pair[::-1]
    if (wanted := _signs(comparison, pair)) is None or pair not in signs:
        return None
    return (
        signs[pair] - EQUAL or signs[pair]
    ) <= wanted  # ``AT_LEAST`` has the rules of ``GREATER``


def _signs(atom: Comparison, pair: Pair) -> Sign | None:
    """The signs of a pair for which a comparison of the two is true."""
    if (atom.left, atom.right) == pair:
        return OPERATORS[atom.operator]
    return OPERATORS[MIRRORED[atom.operator]] if (atom.right, atom.left) == pair else None


def outcome(condition: Condition, settle: Callable[[Condition], bool | None]) -> bool | None:
    """Three-valued value of a condition; ``settle`` evaluates its comparisons."""
    match condition:
        case Not(term):
            inner = outcome(term, settle)
            return None if inner is None else not inner
        case And(terms) | Or(terms):  # the first one that decides, if there is one
            told = [outcome(term, settle) for term in terms]
            deciding = isinstance(condition, Or)
            if deciding in told:
                return deciding
            return None if None in told else not deciding
        case _:
            return settle(condition)


def cases_of(
    pair: Pair, conditions: Sequence[Condition], guards: Iterable[tuple[Condition, bool]]
) -> tuple[Sign, ...]:
    """The cases of a pair, the likely ones first; equality last, where it is a case of its own.

    ``guards`` are the premises of the rules, as pairs of a condition and how it must come out.
    """
    if any(isinstance(side, Symbol) for side in pair):
        return (EQUAL, DIFFERENT)
    asked = {_signs(atom, pair) for condition in conditions for atom in comparisons(condition)}
    if asked <= {EQUAL, DIFFERENT, None}:
        return (DIFFERENT, EQUAL)
    needed = {
        wanted if holds else EVERY - wanted
        for condition, true in guards
        for atom, holds in _polarities(condition, true)
        if (wanted := _signs(atom, pair))
    }
    lost_at_the_edge = [sign for sign in needed if not sign >= EQUAL]
    if not any(sign >= GREATER for sign in lost_at_the_edge):
        return (AT_LEAST, LESS)
    if not any(sign >= LESS for sign in lost_at_the_edge):
        return (GREATER, AT_MOST)
    return (GREATER, LESS, EQUAL)


def _polarities(condition: Condition, holds: bool) -> Iterator[tuple[Comparison, bool]]:
    """The comparisons of a condition, each with the outcome that contributes to ``holds``."""
    if isinstance(condition, Comparison):
        yield condition, holds
    elif isinstance(condition, Not):
        yield from _polarities(condition.term, not holds)
    elif isinstance(condition, And | Or):
        for term in condition.terms:
            yield from _polarities(term, holds)


def value_of_equality(pair: Pair) -> tuple[str, float | str] | None:
    """The value that an assumed equality gives a variable: ``branch = 'open``, ``n = 3``."""
    match pair:
        case (Name(name), Symbol(symbol)) | (Symbol(symbol), Name(name)):
            return name, symbol
        case (Name(name), Number(number)) | (Number(number), Name(name)):
            return name, number
        case _:
            return None


def value_said(condition: Condition) -> tuple[str, float | str] | None:
    """The value that a true condition gives a variable: ``branch = 'open``."""
    if isinstance(condition, Comparison) and condition.operator == "=":
        return value_of_equality((condition.left, condition.right))
    return None


MAX_ALTERNATIVES = 256
"""Combinations of the terms of ``and`` and ``or`` that are tried; beyond, nothing is excluded."""

EQUALITY = 17 * float_info.epsilon
"""The tolerance of ``=`` between numbers, relative: 16 ε of the larger."""

Signed: TypeAlias = tuple[Pair, Sign]
Quantity: TypeAlias = tuple[Expression, ...]
Bound: TypeAlias = tuple[float, int]
"""A number, and where the bound is strict 1 for a lower and -1 for an upper one: then bounds
compare."""


def possible(signs: Iterable[Signed], known: Values) -> bool:
    """Whether the assumed signs leave every quantity a value."""
    ranges: dict[Quantity, tuple[Bound, Bound]] = {}
    for found in (_bounds(pair, sign, known) for pair, sign in signs):
        if found is not None:
            quantity, (low, high) = found
            least, most = ranges.get(quantity, (low, high))
            ranges[quantity] = max(low, least), min(high, most)
    return all(low <= high for low, high in ranges.values())


def compatible(premises: Iterable[tuple[Condition, bool]], known: Values) -> bool:
    """Whether conditions can have these outcomes together."""
    choices = list(
        islice(product(*(_alternatives(*premise) for premise in premises)), MAX_ALTERNATIVES + 1)
    )
    if len(choices) > MAX_ALTERNATIVES:
        return True
    return any(possible(chain.from_iterable(choice), known) for choice in choices)


def _alternatives(condition: Condition, holds: bool) -> list[tuple[Signed, ...]]:
    """The alternatives that each lead to an outcome of a condition."""
    match condition:
        case Comparison(operator, left, right):
            sign = OPERATORS[operator]
            return [(((left, right), sign if holds else EVERY - sign),)]
        case Not(term):
            return _alternatives(term, not holds)
        case And(terms) | Or(terms):
            parts = [_alternatives(term, holds) for term in terms]
            if isinstance(condition, Or) is holds:
                return list(chain.from_iterable(parts))
            together = islice(product(*parts), MAX_ALTERNATIVES + 1)
            return [tuple(chain.from_iterable(choice)) for choice in together]
        case _:
            return [()]


def _bounds(pair: Pair, sign: Sign, known: Values) -> tuple[Quantity, tuple[Bound, Bound]] | None:
    """The quantity that a comparison bounds, with its bounds; None if it bounds none."""
    if sign == DIFFERENT:
        return None
    try:
        left, right = (  # None if it depends on an unknown
            value(side, known) if all(name in known for name in nodes.names(side)) else None
            for side in pair
        )
    except Undefined:
        return None
    if right is None and (left is not None or repr(pair[0]) > repr(pair[1])):
        pair, left, right, sign = pair[::-1], right, left, frozenset(-one for one in sign)
    if left is not None:
        return None
    at, slack = (0.0, 1.0) if right is None else (right, EQUALITY * abs(right))
    slack = slack if sign == EQUAL else 0.0
    is_open = int(not sign >= EQUAL)
    low = (-math.inf, 0) if sign >= LESS else (at - slack, is_open)
    high = (math.inf, 0) if sign >= GREATER else (at + slack, -is_open)
    return pair if right is None else pair[:1], (low, high)
