"""What is measured: the paper's sheet with its five outputs wanted, driven by the crank and by the
slider."""

from __future__ import annotations

from functools import cache

import numpy as np

import rulesheets
import solver
from benchmarks.speed.closed_forms import Array, forward
from rulesheets.model import Model
from solver.sweeps import Plan

SHEET = "offset_slider_crank"
FORWARD = ("xB", "vB", "omegaAB", "aB", "alphaAB")
BACKWARD = ("thetaAO", "vB", "omegaAB", "aB", "alphaAB")

ANGLE, POSITION = -30.0, 9.79
"""The inputs of one solve: degrees of the crank, place of the slider."""

GUESS = ANGLE + 10.0
"""Degrees of the crank where iterations start, all five outputs as they are there."""

NEARBY = {"forward": forward(GUESS), "backward": (GUESS, *forward(GUESS)[1:])}

DIRECTIONS = ("forward", "backward")


@cache
def model() -> Model:
    return rulesheets.load(SHEET)


def plan(direction: str) -> Plan:
    """A plan that has seen one row."""
    if direction == "forward":
        prepared = solver.prepare(model(), ["thetaAO"], FORWARD)
        prepared(ANGLE)
    else:
        prepared = solver.prepare(model(), ["xB"], BACKWARD, {"thetaAO": None})
        prepared.all(POSITION)
    return prepared


def column(direction: str, rows: int) -> Array:
    """Inputs of a sweep: a turn and a half of the crank, most of the outer stroke of the slider."""
    return (
        np.linspace(-180.0, 360.0, rows) if direction == "forward" else np.linspace(6.0, 10.6, rows)
    )
