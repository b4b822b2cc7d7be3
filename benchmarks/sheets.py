"""Large sheets with a planted solution, their rules in random order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from random import Random
from typing import TypeAlias

Sheet: TypeAlias = tuple[str, Mapping[str, float]]
"""The text of a sheet, and the value of every variable (right but for rounding)."""

BLOCK = 5


def chain(rules: int, seed: int = 1) -> Sheet:
    """``x1 = 0.7*x0 + 0.2``, …: each variable follows from the one before; the first is given."""
    random = Random(seed)
    lines, values = [], {"x0": 1.0}
    for i in range(rules):
        a, b = round(random.uniform(0.5, 0.9), 3), round(random.uniform(-1, 1), 3)
        lines.append(f"x{i + 1} = {a}*x{i} + {b}")
        values[f"x{i + 1}"] = a * values[f"x{i}"] + b
    return _sheet(random, {"x0": 1.0}, lines), values


def backward_chain(rules: int, seed: int = 1) -> Sheet:
    """``x0 = 0.7*x1 + 0.2``, …: each rule is solved for the variable on its right; ``x0`` is given.

    The factors exceed 1, so that going backward makes rounding errors smaller.
    """
    random = Random(seed)
    lines, values = [], {"x0": 1.0}
    for i in range(rules):
        after, a = random.uniform(1, 2), round(random.uniform(1.1, 1.5), 3)
        lines.append(f"x{i} = {a}*x{i + 1} + {values[f'x{i}'] - a * after!r}")
        values[f"x{i + 1}"] = after
    return _sheet(random, {"x0": 1.0}, lines), values


def linear_blocks(rules: int, seed: int = 1) -> Sheet:
    """Five equations in five unknowns each, which read one unknown of the block before."""
    random = Random(seed)
    lines, values = [], {"x": 1.0}
    for block in range(rules // BLOCK):
        names = [f"x{block}_{i}" for i in range(BLOCK)]
        before = f"x{block - 1}_0" if block else "x"
        values.update((name, random.uniform(-3, 3)) for name in names)
        for i in range(BLOCK):
            row = [round(random.uniform(1, 2) + 6 * (i == j), 3) for j in range(BLOCK)]
            size = sum(a * values[name] for a, name in zip(row, names, strict=True))
            terms = " + ".join(f"{a}*{name}" for a, name in zip(row, names, strict=True))
            lines.append(f"{terms} = {before} + {size - values[before]!r}")
    return _sheet(random, {"x": 1.0}, lines), values


def cubic_blocks(rules: int, seed: int = 1) -> Sheet:
    """Five equations in five unknowns each, with a cube and a product, and one solution."""
    random = Random(seed)
    lines, values = [], {"k": 2.0}
    for block in range(rules // BLOCK):
        a, b = random.uniform(0.5, 2), random.uniform(0.5, 2)
        c = a**3
        d = c + 2 * a
        e = d + values["k"] * c
        names = [f"{letter}{block}" for letter in "abcde"]
        values.update(zip(names, (a, b, c, d, e), strict=True))
        A, B, C, D, E = names
        lines += [
            f"{A} + {B} = {a + b!r}",
            f"{C} = {A}^3",
            f"{D} = {C} + 2*{A}",
            f"{E} = {D} + k*{C}",
        ]
        lines.append(f"{E} - {B} = {e - b!r}")
    return _sheet(random, {"k": 2.0}, lines), values


SHAPES: Mapping[str, Callable[[int], Sheet]] = {
    "chain": chain,
    "backward chain": backward_chain,
    "linear blocks": linear_blocks,
    "cubic blocks": cubic_blocks,
}


def _sheet(random: Random, inputs: Mapping[str, float], rules: Iterable[str]) -> str:
    shuffled = list(rules)
    random.shuffle(shuffled)
    return "\n".join(
        ["variables", *(f"{n} = {v!r}" for n, v in inputs.items()), "rules", *shuffled, ""]
    )
