"""Arithmetic with decimals in a rule, done exactly: ``0.1 + 0.2 - 0.3`` is 0, ``0.1*3`` is 0.3.

The float next to 0.1 is another number than 0.1, and what these differ by must not decide whether rules
agree. So numbers that are added, multiplied and divided are taken as the decimals that they are written as,
where one of them is no float, and put in as their result if that prints as a float. All else stays as it is.
"""

from __future__ import annotations

from rulesheets.nodes import Expression, Negative, Number, Product, Quotient, Sum, children, rebuilt

TYPE_CHECKING = False
if TYPE_CHECKING:
    from fractions import Fraction

LARGEST = 2**1000


def with_decimals_done(expression: Expression) -> Expression:
    """The expression with arithmetic between decimals done, also that of the numbers in a longer sum."""
    changed, constant = _visited(expression)
    return _done(expression) if constant else changed


def _visited(expression: Expression) -> tuple[Expression, bool]:
    """The expression with its parts done; or as it is, if it is made of numbers alone, which is told."""
    if isinstance(expression, Number):
        return expression, True
    parts = children(expression)
    if not parts:
        return expression, False
    seen: list[tuple[Expression, bool]] = []
    for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
        seen.append(_visited(part))  # type: ignore[arg-type]
    places = [place for place, (_, constant) in enumerate(seen) if constant]
    if isinstance(expression, Negative | Sum | Product | Quotient):
        if len(places) == len(parts):
            return expression, True
        if isinstance(expression, Sum) and len(places) > 1:
            return _together(expression, [part for part, _ in seen], places), False
    done = [_done(part) if constant else part for part, constant in seen]
    same = all(new is old for new, old in zip(done, parts, strict=True))
    return expression if same else rebuilt(expression, tuple(done)), False


def _together(whole: Sum, terms: list[Expression], places: list[int]) -> Expression:
    """A sum with the terms at these places, which are numbers, added up in the place of the first."""
    total = Sum(tuple(terms[place] for place in places), whole.span)
    number = _done(total)
    if number is total:
        return rebuilt(whole, tuple(terms))
    terms[places[0]] = number
    return rebuilt(whole, tuple(term for place, term in enumerate(terms) if place not in places[1:]))


def _done(constant: Expression) -> Expression:
    """The float that prints as what numbers come to; they themselves where there is none, or no need."""
    if isinstance(constant, Number) or (
        isinstance(constant, Negative) and isinstance(constant.operand, Number)
    ):
        return constant
    rounded: list[float] = []
    exact = _exactly(constant, rounded)
    if exact is None or not rounded or abs(exact) >= LARGEST:
        return constant
    number = exact.numerator / exact.denominator
    return Number(number, constant.span) if _written(number) == exact else constant


def _exactly(constant: Expression, rounded: list[float]) -> Fraction | None:
    """The value of numbers as decimals; those of them that are no floats are put on the list."""
    if isinstance(constant, Number):
        written = _written(constant.value)
        if written != constant.value:
            rounded.append(constant.value)
        return written
    found = []
    for part in children(constant):
        value = _exactly(part, rounded)  # type: ignore[arg-type]
        if value is None:
            return None
        found.append(value)
    match constant:
        case Negative():
            return -found[0]
        case Sum():
            return sum(found[1:], found[0])
        case Product():
            return found[0] * found[1]
        case _:
            return found[0] / found[1] if found[1] else None


def _written(number: float) -> Fraction:
    from fractions import Fraction

    return Fraction(repr(number))
