"""Tolerances of the numerical methods, each with its reason."""

from __future__ import annotations

import sys

EPS = sys.float_info.epsilon
"""The distance from 1 to the next float."""

STAGNATION = 1e-7
"""Length of a correction, relative to the unknowns, at which an end of contraction is put down to rounding:
in exact numbers the next one would be its square, 1e-14. Rules of condition 1e8 are as noisy."""
