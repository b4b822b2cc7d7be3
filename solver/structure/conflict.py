"""Smallest sets of equations that leave no freedom to one another.

Matchable sets of equations form a matroid (the transversal matroid; Edmonds & Fulkerson 1965). What
one equation too many is at odds with is its fundamental circuit.
"""

from __future__ import annotations

from solver.structure.incidence import Block, Incidence
from solver.structure.matching import Matching, maximum_matching, reached


def minimal_conflict(incidence: Incidence, equation: int, matching: Matching | None = None) -> Block:
    """The equations that together with a single ``equation`` say one thing too many, and their unknowns.

    There is one equation more than unknowns, and without any one of them the others can be
    matched: no smaller set explains the conflict structurally. For the given ``matching``
    (maximum; default: the canonical one) the set is unique. Where inputs shall show up in it, let
    each be an unknown with an equation of its own.
    Raises ValueError where ``equation`` is matched.
    """
    matching = matching or maximum_matching(incidence)
    if matching.unknown_of[equation] is not None:
        raise ValueError(f"equation {equation} has an unknown of its own")
    equations = reached((equation,), incidence.occurs, matching.equation_of)
    return Block.of(equations, {unknown for e in equations for unknown in incidence.occurs[e]})
