"""Equations and any well-posed set of inputs in, solution path and checked answers out.

Names are fetched on first use, so that ``import solver`` costs nothing. (No module is called
like a function of this page: the module would take the function's place.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rulesheets.loading import load, loads
    from solver.derivation import Derivation, why
    from solver.facts import Status
    from solver.interaction import interact
    from solver.pictures.drawing import draw
    from solver.plan import Plan, Unsolved, prepare
    from solver.result import Result, Samples, Solution, Table
    from solver.solving import solve
    from solver.sweeps.sweep import monte_carlo, sweep

_HOMES = {
    "Derivation": "solver.derivation",
    "Plan": "solver.plan",
    "Result": "solver.result",
    "Samples": "solver.result",
    "Solution": "solver.result",
    "Status": "solver.facts",
    "Table": "solver.result",
    "Unsolved": "solver.plan",
    "draw": "solver.pictures.drawing",
    "interact": "solver.interaction",
    "load": "rulesheets.loading",
    "loads": "rulesheets.loading",
    "monte_carlo": "solver.sweeps.sweep",
    "prepare": "solver.plan",
    "solve": "solver.solving",
    "sweep": "solver.sweeps.sweep",
    "why": "solver.derivation",
}

__all__ = [
    "Derivation",
    "Plan",
    "Result",
    "Samples",
    "Solution",
    "Status",
    "Table",
    "Unsolved",
    "draw",
    "interact",
    "load",
    "loads",
    "monte_carlo",
    "prepare",
    "solve",
    "sweep",
    "why",
]


def __getattr__(name: str) -> object:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'solver' has no attribute {name!r}")
    from importlib import import_module

    found: object = getattr(import_module(home), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
