"""Cases of conditions that wait on unknowns: the sign of one difference at a time.

To assume whole conditions one by one would multiply cases that exclude each other. Instead the sign
of ``left - right`` of one comparison is assumed; it settles every comparison of the same two
expressions, and ``and``, ``or`` and ``not`` follow by three-valued logic (S. C. Kleene, *Introduction to
Metamathematics*, 1952, section 64).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rulesheets import nodes
from rulesheets.nodes import And, Comparison, Condition, Expression, Name, Not, Number, Or, Symbol

if TYPE_CHECKING:
    from typing import TypeAlias

Pair: TypeAlias = tuple[Expression, Expression]

LESS, EQUAL, GREATER, DIFFERENT = -1, 0, 1, 2
"""What can be assumed of a pair; ``DIFFERENT`` serves pairs that are only asked whether they are equal."""

AT_MOST, AT_LEAST = -3, 3
"""Less or equal, and greater or equal: one case, where equality takes none of the rules of that side away."""

_TRUE_FOR = {
    "=": {EQUAL},
    "<>": {LESS, AT_MOST, GREATER, AT_LEAST, DIFFERENT},
    "<": {LESS, AT_MOST},
    "<=": {LESS, AT_MOST, EQUAL},
    ">": {GREATER, AT_LEAST},
    ">=": {GREATER, AT_LEAST, EQUAL},
}
"""By operator: for which assumptions its rules take part. (``AT_LEAST`` has the rules of ``GREATER``.)"""

MEANING = {LESS: "<", AT_MOST: "<=", EQUAL: "=", AT_LEAST: ">=", GREATER: ">", DIFFERENT: "<>"}
_MIRRORED = {"=": "=", "<>": "<>", "<": ">", "<=": ">=", ">": "<", ">=": "<="}


def comparisons(condition: Condition) -> Iterator[Comparison]:
    """The comparisons that a condition is made of, left to right."""
    if isinstance(condition, Comparison):
        yield condition
    elif isinstance(condition, And | Or | Not):
        for part in nodes.children(condition):
            yield from comparisons(part)  # type: ignore[arg-type]


def assumed_outcome(comparison: Comparison, signs: Mapping[Pair, int]) -> bool | None:
    """How a comparison comes out under the assumed signs; None where they don't tell."""
    left, right, operator = comparison.left, comparison.right, comparison.operator
    sign = signs.get((left, right))
    if sign is None:
        sign, operator = signs.get((right, left)), _MIRRORED[operator]
    return None if sign is None else sign in _TRUE_FOR[operator]


def outcome(condition: Condition, settle: Callable[[Condition], bool | None]) -> bool | None:
    """Three-valued value of a condition; ``settle`` answers for its comparisons."""
    match condition:
        case Not(term):
            inner = outcome(term, settle)
            return None if inner is None else not inner
        case And(terms):
            return _all([outcome(term, settle) for term in terms], wanted=True)
        case Or(terms):
            return _all([outcome(term, settle) for term in terms], wanted=False)
        case _:
            return settle(condition)


def _all(outcomes: list[bool | None], wanted: bool) -> bool | None:
    """``wanted`` if all are; its opposite if one is that; else unknown."""
    if any(found is not None and found is not wanted for found in outcomes):
        return not wanted
    return None if None in outcomes else wanted


def cases_of(pair: Pair, conditions: Sequence[Condition], guards: Iterable[Guard]) -> tuple[int, ...]:
    """The cases of a pair, the likely ones first; equality last, where it is a case of its own.

    ``guards`` are the premises of the rules, as pairs of a condition and how it must come out.
    """
    if any(isinstance(side, Symbol) for side in pair):
        return (EQUAL, DIFFERENT)
    asked = {_asked(atom, pair) for condition in conditions for atom in comparisons(condition)} - {None}
    if asked <= {"=", "<>"}:
        return (DIFFERENT, EQUAL)
    uses = {
        (operator, wanted)
        for condition, holds in guards
        for atom, wanted in _polarities(condition, holds)
        if (operator := _asked(atom, pair))
    }
    if not uses & _LOST_AT_THE_EDGE[GREATER]:
        return (AT_LEAST, LESS)
    if not uses & _LOST_AT_THE_EDGE[LESS]:
        return (GREATER, AT_MOST)
    return (GREATER, LESS, EQUAL)


Guard: TypeAlias = tuple[Condition, bool]

_LOST_AT_THE_EDGE = {
    GREATER: {(">", True), ("<>", True), ("<=", False), ("=", False)},
    LESS: {("<", True), ("<>", True), (">=", False), ("=", False)},
}
"""By side: what a guard may ask (operator, outcome) that holds on that side and ceases to at equality."""


def _asked(atom: Comparison, pair: Pair) -> str | None:
    """The operator that an atom puts between the two, read from the first to the second."""
    if (atom.left, atom.right) == pair:
        return atom.operator
    return _MIRRORED[atom.operator] if (atom.right, atom.left) == pair else None


def _polarities(condition: Condition, holds: bool) -> Iterator[tuple[Comparison, bool]]:
    """The comparisons of a condition, each with the outcome that makes for ``holds``."""
    if isinstance(condition, Comparison):
        yield condition, holds
    elif isinstance(condition, Not):
        yield from _polarities(condition.term, not holds)
    elif isinstance(condition, And | Or):
        for term in condition.terms:
            yield from _polarities(term, holds)


def value_of_equality(pair: Pair) -> tuple[str, float | str] | None:
    """What an assumed equality says of a variable: ``branch = 'open``, ``n = 3``."""
    match pair:
        case (Name(name), Symbol(symbol)) | (Symbol(symbol), Name(name)):
            return name, symbol
        case (Name(name), Number(number)) | (Number(number), Name(name)):
            return name, number
        case _:
            return None
