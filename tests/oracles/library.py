"""The models of the library, each written out explicitly from a set of parameters, at 50 digits.

``state(**parameters)`` is one consistent state of the sheet, every variable of it by name. No
parametrisation follows the sheet: each is chosen so that nothing has to be solved. Which
choices of inputs are well-posed at a state follows from the rank of its derivatives alone.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, TypeAlias

import mpmath
import numpy as np
from mpmath import mpf

import rulesheets
from tests.oracles.slider_crank import atan2d, cosd, sind

DIGITS = 50
MODELS = Path(__file__).parents[2] / "models"
State: TypeAlias = dict[str, Any]


@dataclass(frozen=True)
class Reference:
    """A model, numbers for the parameters of its states, and how many inputs that makes."""

    model: str
    parameters: Mapping[str, float]
    state: Callable[..., State]

    @property
    def exact(self) -> State:
        """The state at the parameters, which are taken as the exact numbers that they are."""
        with mpmath.workdps(DIGITS):
            return self.state(**{name: mpf(value) for name, value in self.parameters.items()})

    def derivatives(self) -> tuple[list[str], np.ndarray]:
        """(names, J) with J[i, j] = ∂ ln|variable i| / ∂ ln|parameter j|, rows scaled to length
        1."""
        base = self.exact
        with mpmath.workdps(DIGITS):
            step = mpf(10) ** (-DIGITS // 2)
            columns = []
            for name, value in self.parameters.items():
                moved = {
                    **{n: mpf(v) for n, v in self.parameters.items()},
                    name: mpf(value) * (1 + step),
                }
                after = self.state(**moved)
                columns.append([float((after[n] - base[n]) / step) for n in base])
        jacobian = np.array(columns).T
        lengths = np.linalg.norm(jacobian, axis=1, keepdims=True)
        return list(base), jacobian / np.where(lengths == 0, 1, lengths)


@dataclass(frozen=True)
class Swap:
    """A choice of inputs; the ``determinant`` of its scaled derivatives tells how well it
    determines."""

    inputs: tuple[str, ...]
    determinant: float

    @property
    def well_posed(self) -> bool:
        return self.determinant > 1e-6

    @property
    def singular(self) -> bool:
        return self.determinant < 1e-14


def swaps(reference: Reference) -> Iterator[Swap]:
    """Every choice of as many inputs as there are parameters."""
    names, jacobian = reference.derivatives()
    count = len(reference.parameters)
    for rows in combinations(range(len(names)), count):
        yield Swap(
            tuple(names[row] for row in rows), abs(float(np.linalg.det(jacobian[list(rows)])))
        )


def elsewhere(reference: Reference, draw: random.Random) -> Reference:
    """A random state of the same model: parameters off by up to a third, within the ranges of the
    sheet."""
    variables = rulesheets.load(MODELS / reference.model / "model.tk").variables
    while True:
        parameters = {
            name: value * draw.uniform(0.7, 1.3) for name, value in reference.parameters.items()
        }
        moved = Reference(reference.model, parameters, reference.state)
        state = moved.exact
        real = all(isinstance(value, mpf) for value in state.values())
        if real and all(variables[name].admits(float(value)) for name, value in state.items()):
            return moved


def cone_frustum(r1: mpf, r2: mpf, th: mpf) -> State:
    slope = sind(th / 2) / cosd(th / 2)
    s: State = {"th": th, "r1": r1, "r2": r2}
    for end, r in (("1", r1), ("2", r2)):
        height = r / slope
        slant = mpmath.hypot(r, height)
        s |= {"h" + end: height, "s" + end: slant, "AB" + end: mpmath.pi * r**2}
        s |= {"AC" + end: mpmath.pi * r * slant, "V" + end: mpmath.pi * r**2 * height / 3}
    s |= {
        "h": s["h2"] - s["h1"],
        "s": s["s2"] - s["s1"],
        "AC": s["AC2"] - s["AC1"],
        "V": s["V2"] - s["V1"],
    }
    return s | {"AT": s["AB1"] + s["AB2"] + s["AC"]}


def loan(loan: mpf, downpay: mpf, rate: mpf, term: mpf) -> State:
    payment = loan * rate / (1 - (1 + rate) ** (-term))
    sums = {"price": loan + downpay, "loan": loan, "downpay": downpay}
    return sums | {"payment": payment, "rate": rate, "term": term}


def planetary_gear(ns: mpf, nr: mpf) -> State:
    planet = (nr - ns) / 2
    ratios = {
        "pl": 1 + nr / ns,
        "st": nr / ns,
        "sl": 1 + ns / nr,
        "mx": planet / ns,
        "mi": nr / planet,
    }
    return {"ns": ns, "nr": nr, "np": planet, **ratios}


def two_stage_planetary_gear(npr: mpf, ns: mpf, nps: mpf, p: mpf, ds: mpf) -> State:
    centre = ds * (ns + nps) / (2 * ns)
    ring = 4 * p * centre - (ns + nps) + npr
    ratio = 1 + nps * ring / (ns * npr)
    return {
        "npr": npr,
        "ns": ns,
        "nps": nps,
        "p": p,
        "ds": ds,
        "C": centre,
        "nr": ring,
        "pl": ratio,
    }


def triangle(a: mpf, b: mpf, C: mpf) -> State:
    """A stands at b from C on the first axis, B at a in the direction C."""
    x, y = a * cosd(C), a * sind(C)
    A = atan2d(y, b - x)
    return {"a": a, "b": b, "c": mpmath.hypot(x - b, y), "A": A, "B": 180 - A - C, "C": C}


BRACKETS = (
    (0, 10),
    (11000, 12),
    (44725, 22),
    (95375, 24),
    (182100, 32),
    (231250, 35),
    (578125, 37),
)
"""From which income on, what per cent."""


def tax_brackets(income: mpf) -> State:
    """The integral of the marginal rate, dollar by dollar."""
    tax, rate = mpf(0), BRACKETS[0][1]
    ends = [floor for floor, _ in BRACKETS[1:]] + [mpmath.inf]
    for (floor, percent), end in zip(BRACKETS, ends, strict=True):
        if income > floor:
            tax, rate = tax + (min(income, end) - floor) * percent / 100, percent
    return {
        "income": income,
        "tax": tax,
        "net": income - tax,
        "rate": mpf(rate),
        "average": 100 * tax / income,
    }


def two_circles(x: mpf, y: mpf, x1: mpf, y1: mpf, x2: mpf, y2: mpf) -> State:
    radii = {"r1": mpmath.hypot(x - x1, y - y1), "r2": mpmath.hypot(x - x2, y - y2)}
    return {"x": x, "y": y, "x1": x1, "y1": y1, "x2": x2, "y2": y2, **radii}


def kepler(e: mpf, a: mpf, E: mpf) -> State:
    x, y = a * (cosd(E) - e), a * mpmath.sqrt(1 - e * e) * sind(E)
    mean = E - e * sind(E) * 180 / mpmath.pi
    return {"e": e, "a": a, "M": mean, "E": E, "nu": atan2d(y, x), "r": mpmath.hypot(x, y)}


def colebrook(D: mpf, k: mpf, L: mpf, nu: mpf, g: mpf, v: mpf) -> State:
    Re = v * D / nu
    wall, viscous = k / (mpf(3.7) * D), mpf(2.51) / Re
    c = 2 * viscous / mpmath.log(10)
    inverse_root = (c * mpmath.lambertw(mpmath.exp(wall / c) / c).real - wall) / viscous
    f = 1 / inverse_root**2
    lost = f * L / D * v**2 / (2 * g)
    given = {"D": D, "k": k, "L": L, "nu": nu, "g": g, "v": v}
    return {**given, "Q": v * mpmath.pi * D**2 / 4, "Re": Re, "f": f, "hf": lost}


def rachford_rice(V: mpf, x1: mpf, x2: mpf, K1: mpf, K2: mpf, K3: mpf, K4: mpf) -> State:
    """Liquid and vapour each add up to 1, which is linear in x3 and x4."""
    rest, rest_of_vapour = 1 - x1 - x2, 1 - K1 * x1 - K2 * x2
    x4 = (rest_of_vapour - K3 * rest) / (K4 - K3)
    x, K = (x1, x2, rest - x4, x4), (K1, K2, K3, K4)
    s: State = {"V": V}
    for i, (liquid, ratio) in enumerate(zip(x, K, strict=True), start=1):
        feed = V * ratio * liquid + (1 - V) * liquid
        s |= {f"K{i}": ratio, f"x{i}": liquid, f"y{i}": ratio * liquid, f"z{i}": feed}
    return s


def van_der_waals(Vm: mpf, T: mpf, a: mpf, b: mpf, R: mpf) -> State:
    P = R * T / (Vm - b) - a / Vm**2
    critical = {"Pc": a / (27 * b**2), "Tc": 8 * a / (27 * R * b), "Vc": 3 * b}
    return {"P": P, "Vm": Vm, "T": T, "Z": P * Vm / (R * T), "a": a, "b": b, "R": R, **critical}


def projectile(v0: mpf, theta: mpf, h: mpf, g: mpf) -> State:
    vx, vy = v0 * cosd(theta), v0 * sind(theta)
    t = (vy + mpmath.sqrt(vy**2 + 2 * g * h)) / g
    flight = {"vx": vx, "vy": vy, "t": t, "R": vx * t, "H": h + vy**2 / (2 * g)}
    return {"v0": v0, "theta": theta, "h": h, "g": g, **flight}


def ohms_law(I: mpf, R: mpf) -> State:  # noqa: E741
    return {"I": I, "R": R, "V": I * R, "P": I**2 * R}


def van_der_waals_volumes(P: float, T: float, a: float, b: float, R: float) -> list[mpf]:
    """Real molar volumes, ascending: roots of P V³ - (P b + R T) V² + a V - a b."""
    with mpmath.workdps(DIGITS):
        pressure, rt, pull, own = mpf(P), mpf(R) * mpf(T), mpf(a), mpf(b)
        return _real_roots([pressure, -(pressure * own + rt), pull, -pull * own])


def cubic_roots() -> list[mpf]:
    """Real roots of 3x³ - 200x² - x - 1."""
    with mpmath.workdps(DIGITS):
        return _real_roots([mpf(3), mpf(-200), mpf(-1), mpf(-1)])


def _real_roots(coefficients: Sequence[mpf]) -> list[mpf]:
    roots = mpmath.polyroots(list(coefficients), maxsteps=200, extraprec=200)
    return sorted(
        mpmath.re(root) for root in roots if abs(mpmath.im(root)) < mpf(10) ** (10 - DIGITS)
    )


REFERENCES = (
    Reference("cone_frustum", {"r1": 1.4674, "r2": 2.4, "th": 50.0}, cone_frustum),
    Reference("loan", {"loan": 12000.0, "downpay": 3500.0, "rate": 0.004, "term": 36.0}, loan),
    Reference("planetary_gear", {"ns": 17.0, "nr": 67.0}, planetary_gear),
    Reference(
        "two_stage_planetary_gear",
        {"npr": 28.0, "ns": 20.0, "nps": 69.0, "p": 1.0, "ds": 20.5},
        two_stage_planetary_gear,
    ),
    Reference("triangle", {"a": 13.0, "b": 14.0, "C": 67.0}, triangle),
    Reference("triangle", {"a": 3.0, "b": 7.0, "C": 25.0}, triangle),
    *(
        Reference("tax_brackets", {"income": income}, tax_brackets)
        for income in (5000.0, 30000.0, 60000.0, 100000.0, 200000.0, 400000.0, 1e6)
    ),
    Reference(
        "two_circles",
        {"x": 4.5, "y": -1.0, "x1": 0.5, "y1": 0.25, "x2": 6.0, "y2": 2.0},
        two_circles,
    ),
    Reference("kepler", {"e": 0.1, "a": 1.5, "E": 40.0}, kepler),
    Reference("kepler", {"e": 0.95, "a": 1.5, "E": -10.0}, kepler),
    Reference(
        "colebrook", {"D": 0.1, "k": 1e-5, "L": 100.0, "nu": 1e-6, "g": 9.81, "v": 1.25}, colebrook
    ),
    Reference(
        "rachford_rice",
        {"V": 0.25, "x1": 0.06, "x2": 0.19, "K1": 4.2, "K2": 1.75, "K3": 0.74, "K4": 0.34},
        rachford_rice,
    ),
    Reference(
        "van_der_waals",
        {"Vm": 0.366, "T": 500.0, "a": 3.592, "b": 0.04267, "R": 0.0820573661},
        van_der_waals,
    ),
    Reference("projectile", {"v0": 82.0, "theta": 27.5, "h": 12.0, "g": 9.8}, projectile),
    Reference("ohms_law", {"I": 3.0, "R": 4.0}, ohms_law),
)
