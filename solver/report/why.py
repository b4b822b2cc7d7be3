"""A derivation as text, Markdown or LaTeX: what was given, then each number with its rule."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from rulesheets.diagnosis import plural
from rulesheets.model import Equation
from rulesheets.syntax.nodes import Name
from rulesheets.units import shown
from solver.report import columns
from solver.report.derivation import Derivation, Direct, Guard, Known, Link, Together
from solver.report.path import Notation, Places, Plain, Tex

MARGIN = "    "


def why_text(derivation: Derivation) -> str:
    """The inputs, then the numbered steps, each with its rule and what selected it."""
    return "\n\n".join(_Text(derivation, Plain()).parts())


def why_markdown(derivation: Derivation) -> str:
    """The same as a numbered list; mathematics between dollars, rules as code."""
    return "\n\n".join(_Markdown(derivation, Tex()).parts())


def why_latex(derivation: Derivation) -> str:
    """Rows of an ``align*`` environment, the places of the rules in comments."""
    rows = " \\\\\n".join(_Latex(derivation, Tex()).rows())
    return f"\\begin{{align*}}\n{rows}\n\\end{{align*}}"


@dataclass(frozen=True, slots=True)
class Line:
    """One equation of a step: ``left`` equals each of the ``chain``, the last in the ``unit``.

    ``closing``: a rule that an iteration has made hold. What the iteration itself gave has no ``equation``.
    """

    left: str
    chain: tuple[str, ...]
    unit: str = ""
    equation: Equation | None = None
    guards: tuple[Guard, ...] = ()
    closing: bool = False

    @property
    def formula(self) -> str:
        return " = ".join((self.left, *self.chain))


class Page:
    """What the forms have in common: one derivation, one notation."""

    def __init__(self, derivation: Derivation, notation: Notation) -> None:
        self.derivation, self.notation = derivation, notation
        self.model = derivation.model
        self.places = Places(derivation.model)

    def code(self, text: str) -> str:
        """A text of the sheet as it stands."""
        return text

    def head(self) -> str:
        """``vB = -41.46, from 7 inputs by 12 of 38 rules``, or that there is no value."""
        name, value = self.derivation.name, self.derivation.value
        if value is None:
            return f"{self.code(name)} has no value"
        whole = self.code(f"{name} = {Plain().value(value)}{self.unit(self.derivation)}")
        if any(known.name == name for known in self.derivation.inputs):
            return f"{whole} is an input"
        if any(known.name == name for known in self.derivation.assumed):
            return f"{whole} is what its case says"
        used = sum(1 if isinstance(link, Direct) else len(link.found) for link in self.derivation.links)
        inputs = plural(len(self.derivation.inputs), "input")
        return f"{whole}, from {inputs} by {used} of {plural(len(self.model.equations), 'rule')}"

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

    def lines(self, link: Link) -> Iterator[Line]:
        """The equations of a step: of a block what follows from tears, what closes it, and what it gave."""
        for one in (link,) if isinstance(link, Direct) else link.order:
            yield self.known_line(one.found, self._chain(one), one.equation, one.guards)
        if isinstance(link, Direct):
            return
        for closing in link.closing:
            left, right = map(self.notation.expression, (closing.equation.left, closing.equation.right))
            yield Line(left, (right,), "", closing.equation, closing.guards, closing=True)
        explicit = {inner.found.name for inner in link.order}
        for known in link.found:
            if known.name not in explicit:
                yield self.known_line(known, (self.notation.value(known.value),))

    def known_line(self, known: Known, chain: tuple[str, ...], *rule: Any) -> Line:
        return Line(self.name(known.name), chain, self.unit(known), *rule)

    def _chain(self, link: Direct) -> tuple[str, ...]:
        """What equals the unknown: its form, the form with numbers, its value; each said once."""
        value = self.notation.value(link.found.value)
        if link.form is None:
            return (value,)
        form = self.notation.expression(link.form)
        filled = self.notation.filled(link.form, link.numbers)
        return tuple(dict.fromkeys((form, filled, value)))

    def rule(self, equation: Equation) -> tuple[str, str]:
        return self.places.of(equation), self.places.said(equation)

    def guards(
        self, guards: Sequence[Guard], notation: Notation | None = None
    ) -> Iterator[tuple[str, str, str]]:
        """``because``, the conditions, and the values that they were read at; likewise what was assumed."""
        for word, assumed in (("because", False), ("assuming", True)):
            group = [guard for guard in guards if guard.assumed is assumed]
            if group:
                outcomes = [(guard.condition, guard.holds) for guard in group]
                known = dict.fromkeys(known for guard in group for known in guard.read)
                read = ", ".join(f"{one.name} = {Plain().value(one.value)}" for one in known)
                said = (notation or self.notation).conditions(outcomes)
                yield word, said, "" if read == Plain().conditions(outcomes) else read


class _Listed(Page):
    """Steps as a list, in text or in Markdown."""

    given, by_case = "Given\n", "Case by case\n"

    def parts(self) -> Iterator[str]:
        yield self.head()
        if self.derivation.inputs and self.derivation.links:
            yield self.given + self.table(self.derivation.inputs)
        if self.derivation.assumed:
            yield self.by_case + self.table(self.derivation.assumed)
        if self.derivation.links:
            yield "\n".join(self.steps())

    def steps(self) -> Iterator[str]:
        links = self.derivation.links
        for number, link in enumerate(links, 1):
            bullet = self.bullet(number, len(links))
            first, *rest = self.step(link)
            yield bullet + first
            yield from (" " * len(bullet) + line if line else "" for line in rest)

    def step(self, link: Link) -> Iterator[str]:
        if isinstance(link, Together):
            yield from self.heading(link)
        for line in self.lines(link):
            told = self.told(line)
            yield from told if isinstance(link, Direct) else self.within(told)

    def word(self, line: Line) -> str:
        return "such that " if line.closing else "" if line.equation else "which gives "

    def table(self, knowns: Iterable[Known]) -> str:
        raise NotImplementedError

    def bullet(self, number: int, count: int) -> str:
        raise NotImplementedError

    def heading(self, link: Together) -> Iterator[str]:
        raise NotImplementedError

    def told(self, line: Line) -> list[str]:
        """An equation with its rule, and what selected that."""
        raise NotImplementedError

    def within(self, told: Sequence[str]) -> Iterator[str]:
        """The same as a part of a block."""
        raise NotImplementedError


class _Text(_Listed):
    def table(self, knowns: Iterable[Known]) -> str:
        variables = self.model.variables
        return columns((f"{MARGIN}{self.known(known)}", variables[known.name].comment) for known in knowns)

    def bullet(self, number: int, count: int) -> str:
        return f"{number:>{len(str(count))}}  "

    def told(self, line: Line) -> list[str]:
        found = [f"{self.word(line)}{line.formula}{line.unit}"]
        if line.equation is not None:
            found.append(MARGIN + "  ".join(self.rule(line.equation)))
        for word, condition, read in self.guards(line.guards):
            found.append(f"{MARGIN}{word} {condition}" + (f"   ({read})" if read else ""))
        return found

    def within(self, told: Sequence[str]) -> Iterator[str]:
        return (MARGIN + line for line in told)

    def heading(self, link: Together) -> Iterator[str]:
        if len(link.found) == 1:
            yield f"{link.found[0].name}: by iteration"
        else:
            names = ", ".join(known.name for known in link.found)
            yield f"{names}: together, iterating on {', '.join(link.tears)}"


class _Markdown(_Listed):
    given, by_case = "Given:\n\n", "Case by case:\n\n"

    def code(self, text: str) -> str:
        return code_span(text)

    def known(self, known: Known) -> str:
        value = self.notation.value(known.value)
        return f"${self.name(known.name)} = {value}${_plain(self.unit(known))}"

    def table(self, knowns: Iterable[Known]) -> str:
        comments = {known.name: _plain(self.model.variables[known.name].comment) for known in knowns}
        return "\n".join(
            f"- {self.known(known)}" + (f": {comment}" if (comment := comments[known.name]) else "")
            for known in knowns
        )

    def bullet(self, number: int, count: int) -> str:
        return f"{number}. "

    def told(self, line: Line) -> list[str]:
        found = [f"{self.word(line)}${line.formula}${_plain(line.unit)}"]
        if line.equation is not None:
            place, rule = self.rule(line.equation)
            found.append(f"{code_span(rule)} ({_plain(place)})")
        for word, condition, read in self.guards(line.guards):
            found.append(f"{word} ${condition}$" + (f" ({code_span(read)})" if read else ""))
        return [*(f"{line}  " for line in found[:-1]), found[-1]]

    def within(self, told: Sequence[str]) -> Iterator[str]:
        return (f"{'  ' if number else '- '}{line}" for number, line in enumerate(told))

    def heading(self, link: Together) -> Iterator[str]:
        names = ", ".join(f"${self.name(known.name)}$" for known in link.found)
        tears = ", ".join(f"${self.name(name)}$" for name in link.tears)
        yield f"{names} by iteration:" if len(link.found) == 1 else f"{names} together, iterating on {tears}:"
        yield ""


class _Latex(Page):
    def rows(self) -> Iterator[str]:
        for known in (*self.derivation.inputs, *self.derivation.assumed):
            yield self._row(self.known_line(known, (self.notation.value(known.value),)))
        for link in self.derivation.links:
            yield from map(self._row, self.lines(link))

    def _row(self, line: Line) -> str:
        row = f"  {line.left} &= {' = '.join(line.chain)}"
        if unit := line.unit.strip().translate(ESCAPED):
            row += rf"\ \text{{{unit}}}"
        if line.equation is not None:
            place = "  ".join(self.rule(line.equation))
            row = f"  % {'closes the block: ' * line.closing}{place}\n{row}"
        guards = self.guards(line.guards)
        said = r",\ ".join(rf"\text{{{word} }} {condition}" for word, condition, _ in guards)
        return f"{row} && {said}" if said else row


ESCAPED = str.maketrans(
    {**{mark: f"\\{mark}" for mark in "%_#&${}"}, "\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)
_SPECIAL = re.compile(r"([\\`*_\[\]<>|$~&])")


def _plain(text: str) -> str:
    """Words of a sheet as themselves in Markdown: no emphasis, no links, no HTML."""
    return _SPECIAL.sub(r"\\\1", text)


def code_span(text: str) -> str:
    """A code span of Markdown, between more backticks than there are in the text."""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    pad = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{fence}{pad}{text}{pad}{fence}"
