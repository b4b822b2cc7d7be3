"""What the page shows of a model and a result: typeset cases, of which the first that applies
holds; warnings of units, as in the terminal and in a notebook."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import product

import pytest

import rulesheets
import solver
from solver.page.description import answered, typeset
from solver.report.html import html

LINE = re.compile(r"y = (\d+)(?: \\quad \\text\{(if|else if|otherwise) \} (.*))?")


def trees(depth: int, names: str) -> Iterator[str | None]:
    """Rules for ``y`` by conditions on the names, also without ``else``."""
    yield "y = #"
    if depth:
        inner = [tree for tree in trees(depth - 1, names[1:]) if tree]
        for then, other in product(inner, [*inner, None]):
            end = f" else ({other})" if other else ""
            yield f"if {names[0]} > 0 then ({then}){end}"


@pytest.mark.parametrize("tree", [one for one in trees(2, "ab") if one and "if" in one])
def test_the_first_case_that_applies_is_the_active_one(tree: str) -> None:
    for number in range(tree.count("#")):
        tree = tree.replace("#", str(number), 1)
    model = rulesheets.loads(tree)
    (lines,) = typeset(model)
    for a, b in product((False, True), repeat=2):
        active = [e.right for e in model.equations if all(_holds(model, p, a, b) for p in e.guard)]
        assert _first(lines, a, b) == (active[0].value if active else None)  # type: ignore[union-attr]


def _holds(model: rulesheets.Model, premise: tuple[int, bool], a: bool, b: bool) -> bool:
    name = model.conditions[premise[0]].left.name  # type: ignore[union-attr]
    return {"a": a, "b": b}[name] is premise[1]


def _first(lines: list[str], a: bool, b: bool) -> float | None:
    for line in lines:
        number, word, said = re.fullmatch(LINE, line).groups()  # type: ignore[union-attr]
        text = re.sub(r"\\text\{([^}]*)\}|\\left|\\right", r"\1", said or "True")
        if word in (None, "otherwise") or eval(text, {"a": int(a), "b": int(b)}):
            return float(number)
    return None


def test_warnings_of_units_stand_beside_the_answer() -> None:
    text = "variables\n  P = 5 [kW]\n  T [N-m]\n  w = 10 [rad/s]\nrules\n  P = T*w"
    result = solver.solve(rulesheets.loads(text))
    assert result.diagnoses == ()
    told = answered(result)
    assert [one["code"] for one in told["diagnoses"]] == ["W601"]
    assert told["rules"][0]["state"] == "used"
    assert "give P in W" in html(result)
