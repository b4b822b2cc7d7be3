"""``why`` a number is what it is, line by line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rulesheets.model import Equation
from solver.derivation import Derivation, Direct, Guard, Together
from solver.report.notation import Plain, Tex
from solver.report.why import Page, iterated


def derived(derivation: Derivation) -> dict[str, Any]:
    """The inputs that a number rests on, then every step with its formula, its rule and its conditions."""
    page = Page(derivation, Tex())
    given = [page.known(known) for known in (*derivation.inputs, *derivation.assumed)]
    lines = [line for link in derivation.links for line in _lines(page, link)]
    return {"head": page.head(), "given": given, "lines": lines}


def _lines(page: Page, link: Direct | Together) -> Iterator[dict[str, Any]]:
    if isinstance(link, Direct):
        yield _direct(page, link)
        return
    for inner in link.order:
        yield _direct(page, inner, within=True)
    for closing in link.closing:
        sides = (closing.equation.left, closing.equation.right)
        formula = " = ".join(page.notation.expression(side) for side in sides)
        yield _line(page, formula, closing.equation, closing.guards, within=True)
    for known in iterated(link):
        value = page.notation.value(known.value)
        yield {"tex": f"{page.name(known.name)} = {value}", "unit": page.unit(known), "within": True}


def _direct(page: Page, link: Direct, within: bool = False) -> dict[str, Any]:
    formula = " = ".join((page.name(link.found.name), *page.chain(link)))
    return _line(page, formula, link.equation, link.guards, within) | {"unit": page.unit(link.found)}


def _line(
    page: Page, formula: str, equation: Equation, guards: tuple[Guard, ...], within: bool
) -> dict[str, Any]:
    place, rule = page.rule(equation)
    because = [f"{word} {said}" for word, said in _conditions(guards)]
    return {"tex": formula, "unit": "", "place": place, "rule": rule, "because": because, "within": within}


def _conditions(guards: tuple[Guard, ...]) -> Iterator[tuple[str, str]]:
    for word, assumed in (("because", False), ("assuming", True)):
        outcomes = [(guard.condition, guard.holds) for guard in guards if guard.assumed is assumed]
        if outcomes:
            yield word, Plain().conditions(outcomes)
