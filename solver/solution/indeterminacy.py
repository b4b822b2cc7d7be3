"""Rules that are 0/0 at known values."""

from __future__ import annotations

from collections.abc import Mapping

from rulesheets.model import Equation, Value
from solver.facts import Indeterminacy


def indeterminacy(equation: Equation, values: Mapping[str, Value]) -> Indeterminacy | None:
    """The fact that an equation is 0/0 at the values, if it is."""
    from rulesheets.evaluate.limit import indeterminate

    for side in (equation.left, equation.right):
        found = indeterminate(side, values)
        if found is not None:
            read = {name: values[name] for name in equation.names if name in values}
            return Indeterminacy(equation.index, found.form, found.limit, found.is_open, read)
    return None
