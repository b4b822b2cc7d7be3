"""Random, ill-scaled, degenerate and hostile sheets, each from a seed.

Some are built around a planted state, of which every rule is a consequence; some are random rules
that may have any number of solutions or none; some are made to break things: poles, overflow, 0/0,
double roots, rules that say the same thing twice or contradict each other, guards that wait on what
they guard, and broken text.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Any

import mpmath
import numpy as np

from benchmarks.expressions import DIGITS, Undefined, evaluated


@dataclass(frozen=True)
class Sheet:
    """``rules`` are (condition or "", left, right). ``planted`` is a state that satisfies all of
    them to the rounding of their constants, None where there is none that is known of.

    ``lines``: the text of the rules, where it is not plain; ``head``: what comes before the
    sections; ``symbols``: inputs that are no numbers; ``raw``: the whole text, of a sheet that may
    well be refused.
    """

    kind: str
    rules: tuple[tuple[str, str, str], ...]
    inputs: Mapping[str, float] = field(default_factory=dict)
    guesses: Mapping[str, float] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    planted: Mapping[str, float] | None = None
    raw: str | None = None
    lines: tuple[str, ...] | None = None
    head: tuple[str, ...] = ()
    symbols: Mapping[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        if self.raw is not None:
            return self.raw
        lines = [_line(rule) for rule in self.rules] if self.lines is None else self.lines
        if not (self.inputs or self.guesses or self.ranges or self.symbols or self.head):
            return "\n".join([*lines, ""])
        rows = [f"{name} = {symbol}" for name, symbol in self.symbols.items()]
        rows += [f"{name} = {value!r}" for name, value in self.inputs.items()]
        for name in sorted(
            names_of(" ".join(" ".join(rule) for rule in self.rules)) - {*self.inputs}
        ):
            guess = f" ~ {self.guesses[name]!r}" if name in self.guesses else ""
            low, high = self.ranges.get(name, (-math.inf, math.inf))
            range_ = f" in [{low!r}, {high!r}]" if low > -math.inf and not guess else ""
            rows.append(f"{name}{guess}{range_}")
        return "\n".join(["variables", *rows, "rules", *lines, *self.head, ""])


def _line(rule: tuple[str, str, str]) -> str:
    condition, left, right = rule
    return f"if {condition} then {left} = {right}" if condition else f"{left} = {right}"


NAMES = ("a", "b", "c", "d", "x", "y", "z", "w")
SMOOTH = ("sin", "cos", "exp", "sqrt", "ln", "atan", "sind", "cosd", "abs", "tanh")
ROUGH = (
    *SMOOTH,
    "tan",
    "asin",
    "acos",
    "int",
    "sgn",
    "tand",
    "cosh",
    "acosd",
    "round",
    "frac",
    "log",
)
OF_TWO = frozenset({"min", "max", "mod", "atan2", "atan2d"})
CONSTANTS = ("0", "1", "2", "3", "0.5", "10", "1e-3", "1e6", "7", "360", "90", "pi")
NASTY = ("0", "1e-300", "1e300", "1e-16", "1e16", "1e-9", "4.9e-324", "1.7e308", "1e150", "1e-150")


class Dice(Random):
    """``most``: unknowns of a sheet, and levels of an expression, at most."""

    def __init__(self, seed: int, most: int) -> None:
        super().__init__(seed)
        self.most = most

    def __new__(cls, seed: int, most: int) -> Dice:
        return super().__new__(cls, seed)


# --- planted ---


def magnitude(random: Dice, decades: float) -> float:
    value = random.choice((-1, 1)) * 10.0 ** random.uniform(-decades, decades)
    return float(f"{value:.{random.choice((2, 4, 16))}e}")


def planted(
    random: Dice,
    decades: float = 1.0,
    extra: int = 0,
    functions: tuple[str, ...] = SMOOTH,
    limit: float = 1e12,
) -> Sheet:
    """Rules of random expressions, none larger than the ``limit``, at a random state of so many
    decades."""
    n = random.randint(1, random.most)
    names = random.sample(NAMES, n + random.randint(0, 2))
    unknown = names[:n]
    state = {name: magnitude(random, decades) for name in names}
    rules = []
    for k in range(n + extra):
        for _ in range(60):
            left = expression(random, names, random.randint(1, min(3, random.most)), functions)
            try:
                value = float(evaluated(left, state))
            except (Undefined, OverflowError):
                continue
            must = unknown[k % n]
            if math.isfinite(value) and abs(value) < limit and must in names_of(left):
                rules.append(("", left, repr(value)))
                break
    given = {name: state[name] for name in names if name not in unknown}
    guesses = {}
    if random.random() < 0.4:
        guesses = {name: state[name] * random.uniform(0.3, 3) for name in unknown}
    return Sheet("planted", tuple(rules), given, guesses, planted=state)


def names_of(text: str) -> set[str]:
    return set(re.findall(r"\b[a-z]\b", text))


def expression(random: Dice, names: list[str], depth: int, functions: tuple[str, ...]) -> str:
    if depth == 0 or random.random() < 0.15:
        return random.choice(names) if random.random() < 0.75 else random.choice(CONSTANTS)

    def part() -> str:
        return expression(random, names, depth - 1, functions)

    way = random.random()
    if way < 0.30:
        return f"({part()} {random.choice('+-')} {part()})"
    if way < 0.55:
        return f"({part()}*{part()})"
    if way < 0.67:
        return f"({part()}/{part()})"
    if way < 0.80:
        return f"({part()})^{random.choice(('2', '2', '3', '4', '0.5', '-1', '1.5'))}"
    function = random.choice(functions)
    return f"{function}({part()}, {part()})" if function in OF_TWO else f"{function}({part()})"


def _ill_scaled(random: Dice) -> Sheet:
    made = planted(random, decades=random.choice((6.0, 9.0, 12.0)))
    return Sheet("ill-scaled", made.rules, made.inputs, made.guesses, planted=made.planted)


def _overdetermined(random: Dice) -> Sheet:
    made = planted(random, extra=random.randint(1, 3))
    rules = [*made.rules, *random.sample(made.rules, min(len(made.rules), 1))]
    random.shuffle(rules)
    return Sheet("redundant", tuple(rules), made.inputs, made.guesses, planted=made.planted)


def _contradictory(random: Dice) -> Sheet:
    """A planted sheet, one rule of which is repeated with another value."""
    made = planted(random)
    if not made.rules:
        return made
    condition, left, right = random.choice(made.rules)
    other = float(right) * random.uniform(1.001, 2) + random.choice((0.0, 1.0)) or 1.0
    rules = [*made.rules, (condition, left, repr(other))]
    random.shuffle(rules)
    return Sheet("contradictory", tuple(rules), made.inputs, made.guesses)


def _rough(random: Dice) -> Sheet:
    made = planted(random, functions=ROUGH)
    return Sheet("rough", made.rules, made.inputs, made.guesses, planted=made.planted)


def _ranged(random: Dice) -> Sheet:
    """A planted sheet with finite ranges around its state."""
    made = planted(random)
    assert made.planted is not None
    ranges = {}
    for name, value in made.planted.items():
        if name not in made.inputs:
            reach = abs(value) * random.uniform(0.1, 5) + random.uniform(0, 3)
            ranges[name] = (value - reach, value + reach * random.uniform(0.1, 1))
    return Sheet("ranged", made.rules, made.inputs, {}, ranges, made.planted)


# --- whatever comes ---


def _random(random: Dice) -> Sheet:
    n = random.randint(1, random.most)
    names = random.sample(NAMES, n)
    rules = [("", *sides(random, names)) for _ in range(max(1, n + random.randint(-1, 2)))]
    inputs = {name: magnitude(random, 2) for name in names if random.random() < 0.3}
    return Sheet("random", tuple(rules), inputs)


def sides(random: Dice, names: list[str]) -> tuple[str, str]:
    left = expression(random, names, random.randint(1, min(3, random.most)), ROUGH)
    if not names_of(left):
        left = random.choice(names)
    return left, expression(random, names, random.randint(0, 2), ROUGH)


def _nasty(random: Dice) -> Sheet:
    """Numbers at the ends of the floats."""
    names = random.sample(NAMES, random.randint(1, 3))
    rules = []
    for _ in range(len(names)):
        left = expression(random, names, random.randint(1, 2), ROUGH)
        left = left if names_of(left) else names[0]
        rules.append(
            (
                "",
                f"{left}*{random.choice(NASTY)}" if random.random() < 0.5 else left,
                random.choice(NASTY),
            )
        )
    inputs = {name: float(random.choice(NASTY)) for name in names if random.random() < 0.4}
    return Sheet("nasty numbers", tuple(rules), inputs)


DEGENERATE = (
    ("(x - {a})^2 = 0",),
    ("(x - {a})^3 = 0",),
    ("x^2 + y^2 = 0",),
    ("x^2 + y^2 = {p}", "x*y = 0"),
    ("x*y = 0", "x + y = {a}"),
    ("x*y = 0", "x*z = 0", "y + z = {a}"),
    ("x = x",),
    ("x + y = y + x", "x - y = {a}"),
    ("0*x = 0",),
    ("0*x = {p}",),
    ("1/x = 0",),
    ("x/x = 1",),
    ("x/x = {p}",),
    ("sqrt(x) = -{p}",),
    ("sqrt(x^2) = x",),
    ("ln(x) = {a}", "x = 0"),
    ("exp(x) = 0",),
    ("exp(x) = -{p}",),
    ("exp(1000*x) = {p}",),
    ("exp(exp(x)) = {p}",),
    ("x^x = 1",),
    ("x^0 = 1",),
    ("0^x = 0",),
    ("abs(x) = -{p}",),
    ("abs(x) + abs(y) = 0",),
    ("sin(x) = {q}",),
    ("sin(x) = 2",),
    ("tan(x) = {big}",),
    ("x - sin(x) = 0",),
    ("x*(x^2 + y^2) = 0", "y*(x^2 + y^2) = 0"),
    ("x^2 + y^2 = 1", "(x - 2)^2 + y^2 = 1"),
    ("x^2 + y^2 = 1", "(x - {t})^2 + y^2 = 1"),
    ("x + y = {a}", "2*x + 2*y = 2*{a}"),
    ("x + y = {a}", "2*x + 2*y = 2*{a} + {tiny}"),
    ("x + y + z = {a}", "x - y = 0", "2*x + z = {a}"),
    ("x*y = {a}", "x*y = {a} + {p}"),
    ("x*y = {p}", "2*x*y = 2*{p}"),
    ("int(x) = 3",),
    ("round(x) = 2", "x + y = {a}"),
    ("sgn(x) = 0",),
    ("frac(x) = 0.25", "x^2 = {p}"),
    ("1 - exp(-x^2) = 0",),
    ("y^2*(1 - exp(-x^2)) = 0", "x*(1 - exp(-y^2)) = 0"),
    ("1 - cosd(x) = {tiny}",),
    ("x = y + {big}", "y = x - {big}"),
    ("x = y + {big}", "y = {a}", "z = x - {big}"),
    ("(x + {big}) - {big} = y", "y = {a}"),
    ("x^2 - 2*x*y + y^2 = 0", "x + y = {a}"),
    ("1/(x - {a}) = 1/(y - {a})", "x + y = 2*{a}"),
    ("x*sin(1/x) = 0",),
    ("sqrt(x - {a}) + sqrt({a} - x) = 0",),
    ("asin(x) = 2",),
    ("acosd(x) + acosd(-x) = 180",),
    ("tand(x)*tand(90 - x) = 1",),
    ("sind(x)^2 + cosd(x)^2 = 1",),
    ("sind(x)^2 + cosd(x)^2 = {p}",),
    ("x^2 = y^2", "x + y = 0"),
    ("x = y*z", "y = x/z"),
    ("x^4 + 4*x^3 + 6*x^2 + 4*x + 1 = 0",),
    ("x^20 = {tiny}",),
    ("(x - 1)*(x - 1.0000001)*(x - 1.0000002) = 0",),
)


def _degenerate(random: Dice) -> Sheet:
    a, p, big = magnitude(random, 1), abs(magnitude(random, 1)), 10.0 ** random.randint(8, 18)
    words = {
        "a": f"({a!r})",
        "p": repr(p),
        "q": repr(random.choice((0.0, 1.0, -1.0, 0.5, 1 - 1e-15))),
        "big": repr(big),
        "tiny": repr(10.0 ** -random.randint(6, 17)),
        "t": repr(2 + random.choice((-1, 1)) * 10.0 ** -random.randint(3, 16)),
    }
    lines = [rule.format(**words).split(" = ") for rule in random.choice(DEGENERATE)]
    rules = [("", left, right) for left, right in lines]
    random.shuffle(rules)
    names = sorted(names_of(" ".join(left + " " + right for _, left, right in rules)))
    guesses = {name: magnitude(random, 1) for name in names if random.random() < 0.3}
    ranges = {name: (-10.0, 10.0) for name in names if random.random() < 0.3}
    inputs = {n: magnitude(random, 1) for n in names if random.random() < 0.1}
    return Sheet("degenerate", tuple(rules), inputs, guesses, ranges)


def _guarded(random: Dice) -> Sheet:
    """Branches on what they determine; the arms of some don't fit their condition."""
    names = random.sample(NAMES, random.randint(2, max(2, random.most - 1)))
    rules = []
    for name in names:
        left, right = sides(random, names)
        edge = magnitude(random, 1)
        if random.random() < 0.6:
            test, opposite = random.choice((("<", ">="), (">", "<="), ("<=", ">"), ("=", "<>")))
            rules.append((f"{name} {test} {edge!r}", left, right))
            rules.append((f"{name} {opposite} {edge!r}", *sides(random, names)))
        else:
            rules.append(("", left, right))
    inputs = {name: magnitude(random, 1) for name in names[1:] if random.random() < 0.4}
    return Sheet("guarded", tuple(rules), inputs)


