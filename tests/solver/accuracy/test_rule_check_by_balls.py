"""The rule check beside a proof: over a box of the changes that it admits, a rule that holds has a
zero.

The rules are those of the small sheets at special points, the values planted ones, and these
changed by little, by much, and to others. Balls of 4,200 bits enclose what a rule misses by over
the whole box.
"""

from __future__ import annotations

import math
import random

import pytest

import rulesheets
from benchmarks import hostile_small
from benchmarks.hostile_sheets import Dice
from rulesheets.evaluate import Undefined
from rulesheets.syntax.nodes import Number, names, walk
from solver.accuracy import rule_check, rule_sides

SHEETS = 1_800
BITS = 4_200
LEAST = 1e-323
"""What values may be off by however small they are: floats next to 0 are half as far apart."""


def _changed(value: float, dice: random.Random, drawn: float) -> float:
    way = dice.choice(("as it is", "a little", "next", "mirrored", "far", "another"))
    match way:
        case "a little":
            value *= 1 + dice.choice((1, -1)) * 10.0 ** -dice.randint(1, 16)
        case "next":
            value = math.nextafter(value, dice.choice((-math.inf, math.inf)))
        case "mirrored":
            value = -value
        case "far":
            value *= 10.0 ** dice.choice((-60, -30, -16, 16, 60))
        case "another":
            value = drawn
    return value if math.isfinite(value) else 1.0


@pytest.mark.parametrize("part", range(3))
def test_no_rule_holds_that_no_change_admitted_satisfies(part: int) -> None:
    flint = pytest.importorskip("flint")
    from rulesheets.evaluate.balls import enclosing_ball

    judged = 0
    for seed in range(part * SHEETS // 3, (part + 1) * SHEETS // 3):
        made, dice = hostile_small.sheet(seed), random.Random(seed)
        text = "\n".join(f"{left} = {right}" for _, left, right in made.rules)
        try:
            model = rulesheets.loads(f"rules\n{text}\n")
        except rulesheets.RuleSheetError:  # a number that no float holds
            continue
        for equation in model.equations:
            if rule_sides.jumps(equation):  # which floats may saturate into: tanh(20) is 1 to them
                continue
            planted, special = made.planted or {}, Dice(seed, 3)
            values = {}
            for name in sorted({*names(equation.left), *names(equation.right)}):
                drawn = hostile_small.special(special)
                values[name] = _changed(planted.get(name, drawn), dice, drawn)
            constants = (
                p.value
                for s in (equation.left, equation.right)
                for p in walk(s)
                if isinstance(p, Number)
            )
            if any(v and not 1e-60 <= abs(v) <= 1e60 for v in (*values.values(), *constants)):
                continue  # see docs/limits.md
            if not rule_check.check_rule(equation, values).holds:
                continue
            with flint.ctx.workprec(BITS):
                box = {}
                for name, value in values.items():
                    middle = flint.arb(value)
                    box[name] = middle + flint.arb(
                        0, (abs(middle) * 2 * rule_check.BACKWARD + LEAST).upper()
                    )
                try:
                    missed = enclosing_ball(equation.left, box) - enclosing_ball(
                        equation.right, box
                    )
                except Undefined:
                    continue
                judged += 1
                assert missed.contains(0), f"{seed}: {text} at {values}"
    assert judged > 50
