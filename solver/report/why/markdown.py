"""A derivation as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from rulesheets.model import Equation
from solver.derivation import Derivation, Direct, Guard, Known, Together
from solver.report.notation import Tex, equation
from solver.report.why.page import Page, iterated


def why_markdown(derivation: Derivation) -> str:
    """The same as a numbered list; mathematics between dollars, rules as code."""
    page = Page(derivation, Tex())
    parts = [page.head(code_span)]
    if derivation.inputs and derivation.links:
        parts.append("Given:\n\n" + "\n".join(_known(page, derivation.inputs)))
    if derivation.assumed:
        parts.append("Case by case:\n\n" + "\n".join(_known(page, derivation.assumed)))
    if derivation.links:
        parts.append("\n".join(_lines(page)))
    return "\n\n".join(parts)


_SPECIAL = re.compile(r"([\\`*_\[\]<>|$~&])")


def _text(text: str) -> str:
    """Words of a sheet as themselves: no emphasis, no links, no HTML."""
    return _SPECIAL.sub(r"\\\1", text)


def code_span(text: str) -> str:
    """A code span, between more backticks than there are in the text."""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    pad = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{fence}{pad}{text}{pad}{fence}"


def _known(page: Page, knowns: Iterable[Known]) -> Iterator[str]:
    for known in knowns:
        comment = page.model.variables[known.name].comment
        yield f"- {_math(page, known)}" + (f": {_text(comment)}" if comment else "")


def _math(page: Page, known: Known) -> str:
    return f"${page.name(known.name)} = {page.notation.value(known.value)}${_text(page.unit(known))}"


def _lines(page: Page) -> Iterator[str]:
    for number, link in enumerate(page.derivation.links, 1):
        margin = " " * len(f"{number}. ")
        first, *rest = _direct(page, link) if isinstance(link, Direct) else _together(page, link)
        yield f"{number}. {first}"
        yield from (margin + line if line else "" for line in rest)


def _direct(page: Page, link: Direct) -> Iterator[str]:
    chain = " = ".join((page.name(link.found.name), *page.chain(link)))
    yield f"${chain}${_text(page.unit(link.found))}  "
    yield from _rule(page, link.equation, link.guards)


def _rule(page: Page, equation: Equation, guards: Sequence[Guard]) -> Iterator[str]:
    place, rule = page.rule(equation)
    lines = [f"{code_span(rule)} ({_text(place)})"]
    for word, condition, read in page.guards(guards):
        lines.append(f"{word} ${condition}$" + (f" ({code_span(read)})" if read else ""))
    yield from (line + "  " for line in lines[:-1])
    yield lines[-1]


def _together(page: Page, link: Together) -> Iterator[str]:
    yield _heading(page, link)
    yield ""
    for inner in link.order:
        yield from _item(_direct(page, inner))
    for closing in link.closing:
        head = f"such that ${equation(page.notation, closing.equation)}$  "
        yield from _item((head, *_rule(page, closing.equation, closing.guards)))
    for known in iterated(link):
        yield f"- which gives {_math(page, known)}"


def _heading(page: Page, link: Together) -> str:
    names, tears = (
        ", ".join(f"${page.name(name)}$" for name in group)
        for group in ((known.name for known in link.found), link.tears)
    )
    return f"{names} by iteration:" if len(link.found) == 1 else f"{names} together, iterating on {tears}:"


def _item(lines: Iterable[str]) -> Iterator[str]:
    first, *rest = lines
    yield f"- {first}"
    yield from (f"  {line}" for line in rest)