def _broken(random: Dice) -> Sheet:
    """The text of another sheet with some characters changed: refused, or read as something
    else."""
    text = planted(random).text
    for _ in range(random.randint(1, 4)):
        place = random.randrange(len(text) + 1)
        text = (
            text[:place]
            + random.choice("()+-*/^=,;'\"[]~ \n\x00é1e.")
            + text[place + random.randint(0, 2) :]
        )
    return Sheet("broken text", (), raw=text)


def active(made: Sheet) -> list[tuple[str, str, str]]:
    """The rules that apply in the planted state."""
    assert made.planted is not None
    return [rule for rule in made.rules if not rule[0] or evaluated(rule[0], made.planted)]


def uncertainty(made: Sheet) -> float:
    """The relative change of the planted values that the rounding of the rules' constants and of
    their evaluation in floats explains; infinite where the rules do not determine the unknowns
    there."""
    if made.planted is None or not made.rules:
        return math.inf
    unknown = [name for name in made.planted if name not in made.inputs]
    try:
        rows = [_row(rule, made.planted, unknown) for rule in active(made)]
    except Undefined:
        return math.inf
    matrix, noise = np.array([row for row, _ in rows]), np.array([off for _, off in rows])
    if len(rows) < len(unknown) or not (np.isfinite(matrix).all() and np.isfinite(noise).all()):
        return math.inf
    with np.errstate(all="ignore"):  # what overflows is infinite, or compares as false
        return _spread(matrix, noise)


