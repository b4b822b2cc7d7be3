"""Random rule sheets with a planted solution, and a witness at 50 digits that shares nothing with
the solver.

A rule is made as text; the witness reads that text as a Python expression (``^`` as ``**``) over
mpmath numbers. Parsing, binding of names, expansion of calls and evaluation are thus all judged
from outside. Lengths of sheets are small: a block of five rules is a large one here.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mpmath

from tests.oracles.slider_crank import DIGITS, atan2d, cosd, sind

EPS = 2.0**-52
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "sqrt": mpmath.sqrt,
    "exp": mpmath.exp,
    "ln": mpmath.log,
    "abs": abs,
    "sind": sind,
    "cosd": cosd,
    "tand": lambda x: sind(x) / cosd(x),
    "atan2d": atan2d,
}
LIBRARY = """
function hypotenuse(a, b; c)
rules
  s = a^2 + b^2
  c = sqrt(s)
function height(r, t; y)
rules
  k = sind(t)
  y = r*k
function affine(a; b)
parameters {parameter}
rules
  b = 3*a + {parameter}
"""
"""Rule functions that the sheets call; ``affine`` shares a parameter with the sheet."""


@dataclass(frozen=True)
class RandomRule:
    """One rule: its text, and its scalar equations as (guard, left, right) in Python syntax.

    ``guard`` is a comparison, or None; an equation asks nothing where it is false.
    """

    text: str
    equations: tuple[tuple[str | None, str, str], ...]


@dataclass(frozen=True)
class RandomSheet:
    """``state`` satisfies every rule, to the rounding of its constant; ``inputs`` are some of its
    names."""

    rules: tuple[RandomRule, ...]
    inputs: tuple[str, ...]
    state: Mapping[str, float]

    @property
    def text(self) -> str:
        rows = [f"  {n} = {v!r}" if n in self.inputs else f"  {n}" for n, v in self.state.items()]
        library = LIBRARY.format(parameter=next(iter(self.state)))
        body = "\n".join(f"  {rule.text}" for rule in self.rules)
        return "variables\n" + "\n".join(rows) + f"\nrules\n{body}\n{library}"

    @property
    def unknowns(self) -> tuple[str, ...]:
        return tuple(name for name in self.state if name not in self.inputs)

    @property
    def rows(self) -> list[set[str]]:
        """The unknowns in each rule, for rules of one equation without a guard."""
        sides = (f"{left} {right}" for rule in self.rules for _, left, right in rule.equations)
        return [_names(side) & set(self.unknowns) for side in sides]

    def shuffled(self, draw: random.Random) -> RandomSheet:
        return replace(self, rules=tuple(draw.sample(self.rules, len(self.rules))))

    def without(self, place: int) -> RandomSheet:
        return replace(self, rules=self.rules[:place] + self.rules[place + 1 :])

    def adding(self, rule: RandomRule) -> RandomSheet:
        return replace(self, rules=(*self.rules, rule))

    def given(self, inputs: Sequence[str]) -> RandomSheet:
        return replace(self, inputs=tuple(inputs))


def _names(text: str) -> set[str]:
    return set(re.findall(r"[A-Za-z_]\w*", text))


# --- the witness ------------------------------------------------------------------


def evaluated(expression: str, values: Mapping[str, Any]) -> Any:
    """An expression of the language at 50 digits."""
    source = expression.replace("^", "**").replace("<>", "!=")
    return eval(source, {"__builtins__": {}}, {**FUNCTIONS, **values})


def exact(values: Mapping[str, float]) -> dict[str, Any]:
    return {name: mpmath.mpf(value) for name, value in values.items()}


def active(rule: RandomRule, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The equations of a rule that hold something at these values."""
    return [(a, b) for guard, a, b in rule.equations if guard is None or evaluated(guard, values)]


def backward_error(left: str, right: str, values: Mapping[str, float]) -> float:
    """|F| / Σ|∂F/∂v·v|, the relative change of the values that would satisfy the equation."""
    with mpmath.workdps(DIGITS):
        at = exact(values)

        def miss(point: Mapping[str, Any]) -> Any:
            return evaluated(left, point) - evaluated(right, point)

        size = mpmath.mpf(0)
        for name, value in at.items():
            step = mpmath.mpf(10) ** -20 * (abs(value) or 1)
            change = miss({**at, name: value + step}) - miss({**at, name: value - step})
            size += abs(change / (2 * step) * value)
        found = abs(miss(at))
        return float(found / size) if size else (0.0 if found == 0 else float("inf"))


