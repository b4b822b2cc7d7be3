"""The methods of a block: those that its structure admits, in the order in which they are tried.

Each is tried where those before it have left answers open; where nothing was found at all, trust regions
follow (``search/fallback.py``).
"""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.functions import named
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call
from rulesheets.syntax.program import walk
from solver.attempts import Method
from solver.kernel.code.block import BlockKernel
from solver.kernel.code.reduction import reduced

MAX_BOX_UNKNOWNS, MAX_PROOF_UNKNOWNS = 6, 40
"""Unknowns of a block up to which boxes are searched; the same where a proof is asked for."""
MAX_SEARCHED = 30
"""Unknowns of a block up to which all answers are searched for."""

_CIRCULAR = named(lambda row: row.turn and not row.half_turn)


def first_methods(kernel: BlockKernel, thorough: bool = False) -> Iterator[Method]:
    """The methods in order, up to the last resort; ``thorough`` where a proof is asked for.

    What a method needs to know of the block is found out when its turn comes. Numbers may still rule one out.
    """
    if kernel.linear:
        yield Method.LINEAR
    elif is_large(kernel):
        yield Method.SPARSE
    yield from _counts(kernel)
    yield from _searches(kernel, thorough)


def is_large(kernel: BlockKernel) -> bool:
    """Whether one answer is looked for before any others."""
    return len(kernel.unknowns) > MAX_SEARCHED


def _counts(kernel: BlockKernel) -> Iterator[Method]:
    """Those that count the answers. A polynomial in half an angle has a higher degree than a formula."""
    turning = any(kernel.graph.turn(tear) for tear in kernel.block.tears)
    if not turning and may_be_polynomial(kernel):
        yield Method.POLYNOMIAL
    if kernel.closed is not None:
        yield Method.FORMULA
    if turning and may_be_polynomial(kernel):
        yield Method.POLYNOMIAL


def _searches(kernel: BlockKernel, thorough: bool) -> Iterator[Method]:
    torn_once = len(kernel.block.tears) == 1
    if torn_once:
        yield Method.RANGE
    elif reduced(kernel) is not None:
        yield Method.SUBSTITUTION
    most = MAX_PROOF_UNKNOWNS if thorough else MAX_BOX_UNKNOWNS
    if (thorough or not torn_once) and len(kernel.unknowns) <= most and kernel.finite:
        yield Method.BOXES
    yield Method.STARTS


def may_be_polynomial(kernel: BlockKernel) -> bool:
    """Whether the block may lead to one polynomial in a tear, or in the tangent of half of it."""
    tears, unknowns = kernel.block.tears, frozenset(kernel.unknowns)
    turning = any(kernel.graph.turn(tear) for tear in tears)
    if not 1 <= len(tears) <= 2 or (turning and len(tears) == 2):
        return False
    admitted = _CIRCULAR if turning else frozenset[str]()
    return all(
        node.function in admitted
        for form in kernel.forms
        for node in walk(form)
        if isinstance(node, Call) and not unknowns.isdisjoint(nodes.names(node))
    )
