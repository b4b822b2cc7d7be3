"""Is what is computed along a swept variable one curve between two rows, or does it jump, or have a pole?

Where nothing can have several values there is no curve to follow, only rows that are solved one by one.
Between two of them the interval is halved, ever where the values change most: along a curve the change
vanishes with the interval, at a jump or a pole it does not. Where a value is larger than at both ends, the
interval is halved where it is largest: at a pole of even order it grows without bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from rulesheets.model import Value

Answer = Callable[[float], "Mapping[str, Value] | None"]
"""The values at a place of the swept variable; None where there is no answer."""

STEEP = 0.8
"""Share of a change that one half of an interval takes, and not the other, where it is looked at closely."""
VANISHED = 1e-3
"""Share of its largest change by which a continuous value still changes at the end."""
ROUNDING = 2.0**-49
"""Share of a value by which it changes for no other reason than its digits."""
HALVINGS = 80
GROWN = 1e9
"""How many times larger than at the rows a value is next to a pole."""
LAST = 10
STILL_GROWN = 4.0
"""How many times larger it is there than so many halvings before."""


def parted(
    start: float, end: float, answer: Answer, names: Sequence[str], turn: Callable[[str], float | None]
) -> bool:
    """Whether some of the named values jumps, has a pole, or is missing between two places with answers.

    ``turn``: the whole turn of a name that is an angle, which makes no difference.
    """
    first, last, middle = answer(start), answer(end), answer(0.5 * (start + end))
    if first is None or last is None:
        return False
    if middle is None:
        return True
    for name in names:
        ends = first.get(name), middle.get(name), last.get(name)
        numbers = [value for value in ends if isinstance(value, float)]
        if len(numbers) == 3:
            search = _Search(answer, name, turn(name))
            if search.suspicious(*numbers) and (
                not search.joined(start, end, *numbers) or search.grows(start, end, *numbers)
            ):
                return True
    return False


class _Search:
    """Where one value changes most."""

    def __init__(self, answer: Answer, name: str, turn: float | None) -> None:
        self.answer, self.name, self.turn = answer, name, turn

    def suspicious(self, a: float, middle: float, b: float) -> bool:
        """Whether the value in the middle lies outside of those at the ends, or next to one of them."""
        return max(self._apart(a, middle), self._apart(middle, b)) > STEEP * self._apart(a, b)

    def joined(self, start: float, end: float, a: float, between: float, b: float) -> bool:
        """Whether the change of the value vanishes with the interval."""
        most = max(self._apart(a, b), self._apart(a, between), self._apart(between, b))
        for _ in range(HALVINGS):
            place = 0.5 * (start + end)
            middle = None if place in (start, end) else self._at(place)
            if middle is None:
                return False
            most = max(most, self._apart(a, middle), self._apart(middle, b))
            if self._apart(a, middle) >= self._apart(middle, b):
                end, b = place, middle
            else:
                start, a = place, middle
            if self._apart(a, b) <= max(VANISHED * most, ROUNDING * max(abs(a), abs(b))):
                return True
        return False

    def grows(self, start: float, end: float, a: float, between: float, b: float) -> bool:
        """Whether the value grows without bound, or vanishes, where it is largest: at a maximum it does not,
        however small it is at the ends."""
        most = GROWN * max(abs(a), abs(b))
        if self.turn is not None or abs(between) <= max(abs(a), abs(b)):
            return False
        reached: list[float] = []
        for _ in range(HALVINGS):
            if not start < (place := 0.5 * (start + end)) < end:
                break
            places = start, 0.5 * (start + place), place, 0.5 * (place + end), end
            found = [self._at(at) for at in places[1:4]]
            sizes = [abs(number) for number in found if number is not None]
            if len(sizes) < len(found):
                return True
            reached.append(max(sizes))
            largest = sizes.index(reached[-1])
            start, end = places[largest], places[largest + 2]
        return len(reached) > LAST and reached[-1] > max(most, STILL_GROWN * reached[-1 - LAST])

    def _at(self, place: float) -> float | None:
        values = self.answer(place)
        number = None if values is None else values.get(self.name)
        return number if isinstance(number, float) else None

    def _apart(self, a: float, b: float) -> float:
        return abs(b - a) if self.turn is None else abs(math.remainder(b - a, self.turn))
