"""Blocks that are hard for every method: many equations of exponentials and squares, solved from
far away.

``exp(c x_a + d x_b) + k x_i - x_(i+1)² = r`` for every i, with the numbers drawn at random and r
chosen so that a planted point, drawn too, is a root. There may be others.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass


@dataclass(frozen=True)
class HardBlock:
    """A sheet in n unknowns x0 …, with guesses in it; ``root`` (n,) is one of its answers, to
    rounding."""

    sheet: str
    guesses: dict[str, float]
    root: dict[str, float]


def hard_block(n: int, seed: int, far: float = 2.0) -> HardBlock:
    """Block number ``seed`` of n unknowns. The root lies in [-1, 1]ⁿ, the guess in [-far, far]ⁿ."""
    draw = random.Random(seed)
    root = {f"x{j}": draw.uniform(-1, 1) for j in range(n)}
    rules = []
    for i in range(n):
        a, b = draw.sample(range(n), 2)
        c, d, k = (round(draw.uniform(-2, 2), 3) for _ in range(3))
        x, after = root[f"x{i}"], (i + 1) % n
        right = math.exp(c * root[f"x{a}"] + d * root[f"x{b}"]) + k * x - root[f"x{after}"] ** 2
        rules.append(f"exp({c}*x{a} + {d}*x{b}) + {k}*x{i} - x{after}^2 = {right!r}")
    guesses = {name: round(far * draw.uniform(-1, 1), 6) for name in root}
    rows = [f"{name} ~ {guess!r}" for name, guess in guesses.items()]
    return HardBlock("\n".join(["variables", *rows, "rules", *rules, ""]), guesses, root)
