"""A derivation as text, Markdown or LaTeX: what was given, then each number with its rule."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

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
    return "\n\n".join(Page(derivation, Plain()).parts())


def why_markdown(derivation: Derivation) -> str:
    """The same as a numbered list; mathematics between dollars, rules as code."""
    return "\n\n".join(Page(derivation, Tex(), markdown=True).parts())


def why_latex(derivation: Derivation) -> str:
    """Rows of an ``align*`` environment, the places of the rules in comments."""
    page, rows = Page(derivation, Tex()), []
    given = [page.value_line(known) for known in (*derivation.inputs, *derivation.assumed)]
    for line in (*given, *(line for link in derivation.links for line in page.lines(link))):
        row = f"  {line.left} &= {' = '.join(line.chain)}"
        if unit := line.unit.strip().translate(ESCAPED):
            row += rf"\ \text{{{unit}}}"
        if line.equation is not None:
            place = "  ".join(page.places.rule(line.equation))
            row = f"  % {'closes the block: ' * line.closing}{place}\n{row}"
        said = [rf"\text{{{word} }} {condition}" for word, condition, _ in page.guards(line.guards)]
        rows.append(row + " && " + r",\ ".join(said) if said else row)
    body = " \\\\\n".join(rows)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}"


class Line(NamedTuple):
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
    """One derivation in one notation, with the signs of Markdown where they are asked for."""

    def __init__(self, derivation: Derivation, notation: Notation, *, markdown: bool = False) -> None:
        self.derivation, self.notation, self.markdown = derivation, notation, markdown
        self.model = derivation.model
        self.places = Places(derivation.model)

    # --- the equations, alike in every form ---

    def head(self) -> str:
        """``vB = -41.46, from 7 inputs by 12 of 38 rules``, or that there is no value."""
        found = self.derivation
        if found.value is None:
            return f"{self.code(found.name)} has no value"
        whole = self.code(f"{found.name} = {Plain().value(found.value)}{self.unit(found)}")
        if any(known.name == found.name for known in found.inputs):
            return f"{whole} is an input"
        if any(known.name == found.name for known in found.assumed):
            return f"{whole} is what its case says"
        used = sum(1 if isinstance(link, Direct) else len(link.found) for link in found.links)
        inputs, rules = plural(len(found.inputs), "input"), plural(len(self.model.equations), "rule")
        return f"{whole}, from {inputs} by {used} of {rules}"

    def unit(self, known: Known | Derivation) -> str:
        """`` N``, or `` N = 2.25 lbf`` where it is shown in another unit than that of the rules."""
        variable = self.model.variables[known.name]
        unit = f" {variable.unit}" if variable.unit else ""
        if not variable.display_unit or not isinstance(known.value, float):
            return unit
        return f"{unit} = {Plain().value(shown(known.value, variable))} {variable.display_unit}"

    def lines(self, link: Link) -> Iterator[Line]:
        """The equations of a step: of a block what follows from tears, what closes it, and what it gave."""
        for one in (link,) if isinstance(link, Direct) else link.order:
            chain = [self.notation.value(one.found.value)]
            if one.form is not None:  # the form, the form with numbers, the value; each said once
                filled = self.notation.filled(one.form, one.numbers)
                chain = [self.notation.expression(one.form), filled, *chain]
            yield self._line(one.found, tuple(dict.fromkeys(chain)), one.equation, one.guards)
        if isinstance(link, Direct):
            return
        for equation, guards in link.closing:
            left, right = map(self.notation.expression, (equation.left, equation.right))
            yield Line(left, (right,), "", equation, guards, closing=True)
        explicit = {inner.found.name for inner in link.order}
        yield from (self.value_line(known) for known in link.found if known.name not in explicit)

    def value_line(self, known: Known) -> Line:
        return self._line(known, (self.notation.value(known.value),))

    def _line(self, known: Known, chain: tuple[str, ...], *rule: Any) -> Line:
        return Line(self.notation.expression(Name(known.name)), chain, self.unit(known), *rule)

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

    # --- a list of steps, in text or in Markdown ---

    def parts(self) -> Iterator[str]:
        yield self.head()
        found, colon = self.derivation, ":\n" * self.markdown
        if found.inputs and found.links:
            yield f"Given{colon}\n{self._table(found.inputs)}"
        if found.assumed:
            yield f"Case by case{colon}\n{self._table(found.assumed)}"
        if found.links:
            yield "\n".join(self._steps(found.links))

    def code(self, text: str) -> str:
        """A text of the sheet as it stands."""
        return code_span(text) if self.markdown else text

    def _plain(self, text: str) -> str:
        """Words of a sheet as themselves in Markdown: no emphasis, no links, no HTML."""
        return _SPECIAL.sub(r"\\\1", text) if self.markdown else text

    def _formula(self, line: Line) -> str:
        return f"${line.formula}${self._plain(line.unit)}" if self.markdown else line.formula + line.unit

    def known(self, known: Known) -> str:
        """``AO = 3 mm``, in Markdown between dollars, else as in a sheet."""
        if self.markdown:
            return self._formula(self.value_line(known))
        return f"{known.name} = {Plain().value(known.value)}{self.unit(known)}"

    def _table(self, knowns: Iterable[Known]) -> str:
        rows = [(self.known(known), self.model.variables[known.name].comment) for known in knowns]
        if not self.markdown:
            return columns((MARGIN + known, comment) for known, comment in rows)
        return "\n".join(f"- {known}" + f": {self._plain(said)}" * bool(said) for known, said in rows)

    def _steps(self, links: Sequence[Link]) -> Iterator[str]:
        for number, link in enumerate(links, 1):
            bullet = f"{number}. " if self.markdown else f"{number:>{len(str(len(links)))}}  "
            lines, dash, indent = list[str](), "", ""
            if isinstance(link, Together):
                lines = self._heading(link)
                dash, indent = ("- ", "  ") if self.markdown else (MARGIN, MARGIN)
            for line in self.lines(link):
                first, *rest = self._told(line)
                lines += [dash + first, *(indent + more for more in rest)]
            yield bullet + lines[0]
            yield from (" " * len(bullet) + line if line else "" for line in lines[1:])

    def _told(self, line: Line) -> list[str]:
        """An equation with its rule, and what selected that."""
        word = "such that " if line.closing else "" if line.equation else "which gives "
        told = [word + self._formula(line)]
        if line.equation is not None:
            place, rule = self.places.rule(line.equation)
            told.append(f"{self.code(rule)} ({self._plain(place)})" if self.markdown else f"{place}  {rule}")
        for word, condition, read in self.guards(line.guards):
            said, gap = (f"${condition}$", " ") if self.markdown else (condition, "   ")
            told.append(f"{word} {said}" + f"{gap}({self.code(read)})" * bool(read))
        if self.markdown:
            return [*(f"{line}  " for line in told[:-1]), told[-1]]
        return [told[0], *(MARGIN + line for line in told[1:])]

    def _heading(self, link: Together) -> list[str]:
        """What a block gives, and what was iterated on."""
        found = [known.name for known in link.found]
        maths = {
            n: f"${self.notation.expression(Name(n))}$" if self.markdown else n for n in (*found, *link.tears)
        }
        how = "by iteration"
        if len(found) > 1:
            how = f"together, iterating on {', '.join(maths[name] for name in link.tears)}"
        names = ", ".join(maths[name] for name in found)
        return [f"{names} {how}:", ""] if self.markdown else [f"{names}: {how}"]


ESCAPED = str.maketrans(
    {**{mark: f"\\{mark}" for mark in "%_#&${}"}, "\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)
_SPECIAL = re.compile(r"([\\`*_\[\]<>|$~&])")


def code_span(text: str) -> str:
    """A code span of Markdown, between more backticks than there are in the text."""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    pad = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{fence}{pad}{text}{pad}{fence}"
