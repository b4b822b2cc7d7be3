"""The mechanisms by complex numbers, at 50 digits: closed-form positions, and their time
derivatives.

Nothing here knows of velocity or acceleration diagrams: each mechanism is drawn at a crank angle
by intersecting circles and lines in the complex plane, and the motion is that drawing
differentiated with respect to time. Angles in degrees, rates in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import mpmath
from mpmath import mpf

STEP = "1e-30"
DIGITS = 120
"""Second differences lose 60 digits to the step and keep 60."""

Numbers: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Drawing:
    """Points, directions (complex, of any length) and lengths at one instant."""

    points: Mapping[str, Any] = field(default_factory=dict)
    directions: Mapping[str, Any] = field(default_factory=dict)
    lengths: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Mechanism:
    """How to draw a mechanism from its crank angle, in each of its modes.

    ``slides`` names, for each length, its velocity and acceleration, and their sign. Modes are
    answers of one sheet, unless ``choices`` has the inputs that choose each.
    """

    model: str
    lengths: Mapping[str, float]
    crank: str
    draw: Callable[[Any, Numbers, int], Drawing]
    modes: tuple[int, ...] = (1,)
    slides: Mapping[str, tuple[str, str, int]] = field(default_factory=dict)
    choices: Mapping[int, Mapping[str, float]] = field(default_factory=dict)

    def inputs(self, mode: int) -> dict[str, float]:
        """The lengths and directions of the sheet in that mode."""
        return {**self.lengths, **self.choices.get(mode, {})}

    def coordinate(self, theta: float, name: str, mode: int) -> float:
        """One angle (degrees) or length at a crank angle."""
        with mpmath.workdps(20):
            numbers = {length: mpf(value) for length, value in self.inputs(mode).items()}
            now = self.draw(mpf(theta), numbers, mode)
            if name.startswith("theta"):
                return float(
                    mpmath.arg(now.directions[name.removeprefix("theta")]) * 180 / mpmath.pi
                )
            return float(now.lengths[name])

    def state(self, theta: float, omega: float, alpha: float, mode: int) -> dict[str, mpf]:
        """Every position, velocity and acceleration of the model by name, driver and lengths
        included."""
        with mpmath.workdps(DIGITS):
            numbers = {name: mpf(value) for name, value in self.inputs(mode).items()}
            h = mpf(STEP)
            now, before, after = (
                self.draw(theta + (omega * t + alpha * t * t / 2) * 180 / mpmath.pi, numbers, mode)
                for t in (mpf(0), -h, h)
            )
            found = {f"theta{self.crank}": mpf(theta), f"omega{self.crank}": mpf(omega)}
            found |= {**numbers, f"alpha{self.crank}": mpf(alpha)}
            for name in now.directions:
                turned = (
                    mpmath.arg(d.directions[name] / now.directions[name]) for d in (before, after)
                )
                rate, second = _differences(mpf(0), *turned)
                angle = mpmath.arg(now.directions[name]) * 180 / mpmath.pi
                found |= {f"theta{name}": angle, f"omega{name}": rate, f"alpha{name}": second}
            for name, (velocity, acceleration, sign) in self.slides.items():
                rate, second = _differences(*(d.lengths[name] for d in (now, before, after)))
                found |= {
                    name: now.lengths[name],
                    velocity: sign * rate,
                    acceleration: sign * second,
                }
            for name in now.points:
                rate, second = _differences(*(d.points[name] for d in (now, before, after)))
                small = name.lower()
                found |= {f"x{name}": now.points[name].real, f"y{name}": now.points[name].imag}
                found |= {f"x{small}": rate.real, f"y{small}": rate.imag}
                found |= {f"x{small}1": second.real, f"y{small}1": second.imag}
            return found


def _differences(now: Any, before: Any, after: Any) -> tuple[Any, Any]:
    h = mpf(STEP)
    return (after - before) / (2 * h), (after - 2 * now + before) / (h * h)


def _unit(degrees: Any) -> Any:
    return mpmath.expjpi(mpf(degrees) / 180)


def _meet(A: Any, a: Any, B: Any, b: Any, mode: int) -> Any:
    """The point at the distance a from A and b from B, to the left (mode 1) or right (-1) of AB."""
    d = B - A
    distance = abs(d)
    along = (a * a + distance * distance - b * b) / (2 * distance)
    return A + d / distance * mpmath.mpc(along, mode * mpmath.sqrt(a * a - along * along))


def closes(mechanism: Mechanism, theta: float, mode: int) -> bool:
    """Whether the links meet at that crank angle."""
    with mpmath.workdps(DIGITS):
        numbers = {name: mpf(value) for name, value in mechanism.inputs(mode).items()}
        try:
            mechanism.draw(mpf(theta), numbers, mode)
        except (ValueError, TypeError):
            return False
        return True


def four_link_chain(theta: Any, v: Numbers, mode: int) -> Drawing:
    Q, S = v["PQ"] * _unit(theta), mpmath.mpc(v["PS"])
    R = _meet(Q, v["QR"], S, v["RS"], mode)
    M = Q + (R - Q) * v["QM"] / v["QR"]
    return Drawing({"M": M}, {"QR": R - Q, "SR": R - S})


def rigid_link_chain(theta: Any, v: Numbers, mode: int) -> Drawing:
    U, S = v["RU"] * _unit(theta), mpmath.mpc(v["RS"])
    T = _meet(U, v["UT"], S, v["ST"], mode)
    W = U + (T - U) / v["UT"] * mpmath.mpc(v["UWx"], v["UWy"])
    return Drawing({"W": W}, {"UT": T - U, "ST": T - S})


def _piston(B: Any, rod: Any, along: Any) -> Any:
    """Distance from the origin of the piston on the half-line ``along`` at the end of a rod from
    B."""
    local = B / along
    return local.real + mpmath.sqrt(rod * rod - local.imag**2)


def piston_engine(theta: Any, v: Numbers, mode: int) -> Drawing:
    B = v["OB"] * _unit(theta)
    along = _unit(v["phi"])
    s = _piston(B, v["BP"], along)
    return Drawing({}, {"BP": s * along - B}, {"sP": s})


def two_cylinder_engine(theta: Any, v: Numbers, mode: int) -> Drawing:
    B, E = v["OB"] * _unit(theta), v["OE"] * _unit(theta + v["BOE"])
    to_c, to_f = _unit(v["phiC"]), _unit(v["phiF"])
    C, F = _piston(B, v["BC"], to_c), _piston(E, v["EF"], to_f)
    return Drawing({}, {"BC": C * to_c - B, "EF": F * to_f - E}, {"sC": C, "sF": F})


def slotted_link(theta: Any, v: Numbers, mode: int) -> Drawing:
    C = mpmath.mpc(0, -v["OC"])
    to_slider = v["OB"] * _unit(theta) - C
    along = to_slider / abs(to_slider)
    return Drawing({"D": C + v["CD"] * along}, {"CD": along}, {"CS": abs(to_slider)})


def slider_outside_link(theta: Any, v: Numbers, mode: int) -> Drawing:
    to_slider = v["OB"] * _unit(theta) - mpmath.mpc(0, -v["OC"])
    r = mpmath.sqrt(abs(to_slider) ** 2 - v["gap"] ** 2)
    return Drawing({}, {"CD": to_slider / mpmath.mpc(r, v["gap"])}, {"CS": r})


def whitworth_quick_return(theta: Any, v: Numbers, mode: int) -> Drawing:
    to_slider = v["OB"] * _unit(theta) - mpmath.mpc(0, -v["OC"])
    arm = v["CD"] * to_slider / abs(to_slider)
    along = _unit(v["phi"])
    ram = _piston(arm, v["DE"], along)
    return Drawing({}, {"CD": arm, "DE": ram * along - arm}, {"CS": abs(to_slider), "sE": ram})


def trunnion(theta: Any, v: Numbers, mode: int) -> Drawing:
    C = v["BC"] * _unit(theta)
    rod = v["BE"] - C
    D = C + v["CD"] * rod / abs(rod)
    return Drawing({"D": D}, {"CD": rod}, {"SC": abs(rod)})


def rod_through_trunnion(theta: Any, v: Numbers, mode: int) -> Drawing:
    B = v["OB"] * _unit(theta)
    along, rod = _unit(v["phi"]), mpmath.mpc(v["xD"], v["yD"]) - B
    piston = _piston(B, v["BC"], along)
    return Drawing({}, {"BC": piston * along - B, "BF": rod}, {"sC": piston, "BE": abs(rod)})


def oscillating_cylinder(theta: Any, v: Numbers, mode: int) -> Drawing:
    rod = v["BC"] - v["BO"] * _unit(theta)
    return Drawing({}, {"OC": rod}, {"OC": abs(rod)})


BOTH = (1, -1)

MECHANISMS = (
    Mechanism(
        "four_link_chain",
        {"PQ": 0.2, "QR": 0.5, "RS": 0.4, "PS": 0.5, "QM": 0.2},
        "PQ",
        four_link_chain,
        BOTH,
    ),
    Mechanism(
        "rigid_link_chain",
        {"RU": 0.15, "UT": 0.4, "ST": 0.3, "RS": 0.45, "UWx": 0.2, "UWy": 0.25},
        "RU",
        rigid_link_chain,
        BOTH,
    ),
    Mechanism(
        "piston_engine",
        {"OB": 0.05, "BP": 0.2, "phi": 0.0},
        "OB",
        piston_engine,
        BOTH,
        {"sP": ("vP", "aP", 1)},
        {1: {"phi": 0.0}, -1: {"phi": 180.0}},
    ),
    Mechanism(
        "two_cylinder_engine",
        {"OB": 0.1, "BC": 0.35, "phiC": 180.0, "OE": 0.1, "EF": 0.35, "phiF": 90.0, "BOE": 90.0},
        "OB",
        two_cylinder_engine,
        BOTH,
        {"sC": ("vC", "aC", 1), "sF": ("vF", "aF", 1)},
        {1: {"phiC": 180.0, "phiF": 90.0}, -1: {"phiC": 0.0, "phiF": -90.0}},
    ),
    Mechanism(
        "slotted_link",
        {"OB": 0.2, "OC": 0.4, "CD": 0.8},
        "OB",
        slotted_link,
        slides={"CS": ("vSlide", "aSlide", 1)},
    ),
    Mechanism(
        "slider_outside_link",
        {"OB": 0.2, "OC": 0.4, "gap": 0.05},
        "OB",
        slider_outside_link,
        BOTH,
        {"CS": ("vSlide", "aSlide", 1)},
        {1: {"gap": 0.05}, -1: {"gap": -0.05}},
    ),
    Mechanism(
        "whitworth_quick_return",
        {"OB": 0.2, "OC": 0.1, "CD": 0.15, "DE": 0.5, "phi": 0.0},
        "OB",
        whitworth_quick_return,
        BOTH,
        {"CS": ("vSlide", "aSlide", 1), "sE": ("vE", "aE", 1)},
        {1: {"phi": 0.0}, -1: {"phi": 180.0}},
    ),
    Mechanism(
        "trunnion",
        {"BC": 0.04, "BE": 0.1, "CD": 0.15},
        "BC",
        trunnion,
        slides={"SC": ("vSlide", "aSlide", -1)},
    ),
    Mechanism(
        "rod_through_trunnion",
        {"OB": 0.1, "BC": 0.3, "phi": 0.0, "xD": -0.2, "yD": 0.15},
        "OB",
        rod_through_trunnion,
        BOTH,
        {"sC": ("vC", "aC", 1), "BE": ("vSlide", "aSlide", -1)},
        {1: {"phi": 0.0}, -1: {"phi": 180.0}},
    ),
    Mechanism(
        "oscillating_cylinder",
        {"BO": 0.05, "BC": 0.2},
        "BO",
        oscillating_cylinder,
        slides={"OC": ("vSlide", "aSlide", -1)},
    ),
)
"""With the lengths of the shipped sheets."""
