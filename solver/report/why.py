"""A derivation as text, Markdown or LaTeX: what was given, then each number with its rule."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from rulesheets.diagnosis import plural
from rulesheets.model import Equation
from rulesheets.syntax.nodes import Name
from rulesheets.units.quantity import shown
from solver.derivation import Closing, Derivation, Direct, Guard, Known, Link, Together
from solver.report.path import Notation, Places, Plain, Tex, equation
from solver.report.table import columns

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


class Page:
    """What the three forms have in common: one derivation, one notation."""

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
            yield "\n".join(self.lines())

    def lines(self) -> Iterator[str]:
        links = self.derivation.links
        for number, link in enumerate(links, 1):
            bullet = self.bullet(number, len(links))
            first, *rest = self.direct(link) if isinstance(link, Direct) else self.together(link)
            yield bullet + first
            yield from (" " * len(bullet) + line if line else "" for line in rest)

    def table(self, knowns: Iterable[Known]) -> str:
        raise NotImplementedError

    def bullet(self, number: int, count: int) -> str:
        raise NotImplementedError

    def direct(self, link: Direct) -> Iterator[str]:
        raise NotImplementedError

    def together(self, link: Together) -> Iterator[str]:
        raise NotImplementedError


class _Text(_Listed):
    def table(self, knowns: Iterable[Known]) -> str:
        variables = self.model.variables
        return columns((f"{MARGIN}{self.known(known)}", variables[known.name].comment) for known in knowns)

    def bullet(self, number: int, count: int) -> str:
        return f"{number:>{len(str(count))}}  "

    def direct(self, link: Direct) -> Iterator[str]:
        yield f"{link.found.name} = {' = '.join(self.chain(link))}{self.unit(link.found)}"
        yield from self._reasons(link)

    def _reasons(self, link: Direct | Closing) -> Iterator[str]:
        place, rule = self.rule(link.equation)
        yield f"{MARGIN}{place}  {rule}"
        for word, condition, read in self.guards(link.guards):
            yield f"{MARGIN}{word} {condition}" + (f"   ({read})" if read else "")

    def together(self, link: Together) -> Iterator[str]:
        if len(link.found) == 1:
            yield f"{link.found[0].name}: by iteration"
        else:
            names = ", ".join(known.name for known in link.found)
            yield f"{names}: together, iterating on {', '.join(link.tears)}"
        for inner in link.order:
            yield from (MARGIN + line for line in self.direct(inner))
        for closing in link.closing:
            yield f"{MARGIN}such that {equation(self.notation, closing.equation)}"
            yield from (MARGIN + line for line in self._reasons(closing))
        for known in iterated(link):
            yield f"{MARGIN}which gives {self.known(known)}"


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

    def direct(self, link: Direct) -> Iterator[str]:
        chain = " = ".join((self.name(link.found.name), *self.chain(link)))
        yield f"${chain}${_plain(self.unit(link.found))}  "
        yield from self._reasons(link)

    def _reasons(self, link: Direct | Closing) -> Iterator[str]:
        place, rule = self.rule(link.equation)
        lines = [f"{code_span(rule)} ({_plain(place)})"]
        for word, condition, read in self.guards(link.guards):
            lines.append(f"{word} ${condition}$" + (f" ({code_span(read)})" if read else ""))
        yield from (f"{line}  " for line in lines[:-1])
        yield lines[-1]

    def together(self, link: Together) -> Iterator[str]:
        names = ", ".join(f"${self.name(known.name)}$" for known in link.found)
        tears = ", ".join(f"${self.name(name)}$" for name in link.tears)
        yield f"{names} by iteration:" if len(link.found) == 1 else f"{names} together, iterating on {tears}:"
        yield ""
        for inner in link.order:
            yield from _item(self.direct(inner))
        for closing in link.closing:
            head = f"such that ${equation(self.notation, closing.equation)}$  "
            yield from _item((head, *self._reasons(closing)))
        for known in iterated(link):
            yield f"- which gives {self.known(known)}"


class _Latex(Page):
    def rows(self) -> Iterator[str]:
        for known in (*self.derivation.inputs, *self.derivation.assumed):
            yield self.known(known)
        for link in self.derivation.links:
            yield from self._of(link)

    def known(self, known: Known) -> str:
        value = self.notation.value(known.value)
        return f"  {self.name(known.name)} &= {value}{self._upright(known)}"

    def _upright(self, known: Known) -> str:
        r"""A unit in upright letters: ``\ \text{rad/s}``."""
        unit = self.unit(known).strip().translate(ESCAPED)
        return rf"\ \text{{{unit}}}" if unit else ""

    def _of(self, link: Link) -> Iterator[str]:
        if isinstance(link, Direct):
            yield self._direct(link)
            return
        for inner in link.order:
            yield self._direct(inner)
        for closing in link.closing:
            sides = closing.equation.left, closing.equation.right
            left, right = map(self.notation.expression, sides)
            yield f"  % closes the block: {self._place(closing)}\n  {left} &= {right}{self._why(closing)}"
        yield from map(self.known, iterated(link))

    def _direct(self, link: Direct) -> str:
        chain = " = ".join(self.chain(link))
        row = f"  {self.name(link.found.name)} &= {chain}{self._upright(link.found)}"
        return f"  % {self._place(link)}\n{row}{self._why(link)}"

    def _place(self, link: Direct | Closing) -> str:
        return "  ".join(self.rule(link.equation))

    def _why(self, link: Direct | Closing) -> str:
        guards = self.guards(link.guards)
        said = r",\ ".join(rf"\text{{{word} }} {condition}" for word, condition, _ in guards)
        return f" && {said}" if said else ""


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


def _item(lines: Iterable[str]) -> Iterator[str]:
    first, *rest = lines
    yield f"- {first}"
    yield from (f"  {line}" for line in rest)


def iterated(link: Together) -> tuple[Known, ...]:
    """The unknowns of a block that follow from no other: what the iteration gave."""
    explicit = {inner.found.name for inner in link.order}
    return tuple(known for known in link.found if known.name not in explicit)
