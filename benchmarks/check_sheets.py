"""Everyday sheets with a planted state, often close to where a rule is 0/0.

Each family is a handful of rules as an engineer writes them, with a recipe for a state: sizes from
1e-3 to 1e6, and at times two numbers so close that a quotient has a removable singularity next to
them. Which variables are given is drawn, too, so that most sheets are solved backward.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any, TypeAlias

from benchmarks.digits import condition, newton

State: TypeAlias = "dict[str, float]"
CLEAR = 1e6
"""Condition of the Jacobian up to which a planted state is well determined."""


@dataclass(frozen=True)
class Family:
    """``rules`` hold at the state that ``plant`` draws; it names some variables, the rules give the
    others in their order. ``given``: whole numbers, which are no unknowns."""

    name: str
    rules: tuple[str, ...]
    plant: Callable[[Random], State]
    given: tuple[str, ...] = ()


@dataclass(frozen=True)
class EverydaySheet:
    """``planted``: the state, exact for the rounded ``inputs`` to fifty digits."""

    family: str
    rules: tuple[str, ...]
    inputs: Mapping[str, float]
    planted: Mapping[str, Any]
    unknowns: tuple[str, ...]

    @property
    def text(self) -> str:
        return "\n".join([*self.rules, ""])


def size(random: Random, low: float = 1e-2, high: float = 1e4) -> float:
    """A positive number of few digits, any size alike."""
    number = math.exp(random.uniform(math.log(low), math.log(high)))
    return float(f"{number:.{random.choice((1, 2, 3, 5, 9))}g}")


def close(random: Random, number: float) -> float:
    """A number that is another one, or at times all but it."""
    if random.random() < 0.5:
        return number * random.uniform(1.1, 4.0) ** random.choice((-1, 1))
    return number * (1.0 + random.choice((-1, 1)) * 10.0 ** -random.uniform(1, 9))


def _polytropic(random: Random) -> State:
    g = random.choice((close(random, 1.0), random.choice((1.1, 1.2, 1.3, 1.4, 1.667))))
    return {
        "p1": size(random, 1.0, 1e3),
        "V1": size(random, 1e-2, 10.0),
        "r": random.uniform(1.5, 20.0),
        "g": g,
    }


def _exchanger(random: Random) -> State:
    tin, dt2 = random.uniform(5, 40), random.uniform(3, 60)
    return {
        "Tci": tin,
        "dT2": dt2,
        "dT1": close(random, dt2),
        "U": size(random, 0.1, 5),
        "A": size(random, 0.1, 200),
        "Tco": tin + random.uniform(5, 60),
    }


def _loan(random: Random) -> State:
    rate = random.choice((10.0 ** -random.uniform(1.5, 9), random.uniform(0.001, 0.1)))
    return {"P": size(random, 100, 1e6), "rate": rate, "n": float(random.randint(2, 360))}


def _savings(random: Random) -> State:
    return {
        "deposit": size(random, 1, 1e4),
        "q": 1.0 + 10.0 ** -random.uniform(1, 9),
        "n": float(random.randint(2, 60)),
    }


def _parallel(random: Random) -> State:
    return {name: size(random, 1, 1e5) for name in ("R1", "R2", "R3")} | {"U": size(random, 1, 400)}


def _bridge(random: Random) -> State:
    state = {name: size(random, 1, 1e4) for name in ("R1", "R2", "R3", "R5")} | {
        "U": size(random, 1, 100)
    }
    state["R4"] = close(random, state["R3"] * state["R2"] / state["R1"])
    return state


def _triangle(random: Random) -> State:
    A = random.uniform(5, 100)
    return {"R": size(random, 1e-2, 1e4), "A": A, "B": random.uniform(5, 170 - A)}


def _motion(random: Random) -> State:
    return {
        "u": size(random, 0.1, 100),
        "acc": random.choice((-1, 1)) * size(random, 1e-6, 20),
        "t": size(random, 0.1, 100),
    }


def _pipe(random: Random) -> State:
    r1 = size(random, 1e-2, 1.0)
    return {
        "r1": r1,
        "r2": max(r1, close(random, r1)) * 1.0000001,
        "k": size(random, 0.02, 400),
        "L": size(random, 0.1, 100),
        "dT": random.uniform(1, 200),
    }


def _lens(random: Random) -> State:
    f = size(random, 1e-2, 1)
    return {"f": f, "u": close(random, f)}


def _effectiveness(random: Random) -> State:
    return {
        "N": random.uniform(0.1, 6),
        "C": min(close(random, 1.0), 3.0),
        "Q": size(random, 1, 1e5),
    }


def _decay(random: Random) -> State:
    return {"k": size(random, 1e-9, 2), "t": size(random, 0.1, 10), "c0": size(random, 1e-3, 1e3)}


def _impact(random: Random) -> State:
    u1 = size(random, 0.1, 50)
    return {
        "m1": size(random, 0.1, 100),
        "m2": size(random, 0.1, 100),
        "u1": u1,
        "u2": -close(random, u1),
        "e": random.uniform(0.05, 0.95),
    }


def _arc(random: Random) -> State:
    return {
        "rad": size(random, 0.1, 1e3),
        "th": random.choice((random.uniform(0.2, 2.8), 10.0 ** -random.uniform(1, 4))),
    }


def _mixing(random: Random) -> State:
    T1 = random.uniform(10, 90)
    return {
        "m1": size(random, 0.01, 100),
        "m2": size(random, 0.01, 100),
        "T1": T1,
        "T2": close(random, T1),
        "c": size(random, 0.5, 5),
    }


FAMILIES = (
    Family(
        "polytropic",
        (
            "V2 = V1/r",
            "p1*V1^g = p2*V2^g",
            "work = (p2*V2 - p1*V1)/(g - 1)",
        ),
        _polytropic,
    ),
    Family(
        "exchanger",
        (
            "LM = (dT1 - dT2)/ln(dT1/dT2)",
            "Q = U*A*LM",
            "Thi = dT1 + Tco",
            "Tho = dT2 + Tci",
            "mh = Q/(Thi - Tho)",
            "mc = Q/(Tco - Tci)",
        ),
        _exchanger,
    ),
    Family(
        "loan",
        (
            "pay = P*rate/(1 - (1 + rate)^(-n))",
            "total = n*pay",
            "interest = total - P",
        ),
        _loan,
        ("n",),
    ),
    Family(
        "savings",
        (
            "S = deposit*(q^n - 1)/(q - 1)",
            "gain = S - n*deposit",
        ),
        _savings,
        ("n",),
    ),
    Family(
        "parallel",
        (
            "R12 = R1*R2/(R1 + R2)",
            "R = R12 + R3",
            "I = U/R",
            "U12 = I*R12",
            "I1 = U12/R1",
            "I2 = U12/R2",
        ),
        _parallel,
    ),
    Family(
        "bridge",
        (
            "I1 = (U - Ua)/R1",
            "I2 = Ua/R2",
            "I3 = (U - Ub)/R3",
            "I4 = Ub/R4",
            "I5 = (Ua - Ub)/R5",
            "I1 = I2 + I5",
            "I4 = I3 + I5",
            "Rtot = U/(I1 + I3)",
        ),
        _bridge,
    ),
    Family(
        "triangle",
        (
            "C = 180 - A - B",
            "a = 2*R*sind(A)",
            "b/sind(B) = 2*R",
            "c/sind(C) = 2*R",
            "area = a*b*c/(4*R)",
        ),
        _triangle,
    ),
    Family(
        "sides",
        (
            "C = 180 - A - B",
            "a/sind(A) = 2*R",
            "b/sind(B) = 2*R",
            "c^2 = a^2 + b^2 - 2*a*b*cosd(C)",
        ),
        _triangle,
    ),
    Family(
        "motion",
        (
            "v = u + acc*t",
            "s = (v^2 - u^2)/(2*acc)",
            "mean = s/t",
        ),
        _motion,
    ),
    Family(
        "pipe",
        (
            "Q = 2*pi*k*L*dT/ln(r2/r1)",
            "wall = r2 - r1",
            "Am = 2*pi*L*(r2 - r1)/ln(r2/r1)",
            "flux = Q/Am",
        ),
        _pipe,
    ),
    Family(
        "lens",
        (
            "1/f = 1/u + 1/v",
            "m = v/u",
        ),
        _lens,
    ),
    Family(
        "effectiveness",
        (
            "eps = (1 - exp(-N*(1 - C)))/(1 - C*exp(-N*(1 - C)))",
            "q = eps*Q",
        ),
        _effectiveness,
    ),
    Family(
        "decay",
        (
            "mean = c0*(1 - exp(-k*t))/(k*t)",
            "c = c0*exp(-k*t)",
        ),
        _decay,
    ),
    Family(
        "impact",
        (
            "m1*u1 + m2*u2 = m1*v1 + m2*v2",
            "e = (v2 - v1)/(u1 - u2)",
            "loss = m1*(u1^2 - v1^2)/2 + m2*(u2^2 - v2^2)/2",
        ),
        _impact,
    ),
    Family(
        "arc",
        (
            "s = rad*th",
            "chord = 2*rad*sin(th/2)",
            "ratio = chord/s",
            "sag = rad*(1 - cos(th/2))",
        ),
        _arc,
    ),
    Family(
        "mixing",
        (
            "T = (m1*T1 + m2*T2)/(m1 + m2)",
            "x = (T - T1)/(T2 - T1)",
            "Q = m1*c*(T - T1)",
        ),
        _mixing,
    ),
)


STARTS = (1.0, 1e-3, 1e3, 1e-6)


def everyday(seed: int) -> EverydaySheet | None:
    """The sheet of a seed; None where what was drawn does not determine its planted state well."""
    random = Random(seed)
    family = random.choice(FAMILIES)
    drawn = family.plant(random)
    names = list(dict.fromkeys(word for rule in family.rules for word in variables(rule)))
    open_ = [name for name in names if name not in drawn]
    states = (
        newton(family.rules, {**dict.fromkeys(open_, start), **drawn}, open_) for start in STARTS
    )
    state = next((state for state in states if state is not None), None)
    if state is None:
        return None
    others = [name for name in names if name not in family.given]
    inputs = (*family.given, *random.sample(others, len(others) - len(family.rules)))
    unknowns = tuple(name for name in names if name not in inputs)
    given = {name: rounded(random, float(state[name])) for name in inputs}
    planted = newton(family.rules, {**state, **given}, unknowns)
    if planted is None or not condition(family.rules, planted, unknowns) < CLEAR:
        return None
    rules = random.sample(family.rules, len(family.rules))
    return EverydaySheet(family.name, tuple(rules), given, planted, unknowns)


def rounded(random: Random, number: float) -> float:
    """A number as it was computed, or as it is typed in."""
    return number if random.random() < 0.5 else float(f"{number:.{random.choice((6, 9, 12))}g}")


def variables(rule: str) -> list[str]:
    """The names in a rule, functions and constants left out."""
    words = re.findall(r"[A-Za-z]\w*\(?", rule)
    return [word for word in words if not word.endswith("(") and word != "pi"]
