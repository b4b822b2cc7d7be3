"""Where enclosures in floats overflow: the residual of a chain beyond 1e±100, by its signs in many digits.

A search gives up boxes that nobody asks about. Whoever calls its answers all has to look at them: at single
points enclosures mostly tell the sign, and numbers of many digits, which have exponents of any size, where
they don't. A change of sign tells of a root in there, or of a pole.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import isnan
from typing import TYPE_CHECKING, Any

from rulesheets.evaluate import Undefined
from rulesheets.model import Value
from rulesheets.syntax.nodes import Call, Number, Power, Sum
from rulesheets.syntax.program import walk
from solver.kernel.code.chain import Chain

if TYPE_CHECKING:
    from solver.numerics.interval_function import Enclosure, Interval

DIGITS = 350
"""So many show 1e-300 beside 1; special functions are too dear for that."""
SPARE = 8
STRIDE = 25.0
"""Decades between two points."""
HALVINGS = 64
MILD = 0.4
"""Exponents below which a power of 1e100 may be taken for a number of ordinary size."""
_LOGARITHMIC = frozenset({"ln", "log", "log10", "asinh", "acosh", "lgamma", "y0", "k0"})


def changes_of_sign(
    chain: Chain, known: Mapping[str, Value], boxes: Sequence[Interval], enclose: Enclosure
) -> list[float]:
    """Next to where the residual changes its sign on ``boxes`` (low, high) of the tear that do not hold 0.

    ``enclose`` takes boxes to enclosures of the residual.
    """
    if not any(_compresses(part) for item in chain.assignments for part in walk(item.expression)):
        return []
    residual = _Residual(chain, known, enclose)
    found = []
    for low, high in _runs(boxes):
        signs = [(x, sign) for x in _points(low, high) if (sign := residual.sign(x))]
        for (one, sign), (other, last) in pairwise(signs):
            if sign != last:
                found.append(residual.between(one, other, sign))
    return found


def _compresses(part: object) -> bool:
    """Whether an operation may make a number of ordinary size of one beyond 1e±100, as logarithms do. Without
    any, and with no number of such a size in the rules, no roots are out there."""
    match part:
        case Call(function):
            return function in _LOGARITHMIC
        case Power(_, Number(exponent)):
            return abs(exponent) < MILD
        case Power():
            return True
    return False


def _runs(boxes: Sequence[Interval]) -> list[Interval]:
    """Boxes side by side taken together."""
    runs: list[Interval] = []
    for low, high in sorted(boxes):
        if runs and runs[-1][1] == low:
            runs[-1] = runs[-1][0], high
        else:
            runs.append((low, high))
    return runs


def _points(low: float, high: float) -> Iterator[float]:
    """The ends, and powers of ten between them, in their order."""
    sign = math.copysign(1.0, low + high)
    small, large = sorted((abs(low), abs(high)))
    first, last = (math.log10(size or 5e-324) for size in (small, large))
    count = max(1, math.ceil((last - first) / STRIDE))
    inside = [10.0 ** (first + k * (last - first) / count) for k in range(1, count)]
    sizes = [small or 5e-324, *inside, large]
    yield from (sign * size for size in (sizes if sign > 0 else reversed(sizes)))


class _Residual:
    def __init__(self, chain: Chain, known: Mapping[str, Value], enclose: Enclosure) -> None:
        self.chain, self.known, self.enclose = chain, known, enclose

    def sign(self, x: float) -> int:
        """0 where it is not known, or there is no value."""
        ((low, high),) = self.enclose([(x, x)])
        if isnan(low) and isnan(high):
            return 0
        return 1 if low > 0.0 else -1 if high < 0.0 else self.exact_sign(x)

    def exact_sign(self, x: Any) -> int:
        """The same of a number of many digits."""
        from rulesheets.evaluate import extended  # rarely needed, and dear to import

        values: dict[str, Any] = {**self.known, self.chain.tears[0]: x}
        try:
            for item in self.chain.assignments:
                values[item.name] = number = extended(item.expression, values, DIGITS)
                if not item.low <= number <= item.high:
                    return 0
            last = self.chain.assignments[-1].expression
            terms = last.terms if isinstance(last, Sum) else (last,)
            size = sum(abs(extended(term, values, DIGITS)) for term in terms)
        except (Undefined, OverflowError):
            return 0
        mp = self._context
        return int(mp.sign(number)) if abs(number) > size * mp.mpf(10) ** (SPARE - DIGITS) else 0

    def between(self, low: float, high: float, sign: int) -> float:
        """The float next to where the residual, of that sign at ``low``, changes it."""
        mp = self._context
        one, other = mp.mpf(low), mp.mpf(high)
        for _ in range(HALVINGS):
            far = abs(one / other) > 4 or abs(other / one) > 4
            middle = mp.sign(one) * mp.sqrt(one * other) if far else (one + other) / 2
            there = self.exact_sign(middle)
            if not there:
                break
            one, other = (middle, other) if there == sign else (one, middle)
        return float(one)

    @property
    def _context(self) -> Any:
        from rulesheets.evaluate.digits import context

        return context(DIGITS)
