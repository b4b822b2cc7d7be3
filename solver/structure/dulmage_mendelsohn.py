"""The coarse Dulmage–Mendelsohn decomposition.

A. L. Dulmage & N. S. Mendelsohn, "Coverings of bipartite graphs", Canad. J. Math. 10 (1958);
A. Pothen & C.-J. Fan, "Computing the block triangular form of a sparse matrix", ACM TOMS 16 (1990).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from solver.structure.incidence import Block, Incidence
from solver.structure.matching import Edges, Matching, maximum_matching, reached


class Parts(NamedTuple):
    """Every equation and every unknown stands in exactly one part. The parts are unique.

    ``over`` has more equations than unknowns (or is empty): its equations contradict one another
    or repeat one another. ``square`` has as many of both and can be solved once ``over`` is.
    ``under`` has more unknowns than equations: none of its unknowns is determined.
    """

    over: Block
    square: Block
    under: Block


def dulmage_mendelsohn(incidence: Incidence, matching: Matching | None = None) -> Parts:
    """The three parts; any maximum ``matching`` gives the same."""
    matching = matching or maximum_matching(incidence)
    over_equations = reached(matching.single_equations, incidence.occurs, matching.equation_of)
    under_unknowns = reached(matching.single_unknowns, incidence.users, matching.unknown_of)
    over = Block.of(over_equations, _neighbours(over_equations, incidence.occurs))
    under = Block.of(_neighbours(under_unknowns, incidence.users), under_unknowns)
    return Parts(over, _rest(incidence.block, over, under), under)


def _neighbours(nodes: Iterable[int], edges: Edges) -> set[int]:
    return {neighbour for node in nodes for neighbour in edges[node]}


def _rest(whole: Block, over: Block, under: Block) -> Block:
    equations = {*over.equations, *under.equations}
    unknowns = {*over.unknowns, *under.unknowns}
    return Block(
        tuple(e for e in whole.equations if e not in equations),
        tuple(u for u in whole.unknowns if u not in unknowns),
    )
