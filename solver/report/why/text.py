"""A derivation as plain text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rulesheets.model import Equation
from solver.derivation import Closing, Derivation, Direct, Guard, Known, Together
from solver.report.notation import Plain, equation
from solver.report.table import columns
from solver.report.why.page import Page, iterated

MARGIN = "    "


def why_text(derivation: Derivation) -> str:
    """The inputs, then the numbered steps, each with its rule and what selected it."""
    page = Page(derivation, Plain())
    parts = [page.head()]
    if derivation.inputs and derivation.links:
        parts.append("Given\n" + _known(page, derivation.inputs))
    if derivation.assumed:
        parts.append("Case by case\n" + _known(page, derivation.assumed))
    if derivation.links:
        parts.append("\n".join(_lines(page)))
    return "\n\n".join(parts)


def _known(page: Page, knowns: Iterable[Known]) -> str:
    comments = {known.name: page.model.variables[known.name].comment for known in knowns}
    return columns((f"{MARGIN}{page.known(known)}", comments[known.name]) for known in knowns)


def _lines(page: Page) -> Iterator[str]:
    links = page.derivation.links
    size = len(str(len(links)))
    for number, link in enumerate(links, 1):
        first, *rest = _direct(page, link) if isinstance(link, Direct) else _together(page, link)
        yield f"{number:>{size}}  {first}"
        yield from (f"{'':{size}}  {line}" for line in rest)


def _direct(page: Page, link: Direct) -> Iterator[str]:
    yield f"{link.found.name} = {' = '.join(page.chain(link))}{page.unit(link.found)}"
    yield from _rule(page, link.equation, link.guards)


def _rule(page: Page, equation: Equation, guards: Sequence[Guard]) -> Iterator[str]:
    place, rule = page.rule(equation)
    yield f"{MARGIN}{place}  {rule}"
    for word, condition, read in page.guards(guards):
        yield f"{MARGIN}{word} {condition}" + (f"   ({read})" if read else "")


def _together(page: Page, link: Together) -> Iterator[str]:
    yield _heading(link)
    for inner in link.order:
        for line in _direct(page, inner):
            yield MARGIN + line
    for closing in link.closing:
        yield MARGIN + _closing(page, closing)
        for line in _rule(page, closing.equation, closing.guards):
            yield MARGIN + line
    for known in iterated(link):
        yield f"{MARGIN}which gives {page.known(known)}"


def _heading(link: Together) -> str:
    if len(link.found) == 1:
        return f"{link.found[0].name}: by iteration"
    names = ", ".join(known.name for known in link.found)
    return f"{names}: together, iterating on {', '.join(link.tears)}"


def _closing(page: Page, closing: Closing) -> str:
    return f"such that {equation(page.notation, closing.equation)}"
