"""Sweeps: one solve a row, a status for each row, and no row that spoils its neighbours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from rulesheets.model import Model, Value
from solver.plan import prepare
from solver.table import Column, Table


def sweep(
    model: Model,
    inputs: Mapping[str, Column],
    want: Iterable[str] | None = None,
    *,
    grid: bool = False,
    given: Mapping[str, Value | None] | None = None,
    guesses: Mapping[str, float] | None = None,
) -> Table:
    """Solve the model for every row of ``inputs``: arrays of one length; with ``grid``, each combination.

    Raises RuleSheetError for unknown names and ValueError for arrays of different lengths.
    """
    plan = prepare(model, inputs, want, given, guesses)
    columns = [np.atleast_1d(np.asarray(column)) for column in inputs.values()]
    if grid:
        columns = [axis.ravel() for axis in np.meshgrid(*columns, indexing="ij")]
    return plan.sweep(*columns)
