"""What the answers that were found leave open: whether they are known to be all.

Every step and every block says whether it has all of its values. ``PathSearch`` (``explore.py``)
records the first that does not as a ``Gap``, and is not ``complete`` from then on, nor after it has
abandoned a branch. At the end of its search an open case counts, unless it hides no answer, and so
do the whole turns of angles that were left out, if another turn may end otherwise. Where floats may
have lost an answer, ``explore_refined`` (``verdict.py``) takes it back, unless two precisions
agree. ``Result`` is complete if its exploration is, and its status has no reservation
(``is_complete`` there).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rulesheets.model import Model, Value
from rulesheets.syntax import nodes
from solver.facts import Conflict, Fact, NoRoot, NoValue, OutOfRange
from solver.leaves import Leaf
from solver.path import equations_of
from solver.path.graph import is_angle_sum
from solver.path.planner import planner


def hides_no_answer(model: Model, leaf: Leaf, inputs: Mapping[str, Value]) -> bool:
    """Whether a case that an open leaf assumes is proven to have no values, or no value satisfies a
    rule that leads to one of its missing values."""
    asked = {name for pair in leaf.branch.signs for side in pair for name in nodes.names(side)}
    facts = leaf.branch.inactive.values()
    refused = [_without_value(fact) for fact in facts]
    if any(isinstance(fact, Conflict) for fact in facts) or any(
        not asked.isdisjoint(unknowns) for _, unknowns in refused
    ):
        return True
    missing = frozenset(leaf.missing)
    path = planner(model).path(frozenset(inputs), leaf.branch.conditions, want=missing)
    leading = {equation for step in path.steps for equation in equations_of(step)}
    return any(not leading.isdisjoint(equations) for equations, _ in refused)


def _without_value(fact: Fact) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The equations that no value satisfies according to a proven fact, and the unknowns in
    question."""
    match fact:
        case NoValue(pole=False) | OutOfRange():
            return (fact.equation,), (fact.unknown,)
        case NoRoot(proven=True):
            return fact.equations, fact.unknowns
        case _:
            return (), ()


def turns_matter(model: Model, contradicted: Iterable[Leaf]) -> bool:
    """Whether branches with other whole turns of an angle may end otherwise than those that were
    followed, if these all end at a contradiction.

    They cannot if each of these ends at a rule that reads its angles in periodic functions.
    """
    facts = [fact for leaf in contradicted for fact in leaf.conflicts]
    rules = [
        model.equations[i] for fact in facts if isinstance(fact, Conflict) for i in fact.equations
    ]
    sums = any(is_angle_sum(rule.left) and is_angle_sum(rule.right) for rule in rules)
    return bool(sums or len(rules) < len(facts) or model.conditions or model.requirements)
