"""Random ordinary sheets: chains of the relations that engineers write, with a planted positive
state.

Each relation takes some quantities of the sheet, or new ones of sizes from 1e-3 to 1e6, and plants
others. Which quantities are inputs is then redrawn by exchanges that keep the sheet well posed at
the planted state.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field

import mpmath
import numpy as np

from tests.everyday import judge

SIZES = (1e-3, 1e6)
CONDITION = 1e4
"""Largest condition of the logarithmic Jacobian: there a planted answer is known to eleven
digits."""

EXCHANGES = 9
RELATIONS = 7
LETTERS = "ABDFGHKLMNPQRSTUVWYZabdhkmqstuvwxyz"
NAMES = [letter + digit for digit in ("", *"1234") for letter in LETTERS]


class Unfit(Exception):
    """A relation would plant a value that is outside the sizes of ordinary sheets."""


@dataclass(frozen=True)
class RandomSheet:
    """``state``: the planted value of every variable; ``inputs``: those that are given."""

    seed: int
    rules: tuple[str, ...]
    state: dict[str, float]
    inputs: tuple[str, ...]
    kinds: tuple[str, ...]
    exchanged: int

    @property
    def text(self) -> str:
        rows = [
            f"  {name} = {self.state[name]!r}" if name in self.inputs else f"  {name}"
            for name in self.state
        ]
        return (
            "\n".join(["variables", *rows, "rules", *(f"  {rule}" for rule in self.rules)]) + "\n"
        )


@dataclass
class Draft:
    """A sheet being drawn up: quantities, which of them follow from the others, and rules."""

    draw: random.Random
    state: dict[str, float] = field(default_factory=dict)
    unknown: list[str] = field(default_factory=list)
    rules: list[str] = field(default_factory=list)

    angles: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.reuse = self.draw.uniform(0.3, 0.9)

    def new(self, low: float = SIZES[0], high: float = SIZES[1]) -> str:
        """A new given quantity, to three digits, most often of the middle sizes."""
        middle = math.log10(low) + self.draw.betavariate(2, 2) * math.log10(high / low)
        return self._named(float(f"{10**middle:.3g}"))

    def angle(self, low: float, high: float) -> str:
        """A given angle in degrees, which is nothing else as well."""
        name = self.new(low, high)
        self.angles.add(name)
        return name

    def some(self, low: float = SIZES[0], high: float = SIZES[1]) -> str:
        """A quantity of the sheet between the two, or a new one."""
        fit = [
            n for n, value in self.state.items() if low <= value <= high and n not in self.angles
        ]
        return (
            self.draw.choice(fit)
            if fit and self.draw.random() < self.reuse
            else self.new(low, high)
        )

    def others(self, count: int, low: float = SIZES[0], high: float = SIZES[1]) -> list[str]:
        """Distinct quantities between the two."""
        names: list[str] = []
        while len(names) < count:
            name = self.some(low, high)
            names += [name] if name not in names else []
        return names

    def near(self, name: str, low: float, high: float) -> str:
        """A quantity whose quotient by ``name`` is between the two."""
        while (found := self.some(low * self.state[name], high * self.state[name])) == name:
            pass
        return found

    def plant(self, value: float) -> str:
        """A quantity that follows from the others."""
        if not SIZES[0] <= value <= SIZES[1]:
            raise Unfit
        name = self._named(value)
        self.unknown.append(name)
        return name

    def factor(self, value: float) -> str:
        """A coefficient of two digits that brings a value to an ordinary size."""
        return f"{10 ** self.draw.uniform(-1.5, 3.5) / value:.2g}"

    def _named(self, value: float) -> str:
        name = self.draw.choice([name for name in NAMES if name not in self.state])
        self.state[name] = value
        return name

    def __getitem__(self, name: str) -> float:
        return self.state[name]


Kind = Callable[[Draft], None]
KINDS: dict[str, Kind] = {}


def kind(function: Kind) -> Kind:
    KINDS[function.__name__.replace("_", " ")] = function
    return function


@kind
def product(d: Draft) -> None:
    x, y, w = d.others(3)
    form = d.draw.choice(("{x}*{y}", "{x}/{y}", "{x}*{y}/{w}", "{x}/({y}*{w})", "{x}*{y}*{w}"))
    text = form.format(x=x, y=y, w=w)
    d.rules.append(f"{d.plant(float(eval(text, {}, d.state)))} = {text}")


@kind
def power(d: Draft) -> None:
    x = d.some()
    p = d.draw.choice((2, 3, 4, 0.25, 0.8, 1.5, 1.852, -0.25, 2 / 3))
    shown = "(2/3)" if p == 2 / 3 else str(p)
    c = d.factor(d[x] ** p)
    d.rules.append(f"{d.plant(float(c) * d[x] ** p)} = {c}*{x}^{shown}")


@kind
def root(d: Draft) -> None:
    x, y = d.others(2)
    c = d.factor(math.sqrt(d[x] / d[y]))
    d.rules.append(f"{d.plant(float(c) * math.sqrt(d[x] / d[y]))} = {c}*sqrt({x}/{y})")


@kind
def total(d: Draft) -> None:
    x = d.some()
    y, w = d.near(x, 0.03, 30), d.near(x, 0.03, 30)
    if d.draw.random() < 0.5 or y == w:
        d.rules.append(f"{d.plant(d[x] + d[y])} = {x} + {y}")
    else:
        d.rules.append(f"{d.plant(d[x] + d[y] + d[w])} = {x} + {y} + {w}")


@kind
def difference(d: Draft) -> None:
    x = d.some()
    y = d.near(x, 1.1, 30)
    d.rules.append(f"{d.plant(d[y] - d[x])} = {y} - {x}")


@kind
def in_parallel(d: Draft) -> None:
    x = d.some()
    y = d.near(x, 0.1, 10)
    d.rules.append(f"1/{d.plant(1 / (1 / d[x] + 1 / d[y]))} = 1/{x} + 1/{y}")


@kind
def logarithm(d: Draft) -> None:
    x = d.some()
    y = d.near(x, 1.2, 100)
    value = math.log(d[y] / d[x])
    c = d.factor(value)
    d.rules.append(f"{d.plant(float(c) * value)} = {c}*ln({y}/{x})")


@kind
def decay(d: Draft) -> None:
    x, t = d.others(2)
    tau = d.near(t, 0.3, 10)
    if tau == x:
        raise Unfit
    rest = math.exp(-d[t] / d[tau])
    if d.draw.random() < 0.5:
        d.rules.append(f"{d.plant(d[x] * rest)} = {x}*exp(-{t}/{tau})")
    else:
        d.rules.append(f"{d.plant(d[x] * (1 - rest))} = {x}*(1 - exp(-{t}/{tau}))")


@kind
def component(d: Draft) -> None:
    x, angle = d.some(), d.angle(10, 80)
    turn = math.radians(d[angle])
    name, value = d.draw.choice(
        (("sind", math.sin(turn)), ("cosd", math.cos(turn)), ("tand", math.tan(turn)))
    )
    d.rules.append(f"{d.plant(d[x] * value)} = {x}*{name}({angle})")


@kind
def quadratic(d: Draft) -> None:
    x, a = d.others(2)
    n = d.draw.choice((2, 2, 3))
    b = d.new(0.1 * d[a] * d[x] ** (n - 1), 10 * d[a] * d[x] ** (n - 1))
    d.rules.append(f"{d.plant(d[b] * d[x] + d[a] * d[x] ** n)} = {b}*{x} + {a}*{x}^{n}")


@kind
def hypotenuse(d: Draft) -> None:
    x = d.some()
    y = d.near(x, 0.2, 5)
    d.rules.append(f"{d.plant(math.hypot(d[x], d[y]))}^2 = {x}^2 + {y}^2")


@kind
def law_of_cosines(d: Draft) -> None:
    a = d.some()
    b, C = d.near(a, 0.4, 2.5), d.angle(20, 150)
    c = math.sqrt(d[a] ** 2 + d[b] ** 2 - 2 * d[a] * d[b] * math.cos(math.radians(d[C])))
    d.rules.append(f"{d.plant(c)}^2 = {a}^2 + {b}^2 - 2*{a}*{b}*cosd({C})")


@kind
def exchanger(d: Draft) -> None:
    hot, cold = d.new(0.05, 20), d.new(0.05, 20)
    T = sorted((d.draw.uniform(10, 200) for _ in range(4)), reverse=True)
    Thi, Tci = d._named(round(T[0], 1)), d._named(round(T[3], 1))
    Tho = d._named(round(T[1], 1))
    q = d.plant(4.18 * d[hot] * (d[Thi] - d[Tho]))
    Tco = d.plant(d[Tci] + d[q] / (4.18 * d[cold]))
    one, other = d[Thi] - d[Tco], d[Tho] - d[Tci]
    if min(one, other) < 1 or abs(one / other - 1) < 0.05:
        raise Unfit
    lm = d.plant((one - other) / math.log(one / other))
    UA = d.plant(d[q] / d[lm])
    d.rules += [f"{q} = 4.18*{hot}*({Thi} - {Tho})", f"{q} = 4.18*{cold}*({Tco} - {Tci})"]
    d.rules.append(
        f"{lm} = (({Thi} - {Tco}) - ({Tho} - {Tci}))/ln(({Thi} - {Tco})/({Tho} - {Tci}))"
    )
    d.rules.append(f"{q} = {UA}*{lm}")


@kind
def annuity(d: Draft) -> None:
    loan, rate, term = d.some(100, 1e6), d.new(0.002, 0.05), d.new(6, 360)
    value = d[loan] * d[rate] / (1 - (1 + d[rate]) ** -d[term])
    d.rules.append(f"{d.plant(value)} = {loan}*{rate}/(1 - (1 + {rate})^(-{term}))")


@kind
def ladder_network(d: Draft) -> None:
    V, R1 = d.new(1, 500), d.new(1, 1e4)
    R2, R3, R4 = (d.near(R1, 0.1, 10) for _ in range(3))
    if len({R1, R2, R3, R4, V}) < 5:
        raise Unfit
    g = [1 / d[name] for name in (R1, R2, R3, R4)]
    nodes = np.linalg.solve([[g[0] + g[1] + g[2], -g[2]], [-g[2], g[2] + g[3]]], [d[V] * g[0], 0])
    v1, v2 = (d.plant(float(v)) for v in nodes)
    d.rules += [
        f"({V} - {v1})/{R1} = {v1}/{R2} + ({v1} - {v2})/{R3}",
        f"({v1} - {v2})/{R3} = {v2}/{R4}",
    ]


@kind
def parallel_pipes(d: Draft) -> None:
    Q, K1, K2 = d.new(0.01, 10), d.new(1, 1e3), d.new(1, 1e3)
    ratio = math.sqrt(d[K2] / d[K1])
    Q2 = d.plant(d[Q] / (1 + ratio))
    Q1 = d.plant(ratio * d[Q2])
    h = d.plant(d[K1] * d[Q1] ** 2)
    d.rules += [f"{Q} = {Q1} + {Q2}", f"{h} = {K1}*{Q1}^2", f"{h} = {K2}*{Q2}^2"]


@kind
def weak_acid(d: Draft) -> None:
    C, share = d.some(0.01, 10), d.draw.uniform(0.05, 0.9)
    x = d.plant(share * d[C])
    K = d.plant(d[x] ** 2 / (d[C] - d[x]))
    d.unknown.remove(x)
    d.rules.append(f"{K} = {x}^2/({C} - {x})")


@kind
def channel(d: Draft) -> None:
    b, y = d.some(0.3, 30), d.new(0.1, 5)
    A, R = d.plant(d[b] * d[y]), d.plant(d[b] * d[y] / (d[b] + 2 * d[y]))
    c = f"{d.draw.uniform(1, 5):.2g}"
    Q = d.plant(float(c) * d[A] * d[R] ** (2 / 3))
    d.rules += [f"{A} = {b}*{y}", f"{R} = {A}/({b} + 2*{y})", f"{Q} = {c}*{A}*{R}^(2/3)"]


@kind
def radiator(d: Draft) -> None:
    h, Tr = d.new(2, 50), d.new(200, 400)
    Ts = d.near(Tr, 1.05, 3)
    q = d.plant(d[h] * (d[Ts] - d[Tr]) + 5.67e-8 * (d[Ts] ** 4 - d[Tr] ** 4))
    d.rules.append(f"{q} = {h}*({Ts} - {Tr}) + 5.67e-8*({Ts}^4 - {Tr}^4)")


@kind
def mixing(d: Draft) -> None:
    m1, x1 = d.some(0.01, 1e3), d.some(0.01, 1e3)
    m2, x2 = d.near(m1, 0.1, 10), d.near(x1, 0.1, 10)
    if len({m1, m2, x1, x2}) < 4:
        raise Unfit
    m = d.plant(d[m1] + d[m2])
    x = d.plant((d[m1] * d[x1] + d[m2] * d[x2]) / d[m])
    d.rules += [f"{m} = {m1} + {m2}", f"{m}*{x} = {m1}*{x1} + {m2}*{x2}"]


@kind
def friction(d: Draft) -> None:
    Re, eps = d.new(5e3, 9e5), d.new(1e-3, 0.03)
    f = 0.02
    for _ in range(60):
        f = (-2 * math.log10(d[eps] / 3.7 + 2.51 / (d[Re] * math.sqrt(f)))) ** -2
    name = d.plant(f)
    d.rules.append(f"1/sqrt({name}) = -2*log({eps}/3.7 + 2.51/({Re}*sqrt({name})))")


@kind
def flight(d: Draft) -> None:
    v, angle, t = d.some(1, 500), d.angle(20, 80), d.new(0.2, 60)
    turn = math.radians(d[angle])
    h = d.plant(d[v] * math.sin(turn) * d[t] - 4.905 * d[t] ** 2)
    x = d.plant(d[v] * math.cos(turn) * d[t])
    d.rules += [f"{h} = {v}*sind({angle})*{t} - 4.905*{t}^2", f"{x} = {v}*cosd({angle})*{t}"]
    d.unknown.remove(h)
    d.unknown.append(t)


@kind
def specific_energy(d: Draft) -> None:
    q, y = d.some(0.1, 50), d.new(0.1, 10)
    v = d.plant(d[q] / d[y])
    E = d.plant(d[y] + d[v] ** 2 / 19.62)
    d.rules += [f"{v} = {q}/{y}", f"{E} = {y} + {v}^2/19.62"]


@kind
def lens(d: Draft) -> None:
    f = d.some(1, 500)
    g = d.near(f, 1.1, 20)
    b = d.plant(d[f] * d[g] / (d[g] - d[f]))
    m = d.plant(d[b] / d[g])
    d.rules += [f"1/{f} = 1/{g} + 1/{b}", f"{m} = {b}/{g}"]


@kind
def vapour(d: Draft) -> None:
    T = d.some(5, 200)
    P = d.plant(10 ** (8.07131 - 1730.63 / (233.426 + d[T])))
    d.rules.append(f"log({P}) = 8.07131 - 1730.63/(233.426 + {T})")


@kind
def gas(d: Draft) -> None:
    P, T = d.some(10, 1e4), d.some(250, 1500)
    v = d.plant(0.287 * d[T] / d[P])
    r = d.some(1.5, 20)
    P2, T2 = d.plant(d[P] * d[r] ** 1.4), d.plant(d[T] * d[r] ** 0.4)
    d.rules += [f"{P}*{v} = 0.287*{T}", f"{P2} = {P}*{r}^1.4", f"{T2} = {T}*{r}^0.4"]


@kind
def plate(d: Draft) -> None:
    """A plate between a hot wall and a cooled room, in kelvin."""
    Tp, Tr, h = d.new(320, 900), d.new(250, 310), d.new(2, 60)
    Tf = d.near(Tp, 1.1, 2)
    e = f"{d.draw.uniform(0.2, 0.95):.2g}"
    q = d.plant(float(e) * 5.67e-8 * (d[Tf] ** 4 - d[Tp] ** 4))
    given = d[q] - d[h] * (d[Tp] - d[Tr])
    if given < SIZES[0]:
        raise Unfit
    w = d.plant(given)
    d.rules += [f"{q} = {e}*5.67e-8*({Tf}^4 - {Tp}^4)", f"{q} = {h}*({Tp} - {Tr}) + {w}"]


@kind
def triangle(d: Draft) -> None:
    a = d.some()
    A, B = d.angle(20, 80), d.angle(20, 80)
    C = d.plant(180 - d[A] - d[B])
    d.angles.add(C)
    sines = [math.sin(math.radians(d[name])) for name in (A, B, C)]
    b, c = d.plant(d[a] * sines[1] / sines[0]), d.plant(d[a] * sines[2] / sines[0])
    d.rules += [
        f"{A} + {B} + {C} = 180",
        f"{a}/sind({A}) = {b}/sind({B})",
        f"{a}/sind({A}) = {c}/sind({C})",
    ]


@kind
def cylinder(d: Draft) -> None:
    D, L = d.some(0.01, 100), d.some(0.01, 100)
    if D == L:
        raise Unfit
    A, V = (
        d.plant(math.pi * d[D] * d[L] + math.pi * d[D] ** 2 / 2),
        d.plant(math.pi * d[D] ** 2 / 4 * d[L]),
    )
    d.rules += [f"{A} = pi*{D}*{L} + pi*{D}^2/2", f"{V} = pi*{D}^2/4*{L}"]


@kind
def beam(d: Draft) -> None:
    L, w, b, h = d.some(0.5, 50), d.some(0.1, 1e3), d.new(0.02, 2), d.new(0.05, 3)
    M = d.plant(d[w] * d[L] ** 2 / 8)
    s = d.plant(d[M] * 6 / (d[b] * d[h] ** 2))
    y = d.plant(5 * d[w] * d[L] ** 4 / (384 * 2e7 * d[b] * d[h] ** 3 / 12))
    d.rules += [
        f"{M} = {w}*{L}^2/8",
        f"{s} = 6*{M}/({b}*{h}^2)",
        f"{y} = 5*{w}*{L}^4/(384*2e7*{b}*{h}^3/12)",
    ]


def jacobian(rules: tuple[str, ...], state: dict[str, float]) -> np.ndarray:
    """Logarithmic derivatives of the rules by the variables, each row scaled to 1."""
    with mpmath.workdps(judge.DIGITS):
        rows = np.array(
            [[float(judge.slope(rule, state, name)) for name in state] for rule in rules]
        )
    return rows / np.abs(rows).max(axis=1, keepdims=True)


def random_sheet(seed: int) -> RandomSheet:
    """The sheet of a seed: one to seven relations, and exchanges of an input and an output."""
    draw = random.Random(seed)
    while True:
        draft, kinds = Draft(draw), draw.choices(list(KINDS), k=draw.randint(1, RELATIONS))
        try:
            for name in kinds:
                KINDS[name](draft)
        except (Unfit, OverflowError):
            continue
        rules = tuple(
            draw.sample(draft.rules, len(draft.rules)) if draw.random() < 0.5 else draft.rules
        )
        slopes = jacobian(rules, draft.state)
        names, unknown, exchanged = list(draft.state), set(draft.unknown), 0
        for _ in range(draw.randint(0, EXCHANGES)):
            one = unknown - {draw.choice(sorted(unknown))} | {
                draw.choice(sorted(set(names) - unknown))
            }
            if np.linalg.cond(slopes[:, [names.index(name) for name in sorted(one)]]) < CONDITION:
                unknown, exchanged = one, exchanged + 1
        if np.linalg.cond(slopes[:, [names.index(name) for name in sorted(unknown)]]) < CONDITION:
            inputs = tuple(name for name in names if name not in unknown)
            return RandomSheet(seed, rules, draft.state, inputs, tuple(kinds), exchanged)
