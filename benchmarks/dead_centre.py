"""The slider crank driven by its slider, ever nearer to the end of its stroke, against other
solvers.

    python benchmarks/dead_centre.py [-o PICTURE.png] [--offset 2]

puts the slider at a relative distance of 1e-1 … 1e-15 from dead centre and asks for the crank's
angle, the rod's angle and velocity, and the slider's velocity. The position is a float, so the
answer exists to any number of digits; in floats the equations lose half of theirs. Printed is the
worst relative error of the four (nearest of the two modes, against 50 digits), or the word for what
was said instead of an answer.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import mpmath

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
import solver
from benchmarks.peers import End, Equations, Solve, absent, peers, run
from rulesheets.model import Model
from tests.oracles.slider_crank import Crank, crank_angles, forward

AO, AB, OMEGA = 3.0, 8.0, -15.0
WANTED = ("thetaAO", "thetaAB", "omegaAB", "vB")
DISTANCES = tuple(10.0**-k for k in range(1, 16))
TURN = 360.0


@cache
def model() -> Model:
    folder = Path(__file__).parent.parent / "models" / "offset_slider_crank"
    return rulesheets.load(folder / "model.tk")


def position(offset: float, distance: float) -> float:
    """Of the slider, as a float; the end of the stroke is at √((AO + AB)² - offset²)."""
    return math.sqrt((AO + AB) ** 2 - offset**2) * (1.0 - distance)


def truth(offset: float, x: float) -> list[dict[str, Any]]:
    """Both modes at the position x, which is taken as the exact number that it is."""
    modes = []
    for angle in crank_angles(AO, AB, offset, x):
        state = forward(Crank(AO, AB, offset, OMEGA, 0.0, angle))  # type: ignore[arg-type]
        modes.append({"thetaAO": angle, **{name: state[name] for name in WANTED[1:]}})
    return modes


def loop(offset: float, x: float) -> Equations:
    """The vector loop and its velocities: crank angle, rod angle (radians), rod velocity, slider
    velocity."""

    def residuals(v: Sequence[Any], m: Any) -> list[Any]:
        crank, rod, omega, speed = v
        return [
            AO * m.cos(crank) + AB * m.cos(rod) - x,
            AO * m.sin(crank) + AB * m.sin(rod) - offset,
            -AO * OMEGA * m.sin(crank) - AB * omega * m.sin(rod) - speed,
            AO * OMEGA * m.cos(crank) + AB * omega * m.cos(rod),
        ]

    return Equations(residuals, 4)


def ours(offset: float, x: float) -> Solve:
    def solve(_: Equations, start: Sequence[float]) -> tuple[bool, Sequence[float] | None]:
        inputs = {"thetaAO": None, "xB": x, "offset": offset, "omegaAO": OMEGA}
        result = solver.solve(model(), inputs, want=WANTED)
        if str(result.status) != "solved":
            raise ValueError(str(result.status))
        return True, [float(str(result.solutions[0][name])) for name in WANTED]

    return solve


def error(found: Mapping[str, float], modes: Sequence[Mapping[str, Any]]) -> float:
    """The worst relative error, against the mode to which it is least; angles to whole turns."""
    return min(max(_relative(name, found[name], mode[name]) for name in WANTED) for mode in modes)


def _relative(name: str, found: float, exact: Any) -> float:
    with mpmath.workdps(50):
        miss = mpmath.mpf(found) - exact
        if name.startswith("theta"):
            miss -= TURN * mpmath.nint(miss / TURN)
        return float(abs(miss / exact)) if exact else float(abs(miss))


def measure(offset: float) -> dict[str, list[tuple[str, float, float]]]:
    """By solver: (what it said, error, seconds) at each distance."""
    others = peers()
    found: dict[str, list[tuple[str, float, float]]] = {name: [] for name in ("backsolve", *others)}
    model()
    for distance in DISTANCES:
        x = position(offset, distance)
        modes, equations = truth(offset, x), loop(offset, x)
        for name in found:
            solve = ours(offset, x) if name == "backsolve" else others[name]
            found[name].append(_mark(name, run(solve, equations, (0.5, 0.1, 1.0, 1.0)), modes))
    return found


def _mark(name: str, end: End, modes: Sequence[Mapping[str, Any]]) -> tuple[str, float, float]:
    if end.x is None or not end.success:
        said = (
            end.said.rpartition(": ")[2]
            if name == "backsolve"
            else "raises"
            if end.said
            else "fails"
        )
        return said, math.nan, end.seconds
    x = list(end.x)
    if (
        name != "backsolve"
    ):  # radians, and the rod's angle from A to B where the sheet has it from B to A
        x[:2] = math.degrees(x[0]), math.degrees(x[1]) + 180.0
    return "", error(dict(zip(WANTED, x, strict=True)), modes), end.seconds


def table(found: Mapping[str, Sequence[tuple[str, float, float]]]) -> str:
    lines = [f"{'distance':<12}" + "".join(f"{name:>21}" for name in found)]
    for place, distance in enumerate(DISTANCES):
        cells = (marks[place] for marks in found.values())
        lines.append(
            f"{distance:<12.0e}" + "".join(f"{said or f'{e:.0e}':>21}" for said, e, _ in cells)
        )
    times = (
        sorted(seconds for _, _, seconds in marks)[len(marks) // 2] for marks in found.values()
    )
    lines.append(f"{'median ms':<12}" + "".join(f"{1e3 * t:>21.2f}" for t in times))
    return "\n".join(lines)


def picture(path: str, found: Mapping[str, Sequence[tuple[str, float, float]]]) -> None:
    from solver.pictures import FALSE, Measurement
    from solver.pictures.plot import chart_picture

    marks = []
    for name, row in found.items():
        for distance, (said, wrong, seconds) in zip(DISTANCES, row, strict=True):
            status = said or ("solved" if wrong <= FALSE else "false")
            marks.append(Measurement(name, None, distance, status, wrong, None, seconds))
    label = "relative distance of the slider from dead centre"
    title = "the crank driven by its slider"
    chart_picture(marks, title, label, towards=True).savefig(path, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(description="The slider-driven crank near dead centre.")
    parser.add_argument("-o", "--output", metavar="PICTURE.png", help="also draw the table")
    parser.add_argument("--offset", type=float, default=2.0, help="of the slider (2)")
    arguments = parser.parse_args()
    if missing := absent():
        print(f"not installed, left out: {', '.join(missing)}")
    found = measure(arguments.offset)
    print(table(found))
    if arguments.output:
        picture(arguments.output, found)


if __name__ == "__main__":
    main()
