"""Tolerances of the numerical methods, each with its reason."""

from __future__ import annotations

import sys

EPS = sys.float_info.epsilon
"""The distance from 1 to the next float."""
