"""Small sheets of two inputs, for compiled plans: one to three rules, asked where numbers are
special.

A plan learns its ways at plain numbers; what it learned is asked at 0, right angles and near the
ends of the floats, where products underflow, numbers drown in sums, and what was regular no longer
is.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from benchmarks.hostile_sheets import Sheet, names_of

INPUTS = ("a", "b")
UNKNOWNS = ("x", "y", "z")
SPECIAL = (0.0, 1.0, -1.0, 2.0, 0.5, 3.0, 4.0, 0.1, 0.3, 30.0, 45.0, 90.0, -90.0, 180.0, 360.0)
SPECIAL += (1e-9, -1e-9, 1e8, 1e16, 1e300, -1e300, 1e-300)
CONSTANTS = ("1.0", "2.0", "0.5", "3.0", "90.0", "0.1", "4.0")
POWERS = ("2", "3", "0.5", "(-1)", "(-2)")
OF_ONE = ("sqrt", "abs", "exp", "ln", "sind", "cosd", "tand", "asind", "acosd", "atand")
OF_ONE += ("sin", "cos", "tan", "int", "sgn")
OF_TWO = ("atan2d", "max", "min")
OPPOSITE = {"<": ">=", ">=": "<", "=": "<>", "<>": "="}
PLAIN_POINTS, SPECIAL_POINTS = 4, 10


def sheet(seed: int, most: int = 3) -> Sheet:
    """The sheet of a seed, always the same: each rule has an unknown of its own and may read those
    before."""
    random = Random(seed)
    count = min(most, random.choice((1, 1, 2, 2, 3)))
    rules, lines = [], []
    for place, unknown in enumerate(UNKNOWNS[:count]):
        known = [*INPUTS, *UNKNOWNS[:place]]
        left = _expression(random, [*known, unknown], 2)
        if unknown not in names_of(left):
            left = f"{unknown} {random.choice('*/+-')} {left}" if random.random() < 0.7 else unknown
        right = _expression(random, known, 1)
        if random.random() < 0.15:
            tested, relation, edge = map(random.choice, (INPUTS, tuple(OPPOSITE), "ab10"))
            other = _expression(random, list(INPUTS), 1)
            rules.append((f"{tested} {relation} {edge}", left, right))
            rules.append((f"{tested} {OPPOSITE[relation]} {edge}", unknown, other))
            lines.append(f"if {rules[-2][0]} then {left} = {right} else {unknown} = {other}")
        else:
            rules.append(("", left, right))
            lines.append(f"{left} = {right}")
    used = names_of(" ".join(map(" ".join, rules)))
    inputs = {name: _plain(random) for name in INPUTS if name in used}
    return Sheet(f"{count} rule{'s' * (count > 1)}", tuple(rules), inputs, lines=tuple(lines))


def points(made: Sheet, seed: int) -> list[tuple[float, ...]]:
    """Plain numbers of the inputs, of which a plan learns, then special ones."""
    random, count = Random(seed), len(made.inputs)
    found = [tuple(made.inputs.values())]
    found += [tuple(_plain(random) for _ in range(count)) for _ in range(PLAIN_POINTS - 1)]
    for _ in range(SPECIAL_POINTS):
        point = [
            random.choice(SPECIAL) if random.random() < 0.6 else _plain(random)
            for _ in range(count)
        ]
        found.append((point[0],) * count if random.random() < 0.15 else tuple(point))
    return list(dict.fromkeys(found))


def _plain(random: Random) -> float:
    return random.uniform(0.1, 5.0) * random.choice((1.0, 1.0, -1.0))


def _expression(random: Random, names: Sequence[str], depth: int) -> str:
    if depth == 0 or random.random() < 0.2:
        return random.choice(names) if random.random() < 0.75 else random.choice(CONSTANTS)
    way = random.random()
    if way < 0.6:
        one, other = (_expression(random, names, depth - 1) for _ in range(2))
        return f"({one} {random.choice('+-*/')} {other})"
    inside = _expression(random, names, depth - 1)
    if way < 0.7:
        return f"({inside})^{random.choice(POWERS)}"
    function = random.choice((*OF_ONE, *OF_TWO))
    return f"{function}(b, {inside})" if function in OF_TWO else f"{function}({inside})"
