"""A derivation as LaTeX."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rulesheets.model import Equation
from solver.derivation import Derivation, Direct, Guard, Known, Link
from solver.report.notation import Tex
from solver.report.why.page import Page, iterated

_ESCAPED = {
    **{mark: f"\\{mark}" for mark in "%_#&${}"},
    "\\": r"\textbackslash{}",
    "^": r"\^{}",
    "~": r"\~{}",
}


def why_latex(derivation: Derivation) -> str:
    """Rows of an ``align*`` environment, the places of the rules in comments."""
    page = Page(derivation, Tex())
    rows = [_known(page, known) for known in (*derivation.inputs, *derivation.assumed)]
    for link in derivation.links:
        rows.extend(_rows(page, link))
    return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"


def _known(page: Page, known: Known) -> str:
    return f"  {page.name(known.name)} &= {page.notation.value(known.value)}{_unit(page, known)}"


def _unit(page: Page, known: Known) -> str:
    r"""A unit in upright letters: ``\ \text{rad/s}``."""
    unit = "".join(_ESCAPED.get(character, character) for character in page.unit(known).strip())
    return rf"\ \text{{{unit}}}" if unit else ""


def _rows(page: Page, link: Link) -> Iterator[str]:
    if isinstance(link, Direct):
        yield _direct(page, link)
        return
    for inner in link.order:
        yield _direct(page, inner)
    for closing in link.closing:
        left, right = (page.notation.expression(s) for s in (closing.equation.left, closing.equation.right))
        row = f"  {left} &= {right}{_guards(page, closing.guards)}"
        yield f"  % closes the block: {_place(page, closing.equation)}\n{row}"
    yield from (_known(page, known) for known in iterated(link))


def _direct(page: Page, link: Direct) -> str:
    chain = " = ".join(page.chain(link))
    row = f"  {page.name(link.found.name)} &= {chain}{_unit(page, link.found)}"
    return f"  % {_place(page, link.equation)}\n{row}{_guards(page, link.guards)}"


def _place(page: Page, equation: Equation) -> str:
    return "  ".join(page.rule(equation))


def _guards(page: Page, guards: Sequence[Guard]) -> str:
    said = r",\ ".join(rf"\text{{{word} }} {condition}" for word, condition, _ in page.guards(guards))
    return f" && {said}" if said else ""
