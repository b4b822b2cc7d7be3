"""Which assumptions about conditions can hold at once: the sign of a difference decides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rulesheets.nodes import And, Comparison, Condition, Expression, Not, Or

_SIGNS = {"=": {0}, "<>": {-1, 1}, "<": {-1}, "<=": {-1, 0}, ">": {1}, ">=": {0, 1}}
_OPPOSITE = {"=": "<>", "<>": "=", "<": ">=", "<=": ">", ">": "<=", ">=": "<"}
_SWAPPED = {"=": "=", "<>": "<>", "<": ">", "<=": ">=", ">": "<", ">=": "<="}


def compatible(conditions: Sequence[Condition], assumed: Mapping[int, bool]) -> bool:
    """Whether the assumed outcomes leave room.

    False where two comparisons of the same expressions exclude each other, and where they meet in
    nothing but equality without any of them asking for it (``a >= b`` and ``a <= b``): the neighbouring
    case, in which one of the two is not assumed, covers that.
    """
    signs: dict[tuple[Expression, Expression], set[int]] = {}
    equal: set[tuple[Expression, Expression]] = set()
    for index, outcome in assumed.items():
        for operator, left, right in _comparisons(conditions[index], outcome):
            key = (left, right)
            if (right, left) in signs:
                key, operator = (right, left), _SWAPPED[operator]
            signs[key] = signs.get(key, {-1, 0, 1}) & _SIGNS[operator]
            if operator == "=":
                equal.add(key)
    return all(left and (left != {0} or key in equal) for key, left in signs.items())


def _comparisons(condition: Condition, outcome: bool) -> Iterator[tuple[str, Expression, Expression]]:
    """Comparisons that all hold if the condition comes out so; of an alternative, none."""
    match condition:
        case Comparison(operator, left, right):
            yield (operator if outcome else _OPPOSITE[operator]), left, right
        case Not(term):
            yield from _comparisons(term, not outcome)
        case And(terms) if outcome:
            for term in terms:
                yield from _comparisons(term, True)
        case Or(terms) if not outcome:
            for term in terms:
                yield from _comparisons(term, False)
        case _:
            return
