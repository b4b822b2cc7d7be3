"""What compiled interval code calls on arrays of boxes; callers silence numpy's warnings once."""

from __future__ import annotations

import numpy as np

from rulesheets.functions.intervals.arrays import INTERVALS, add, divide, multiply, power, scaled, square
from solver.kernel.code.interval_code import Operations

ARRAYS = Operations(
    np.float64,
    INTERVALS,
    {"add": add, "divide": divide, "multiply": multiply, "power": power, "square": square, "scaled": scaled},
)
