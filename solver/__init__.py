"""Equations and any well-posed set of inputs in, solution path and checked answers out.

Names are imported on first use, so that ``import solver`` costs nothing. (No module has the name of
a function here: the module would take its place.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rulesheets import fetched

if TYPE_CHECKING:
    from rulesheets.loading import load as load
    from rulesheets.loading import loads as loads
    from solver.commands.draw import draw as draw
    from solver.facts import Status as Status
    from solver.facts import Unsolved as Unsolved
    from solver.files.tables import Samples as Samples
    from solver.files.tables import Table as Table
    from solver.page.serving import interact as interact
    from solver.report.derivation import Derivation as Derivation
    from solver.report.derivation import why as why
    from solver.solution.solving import Result as Result
    from solver.solution.solving import Solution as Solution
    from solver.solution.solving import solve as solve
    from solver.sweeps import Plan as Plan
    from solver.sweeps import prepare as prepare
    from solver.sweeps.sweep import monte_carlo as monte_carlo
    from solver.sweeps.sweep import sweep as sweep

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
__all__ = [*__dir__()]
