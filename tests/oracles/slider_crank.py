"""The offset slider crank in closed form, at 50 digits.

Derived from the vector loop O → A → B, not from the printed rules: with the unit vectors of the
plane, the rod r = B - A turns at omegaAB, so that velocity(B) = velocity(A) + omegaAB × r and
acceleration(B) = acceleration(A) + alphaAB × r - omegaAB² r; B stays on y = offset, which gives
omegaAB and alphaAB. Lengths in the unit of the inputs, angles in degrees, rates in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass
from typing import Any

import mpmath
import numpy as np

DIGITS = 50

LOCALS = {
    "position": ("yB", "yA", "m1"),
    "velocity": ("vA", "xa", "ya", "yb", "xb", "vAB"),
    "acceleration": (
        *("aAt", "aAn", "aBAn", "yb1", "xa11", "ya11", "xa1", "ya1", "xb11", "yb11", "xb1", "aBAt"),
    ),
}
"""Which subsheet each local quantity belongs to."""

SHARED = ("xA", "xB", "thetaAB", "m2", "vB", "omegaAB", "aB", "alphaAB")
"""Quantities that the calling sheet sees."""


@dataclass(frozen=True)
class Crank:
    """The numbers that drive the linkage; every float is taken as the exact number it is."""

    AO: float
    AB: float
    offset: float
    omegaAO: float
    alphaAO: float
    thetaAO: float
    open: bool = True

    @property
    def inputs(self) -> dict[str, float]:
        """The numeric inputs by name."""
        names = ("AO", "AB", "offset", "omegaAO", "alphaAO", "thetaAO")
        return dict(zip(names, astuple(self)[:6], strict=True))


def _tidy(value: mpmath.mpf) -> mpmath.mpf:
    """Snap to ±1/2 and ±1, which are the only rational values of sind and cosd besides 0
    (Niven)."""
    doubled = 2 * value
    near = mpmath.nint(doubled)
    return near / 2 if near != 0 and abs(doubled - near) < mpmath.mpf(10) ** (5 - DIGITS) else value


def sind(degrees: Any) -> mpmath.mpf:
    """Sine of an angle in degrees, exact where it is rational."""
    return _tidy(mpmath.sinpi(mpmath.fmod(degrees, 360) / 180))


def cosd(degrees: Any) -> mpmath.mpf:
    """Cosine of an angle in degrees, exact where it is rational."""
    return _tidy(mpmath.cospi(mpmath.fmod(degrees, 360) / 180))


def atan2d(y: Any, x: Any) -> mpmath.mpf:
    """Direction of (x, y) in degrees, in (-180, 180]."""
    return mpmath.atan2(y, x) * 180 / mpmath.pi


def _quantities(
    v: Mapping[str, Any],
    sine: Any,
    cosine: Any,
    side: float,
    sqrt: Callable[[Any], Any],
    direction: Callable[[Any, Any], Any],
    magnitude: Callable[[Any], Any],
) -> dict[str, Any]:
    """Every quantity of the three diagrams but the slopes, in whatever arithmetic is handed in."""
    q: dict[str, Any] = {"yB": v["offset"], "xA": v["AO"] * cosine, "yA": v["AO"] * sine}
    dy = q["yB"] - q["yA"]
    dx = side * sqrt((v["AB"] - dy) * (v["AB"] + dy))
    q |= {"xB": q["xA"] + dx, "thetaAB": direction(-dy, -dx), "vA": v["omegaAO"] * v["AO"]}
    q |= {"xa": -q["vA"] * sine, "ya": q["vA"] * cosine, "yb": 0 * dy}
    q["omegaAB"] = -q["ya"] / dx
    q["xb"] = q["vB"] = q["xa"] - q["omegaAB"] * dy
    q["vAB"] = magnitude(q["omegaAB"]) * v["AB"]
    q |= {"aAt": v["alphaAO"] * v["AO"], "aAn": v["omegaAO"] ** 2 * v["AO"], "yb1": 0 * dy}
    q |= {"aBAn": q["omegaAB"] ** 2 * v["AB"], "xa11": -q["aAn"] * cosine, "ya11": -q["aAn"] * sine}
    q |= {"xa1": q["xa11"] - q["aAt"] * sine, "ya1": q["ya11"] + q["aAt"] * cosine}
    q |= {"xb11": q["xa1"] - q["omegaAB"] ** 2 * dx, "yb11": q["ya1"] - q["omegaAB"] ** 2 * dy}
    q["alphaAB"] = -q["yb11"] / dx
    q["xb1"] = q["aB"] = q["xb11"] - q["alphaAB"] * dy
    q["aBAt"] = magnitude(q["alphaAB"]) * v["AB"]
    return q


def rise(crank: Crank) -> mpmath.mpf:
    """Height of B over A, yB - yA: the linkage closes where it is within ±AB."""
    with mpmath.workdps(DIGITS):
        return mpmath.mpf(crank.offset) - mpmath.mpf(crank.AO) * sind(mpmath.mpf(crank.thetaAO))


def forward(crank: Crank) -> dict[str, mpmath.mpf]:
    """Every quantity by its bare name; ``m1`` and ``m2`` are absent where they do not exist.

    The linkage must close, with the link AB not vertical: ``abs(rise(crank)) < AB``.
    """
    with mpmath.workdps(DIGITS):
        v = {name: mpmath.mpf(number) for name, number in crank.inputs.items()}
        side = 1 if crank.open else -1
        q = _quantities(v, sind(v["thetaAO"]), cosd(v["thetaAO"]), side, mpmath.sqrt, atan2d, abs)
        q["m1"] = (q["yA"] - q["yB"]) / (q["xA"] - q["xB"])
        if q["m1"] != 0:
            q["m2"] = -1 / q["m1"]
        return q


def sensitivity(crank: Crank) -> dict[str, float]:
    """Σ |∂q/∂p · p| over the inputs p: what a relative rounding of every input by 1 does to q.

    By complex steps (Squire & Trapp, SIAM Review 40 (1998) 110–112), so without cancellation.
    """
    names = list(crank.inputs)
    values = np.array([crank.inputs[name] for name in names])
    step = 1e-30
    points = values + 1j * step * np.diag(values)
    v = {name: points[:, k] for k, name in enumerate(names)}
    angle = v["thetaAO"] * (np.pi / 180)
    side = 1.0 if crank.open else -1.0
    q = _quantities(
        v, np.sin(angle), np.cos(angle), side, np.sqrt, _complex_direction, _complex_magnitude
    )
    slope = (q["yA"] - q["yB"]) / (q["xA"] - q["xB"])
    q["m1"] = slope
    if slope[0].real != 0:
        q["m2"] = -1 / slope
    return {name: float(np.sum(np.abs(np.imag(value)) / step)) for name, value in q.items()}


def _complex_direction(y: Any, x: Any) -> Any:
    turn = (y.imag * x.real - x.imag * y.real) / (x.real**2 + y.real**2)
    return np.rad2deg(np.arctan2(y.real, x.real)) + 1j * np.rad2deg(turn)


def _complex_magnitude(z: Any) -> Any:
    return np.where(z.real < 0, -z, z)


def crank_angles(AO: float, AB: float, offset: float, xB: float) -> list[mpmath.mpf]:
    """Crank angles that put the slider at xB, in (-180, 180], ascending; none where it is out of
    reach.

    B is at the distance D from O in the direction psi; the law of cosines in the triangle O A B
    gives the angle between OA and OB. At the ends of the reach the two angles are one.
    """
    with mpmath.workdps(DIGITS):
        a, b, x, y = (mpmath.mpf(number) for number in (AO, AB, xB, offset))
        cosine = (a**2 + x**2 + y**2 - b**2) / (2 * a * mpmath.hypot(x, y))
        if abs(cosine) > 1:
            return []
        spread = mpmath.acos(cosine) * 180 / mpmath.pi
        psi = atan2d(y, x)
        return sorted({_principal(psi - spread), _principal(psi + spread)})


def driven_by(quantity: str, value: float, crank: Crank, name: str, numbers: Any) -> list[float]:
    """The values of the input ``name``, between neighbours of the ascending ``numbers`` (n,), at
    which a quantity of the linkage has this value; poles left out.

    Changes of sign of the closed form in floats, halved until they are apart by rounding alone.
    """

    def miss(x: Any) -> Any:
        v = {key: np.full_like(x, number) for key, number in crank.inputs.items()} | {name: x}
        angle, side = np.radians(v["thetaAO"]), 1.0 if crank.open else -1.0
        with np.errstate(all="ignore"):
            q = _quantities(v, np.sin(angle), np.cos(angle), side, np.sqrt, np.arctan2, np.abs)
        return q[quantity] - value

    at = miss(numbers)
    places = np.flatnonzero(at[:-1] * at[1:] < 0.0)
    low, high = numbers[places], numbers[places + 1]
    for _ in range(80):
        middle = 0.5 * (low + high)
        left = miss(low) * miss(middle) <= 0.0
        low, high = np.where(left, low, middle), np.where(left, middle, high)
    return list(low[abs(miss(low)) < 1e-6 * abs(value)])


def _principal(degrees: mpmath.mpf) -> mpmath.mpf:
    return 180 - mpmath.fmod(180 - degrees, 360) if degrees <= 180 else degrees - 360


def is_open(AO: float, xB: float, thetaAO: mpmath.mpf) -> bool:
    """Whether B lies to the right of A."""
    with mpmath.workdps(DIGITS):
        return bool(mpmath.mpf(xB) > mpmath.mpf(AO) * cosd(thetaAO))


def crank_rates(
    AO: float, offset: float, xB: float, thetaAO: mpmath.mpf, vB: float, aB: float
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """(omegaAO, alphaAO) that give the slider the velocity vB and the acceleration aB there.

    vB = K omegaAO and aB = K alphaAO + L omegaAO², K and L from the geometry alone; K is 0 at dead
    centre.
    """
    with mpmath.workdps(DIGITS):
        sine, cosine, a = sind(thetaAO), cosd(thetaAO), mpmath.mpf(AO)
        dx, dy = mpmath.mpf(xB) - a * cosine, mpmath.mpf(offset) - a * sine
        gain = a * (cosine * dy / dx - sine)
        rod = a * cosine / dx
        normal = -a * cosine - a * sine * dy / dx - rod**2 * (dx + dy * dy / dx)
        omega = mpmath.mpf(vB) / gain
        return omega, (mpmath.mpf(aB) - normal * omega**2) / gain