def jacobian(sheet: RandomSheet, values: Mapping[str, float]) -> Any:
    """Derivatives of the active equations by the unknowns times the values: (equations,
    unknowns)."""
    with mpmath.workdps(DIGITS):
        at = exact(values)
        rows = []
        for left, right in (pair for rule in sheet.rules for pair in active(rule, at)):
            row = []
            for name in sheet.unknowns:
                step = mpmath.mpf(10) ** -20 * (abs(at[name]) or 1)
                up, down = {**at, name: at[name] + step}, {**at, name: at[name] - step}
                change = evaluated(f"({left})-({right})", up) - evaluated(
                    f"({left})-({right})", down
                )
                row.append(float(change / (2 * step) * (abs(at[name]) or 1)))
            rows.append(row)
        return rows


# --- structure, decided by alternating paths --------------------------------------


def _match(rows: Sequence[Collection[str]]) -> dict[str, int]:
    """A maximum matching, unknown to row (Berge's augmenting paths)."""
    owner: dict[str, int] = {}

    def augment(row: int, seen: set[str]) -> bool:
        for name in rows[row]:
            if name not in seen:
                seen.add(name)
                if name not in owner or augment(owner[name], seen):
                    owner[name] = row
                    return True
        return False

    for row in range(len(rows)):
        augment(row, set())
    return owner


def is_square(rows: Sequence[Collection[str]], unknowns: Collection[str]) -> bool:
    """Whether as many rows as unknowns match perfectly."""
    return len(rows) == len(unknowns) == len(_match(rows))


def undetermined(rows: Sequence[Collection[str]], unknowns: Collection[str]) -> set[str]:
    """Unknowns that an alternating path reaches from one without a row (Dulmage & Mendelsohn
    1958)."""
    owner = _match(rows)
    of_row = {row: name for name, row in owner.items()}
    reached: set[str] = set()
    waiting = [name for name in unknowns if name not in owner]
    while waiting:
        name = waiting.pop()
        reached.add(name)
        touched = (of_row[k] for k, row in enumerate(rows) if name in row and k in of_row)
        waiting.extend(other for other in touched if other not in reached)
    return reached


# --- making rules -----------------------------------------------------------------


def _constant(expression: str, state: Mapping[str, float]) -> str:
    with mpmath.workdps(DIGITS):
        return repr(float(evaluated(expression, exact(state))))


def _plain(expression: str, state: Mapping[str, float]) -> RandomRule:
    """``expression = its value at the state``."""
    constant = _constant(expression, state)
    return RandomRule(f"{expression} = {constant}", ((None, expression, constant),))


def off_by_one(rule: RandomRule) -> RandomRule:
    """A plain rule that asks for 1 more than holds at the state."""
    (_, left, right), *_ = rule.equations
    constant = repr(float(right) + 1.0)
    return RandomRule(f"{left} = {constant}", ((None, left, constant),))


def _coefficient(draw: random.Random) -> int:
    return draw.choice((-5, -4, -3, -2, 2, 3, 4, 5, 7))


def linear(draw: random.Random, names: Sequence[str], state: Mapping[str, float]) -> RandomRule:
    return _plain(" + ".join(f"({_coefficient(draw)})*{name}" for name in names), state)


def polynomial(draw: random.Random, names: Sequence[str], state: Mapping[str, float]) -> RandomRule:
    terms = []
    for name in names:
        other = draw.choice(names)
        form = draw.choice(("{c}*{a}", "{c}*{a}^2", "{a}^3", "{c}*{a}*{b}", "{a}*{b}"))
        terms.append(form.format(c=f"({_coefficient(draw)})", a=name, b=other))
    return _plain(" + ".join(terms), state)


def trigonometric(
    draw: random.Random, names: Sequence[str], state: Mapping[str, float]
) -> RandomRule:
    """``state`` holds angles in degrees under names that begin with ``t``."""
    terms = []
    for name in names:
        if name.startswith("t"):
            other = next((n for n in draw.sample(names, len(names)) if not n.startswith("t")), "3")
            terms.append(f"{other}*{draw.choice(('sind', 'cosd'))}({name})")
        else:
            terms.append(
                draw.choice(("{c}*{a}", "{a}", "{a}^2")).format(c=_coefficient(draw), a=name)
            )
    return _plain(" + ".join(terms), state)


def rational(draw: random.Random, names: Sequence[str], state: Mapping[str, float]) -> RandomRule:
    first, *rest = draw.sample(names, len(names))
    below = " + ".join(["1", *(f"{name}^2" for name in rest)])
    form = draw.choice(("{a}/({b})", "{a} - {a}/({b})", "1/{a} + 1/({b})"))
    return _plain(form.format(a=first, b=below), state)


def transcendental(
    draw: random.Random, names: Sequence[str], state: Mapping[str, float]
) -> RandomRule:
    terms = []
    for name in names:
        form = draw.choice(
            ("exp({a}/10)", "sqrt(abs({a}))", "abs({a})", "ln(1 + {a}^2)", "{a}", "2*{a}")
        )
        terms.append(form.format(a=name))
    return _plain(draw.choice((" + ", " - ")).join(terms), state)


