"""Equations and any well-posed set of inputs in, solution path and checked answers out.

Names are imported on first use, so that ``import solver`` costs nothing. (No module has the name of
a function here: the module would take its place.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rulesheets import fetched

if TYPE_CHECKING:
    from rulesheets.loading import load, loads
    from solver.commands.draw import draw
    from solver.facts import Status, Unsolved
    from solver.files.tables import Samples, Table
    from solver.page.serving import interact
    from solver.report.derivation import Derivation, why
    from solver.solution.solving import Result, Solution, solve
    from solver.sweeps import Plan, prepare
    from solver.sweeps.sweep import monte_carlo, sweep

__all__ = ["Derivation", "Plan", "Result", "Samples", "Solution", "Status", "Table", "Unsolved"]
__all__ += ["draw", "interact", "load", "loads", "monte_carlo", "prepare", "solve", "sweep", "why"]

__getattr__, __dir__ = fetched(
    __name__,
    {
        "rulesheets.loading": "load loads",
        "solver.report.derivation": "Derivation why",
        "solver.facts": "Status Unsolved",
        "solver.page.serving": "interact",
        "solver.commands.draw": "draw",
        "solver.sweeps": "Plan prepare",
        "solver.files.tables": "Samples Table",
        "solver.solution.solving": "Result Solution solve",
        "solver.sweeps.sweep": "monte_carlo sweep",
    },
)
