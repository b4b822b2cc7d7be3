"""A chain with each of its directions on one side of the cut, where none jumps.

``atan2d(y, x)`` goes from 180 to -180 where y falls below 0 at a negative x. Over a box in which it does, the
range of a residual spans the whole turn, although its values may all lie at the two ends of it. But every
direction is either ``atan2d(y, x)`` of a y >= 0, or ``-atan2d(-y, x)`` of a -y >= 0: each is continuous for
x < 0, and where the residual has no root with either, it has none.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

from rulesheets.syntax.construct import exchange, negative
from rulesheets.syntax.nodes import Call, Name
from solver.kernel.code.chain import Assignment, Chain, directions

if TYPE_CHECKING:
    from collections.abc import Mapping

MOST = 2
"""Directions of a chain, of which every combination of sides is a chain of its own."""


def sides(chain: Chain) -> tuple[Chain, ...]:
    """One chain for every combination of sides; none where there is no direction, or too many.

    The residual is at every point that of one of the chains, if it has a value there.
    """
    calls = dict.fromkeys(call for item in chain.assignments for call in directions(item.expression))
    if not 0 < len(calls) <= MOST:
        return ()
    return tuple(
        _beside(chain, dict(zip(calls, upper, strict=True)))
        for upper in product((True, False), repeat=len(calls))
    )


def _beside(chain: Chain, upper: Mapping[Call, bool]) -> Chain:
    """The chain with directions on the upper side of their cut, or on the lower one."""
    assignments: list[Assignment] = []
    for item in chain.assignments:
        expression = item.expression
        for number, call in enumerate(upper):
            if call in directions(expression):
                y, x = call.arguments
                name = f"#side {number}"
                assignments.append(Assignment(name, y if upper[call] else negative(y), low=0.0))
                turned = Call(call.function, (Name(name), x))
                expression = exchange(expression, call, turned if upper[call] else negative(turned))
        assignments.append(replace(item, expression=expression))
    return Chain(chain.tears, tuple(assignments), chain.residuals)