def guarded(draw: random.Random, names: Sequence[str], state: Mapping[str, float]) -> RandomRule:
    """``if a > t then … else …``: the planted side holds at the state, the other asks something
    else."""
    pivot = draw.choice(names)
    threshold = state[pivot] + draw.choice((-3.0, -1.0, 1.0, 3.0))
    guard = f"{pivot} > ({threshold!r})"
    return _sided(draw, names, state, guard, guard)


def cased(draw: random.Random, names: Sequence[str], state: Mapping[str, float]) -> RandomRule:
    """As ``guarded``, by any comparison, with another name or a number that the state may be
    equal to; at times with a requirement that the state meets."""
    pivot, operator = draw.choice(names), draw.choice(("=", "<>", "<", "<=", ">=", ">"))
    number = repr(state[pivot] + draw.choice((0.0, 0.0, -1.0, 2.0)))
    other = draw.choice((number, number, draw.choice(sorted(state))))
    guard = witness = f"{pivot} {operator} ({other})"
    if operator in ("=", "<>"):  # up to rounding
        equal = f"abs({pivot} - ({other})) <= 16*{EPS}*abs({other})"
        witness = equal if operator == "=" else f"not ({equal})"
    rule = _sided(draw, names, state, guard, witness)
    bound = state[pivot] - draw.choice((1.0, 3.0))
    required = f"\n  {pivot} >= ({bound!r})" if draw.random() < 0.3 else ""
    return replace(rule, text=rule.text + required)


def _sided(
    draw: random.Random,
    names: Sequence[str],
    state: Mapping[str, float],
    guard: str,
    witness: str,
) -> RandomRule:
    """A rule with two sides, of which the one that the guard selects holds at the state."""
    make = draw.choice((linear, polynomial))
    one, two = make(draw, names, state), make(draw, names, state)
    (_, left, right), (_, other_left, other_right) = one.equations[0], two.equations[0]
    if evaluated(witness, state):
        other_right = repr(float(other_right) + draw.choice((-2.5, 1.5)))
    else:
        right = repr(float(right) + draw.choice((-2.5, 1.5)))
    text = f"if {guard} then {left} = {right} else {other_left} = {other_right}"
    return RandomRule(text, ((witness, left, right), (f"not ({witness})", other_left, other_right)))


def called(draw: random.Random, names: Sequence[str], state: Mapping[str, float]) -> RandomRule:
    """A call of a rule function of the library with a number as its result: it runs backwards."""
    a, b = draw.sample(names, 2) if len(names) > 1 else (names[0], names[0])
    parameter = next(iter(state))
    kind = draw.choice(("hypotenuse", "affine", "height"))
    if kind == "affine":
        value = f"3*({a} + {b}) + {parameter}"
        constant = _constant(value, state)
        return RandomRule(f"call affine({a} + {b}; {constant})", ((None, value, constant),))
    if kind == "height":
        value = f"{a}*sind({b})"
        constant = _constant(value, state)
        return RandomRule(f"call height({a}, {b}; {constant})", ((None, value, constant),))
    value = f"sqrt({a}^2 + {b}^2)"
    constant = _constant(value, state)
    return RandomRule(f"hypotenuse({a}, {b}) = {constant}", ((None, value, constant),))


Maker = Callable[[random.Random, Sequence[str], Mapping[str, float]], RandomRule]
FAMILIES: Mapping[str, tuple[Maker, ...]] = {
    "linear": (linear,),
    "polynomial": (linear, polynomial),
    "trigonometric": (linear, trigonometric),
    "rational": (linear, rational),
    "transcendental": (linear, transcendental),
    "guarded": (linear, guarded),
    "cased": (linear, cased, cased, called),
    "called": (linear, called),
    "mixed": (linear, polynomial, trigonometric, rational, transcendental, guarded, called),
}


def random_sheet(draw: random.Random, family: str, rules: int | None = None) -> RandomSheet:
    """A structurally well-posed sheet: each rule has one unknown of its own, and up to two other
    names."""
    count = rules or draw.randint(1, 5)
    known = draw.randint(1, 3)
    names = [f"x{i}" for i in range(count + known)]
    if family in ("trigonometric", "mixed"):
        names = [f"t{i}" if i and draw.random() < 0.4 else name for i, name in enumerate(names)]
    state = {name: _planted(draw, name) for name in names}
    owned = draw.sample(names, count)
    made = []
    for own in owned:
        others = draw.sample(
            [n for n in names if n != own], min(draw.choice((0, 1, 1, 2)), len(names) - 1)
        )
        made.append(draw.choice(FAMILIES[family])(draw, [own, *others], state))
    inputs = tuple(name for name in names if name not in owned)
    return RandomSheet(tuple(made), inputs, state)


def _planted(draw: random.Random, name: str) -> float:
    if name.startswith("t"):
        return float(draw.choice((draw.randint(-17, 18) * 10, draw.randint(-179, 180))))
    return draw.choice((float(draw.randint(-9, 9)), draw.randint(-90, 90) / 10)) or 1.5