def _spread(matrix: Any, noise: Any) -> float:
    """The largest change of the unknowns (n,) that ``noise`` (m,) in rules with slopes (m, n)
    explains."""
    sizes = abs(matrix).max(axis=1)
    matrix, noise = matrix[sizes > 0] / sizes[sizes > 0, None], noise[sizes > 0] / sizes[sizes > 0]
    singular = np.linalg.svd(matrix, compute_uv=False)
    if len(matrix) < matrix.shape[1] or singular[-1] < 1e-12:
        return math.inf
    spread = float((abs(np.linalg.pinv(matrix)) @ noise).max())
    return math.inf if math.isnan(spread) else spread


def _row(
    rule: tuple[str, str, str], state: Mapping[str, float], unknown: list[str]
) -> tuple[list[float], float]:
    """∂F/∂ln v of a rule by the unknowns, and how far it is off by rounding."""
    _, left, right = rule
    decades = math.ceil(
        math.log10(max(1.0, *map(abs, state.values())))
    )  # no step may pass over whole turns
    text, row = f"{left} - ({right})", []
    with mpmath.workdps(DIGITS + 2 * decades):
        step = mpmath.mpf(10) ** (-DIGITS // 2 - decades)
        for name in unknown:
            moved = [
                evaluated(text, {**state, name: mpmath.mpf(state[name]) * (1 + sign * step)})
                for sign in (1, -1)
            ]
            row.append(float((moved[0] - moved[1]) / (2 * step)))
        exact = evaluated(left, state)
    rough = evaluated(left, state, digits=15)
    tiny = not names_of(right) and abs(float(right)) < 1e-290
    return row, math.inf if tiny else float(10 * abs(rough - exact) + 2.0**-52 * abs(exact))


PLAIN: Mapping[str, Callable[[Dice], Sheet]] = {
    "planted": planted,
    "ill-scaled": _ill_scaled,
    "redundant": _overdetermined,
    "contradictory": _contradictory,
    "rough": _rough,
    "ranged": _ranged,
    "random": _random,
    "nasty numbers": _nasty,
    "degenerate": _degenerate,
    "guarded": _guarded,
    "broken text": _broken,
}
