"""What the three forms of a derivation have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from rulesheets.model import Equation
from rulesheets.nodes import Name
from rulesheets.spelling import plural
from rulesheets.units.quantity import shown
from solver.derivation import Derivation, Direct, Guard, Known, Together
from solver.report.notation import Notation, Plain
from solver.report.places import Places


class Page:
    """What the three forms have in common: one derivation, one notation."""

    def __init__(self, derivation: Derivation, notation: Notation) -> None:
        self.derivation, self.notation = derivation, notation
        self.model = derivation.model
        self.places = Places(derivation.model)

    def head(self, code: Callable[[str], str] = str) -> str:
        """``vB = -41.46, from 7 inputs by 12 of 38 rules``, or that there is no value."""
        name, value = self.derivation.name, self.derivation.value
        if value is None:
            return f"{code(name)} has no value"
        whole = code(f"{name} = {Plain().value(value)}{self.unit(self.derivation)}")
        if any(known.name == name for known in self.derivation.inputs):
            return f"{whole} is an input"
        if any(known.name == name for known in self.derivation.assumed):
            return f"{whole} is what its case says"
        inputs = plural(len(self.derivation.inputs), "input")
        rules = f"{self._used()} of {plural(len(self.model.equations), 'rule')}"
        return f"{whole}, from {inputs} by {rules}"

    def _used(self) -> int:
        return sum(1 if isinstance(link, Direct) else len(link.found) for link in self.derivation.links)

    def unit(self, known: Known | Derivation) -> str:
        """`` N``, or `` N = 2.25 lbf`` where it is shown in another unit than that of the rules."""
        variable = self.model.variables[known.name]
        unit = f" {variable.unit}" if variable.unit else ""
        if not variable.display_unit or not isinstance(known.value, float):
            return unit
        return f"{unit} = {Plain().value(shown(known.value, variable))} {variable.display_unit}"

    def name(self, name: str) -> str:
        return self.notation.expression(Name(name))

    def known(self, known: Known) -> str:
        """``AO = 3 mm``."""
        return f"{known.name} = {Plain().value(known.value)}{self.unit(known)}"

    def chain(self, link: Direct) -> tuple[str, ...]:
        """What equals the unknown: its form, the form with numbers, its value; each said once."""
        value = self.notation.value(link.found.value)
        if link.form is None:
            return (value,)
        form = self.notation.expression(link.form)
        filled = self.notation.filled(link.form, link.numbers)
        return tuple(dict.fromkeys((form, filled, value)))

    def rule(self, equation: Equation) -> tuple[str, str]:
        return self.places.of(equation), self.places.said(equation)

    def guards(self, guards: Sequence[Guard]) -> Iterator[tuple[str, str, str]]:
        """``because``, the conditions, and the values that they were read at; likewise what was assumed."""
        for word, assumed in (("because", False), ("assuming", True)):
            group = [guard for guard in guards if guard.assumed is assumed]
            if group:
                yield word, *self._conditions(group)

    def _conditions(self, guards: Sequence[Guard]) -> tuple[str, str]:
        outcomes = [(guard.condition, guard.holds) for guard in guards]
        known = dict.fromkeys(known for guard in guards for known in guard.read)
        read = ", ".join(f"{one.name} = {Plain().value(one.value)}" for one in known)
        said = read == Plain().conditions(outcomes)
        return self.notation.conditions(outcomes), "" if said else read


def iterated(link: Together) -> tuple[Known, ...]:
    """The unknowns of a block that follow from no other: what the iteration gave."""
    explicit = {inner.found.name for inner in link.order}
    return tuple(known for known in link.found if known.name not in explicit)
