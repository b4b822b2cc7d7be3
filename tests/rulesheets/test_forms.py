"""Rules read as others of their shape: the trees, places included, that the grammar makes."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.diagnosis import RuleSheetError
from rulesheets.parse import parse
from rulesheets.parse.grammar import grammar
from rulesheets.syntax import Source, Span, forms
from rulesheets.syntax.nodes import Node

names = st.sampled_from(["a", "b2", "T_1", "Tα", "pi", "If_", "E", "e5", "mod", "in"])
numbers = st.sampled_from(["0", "1", "2.5", ".5", "3.", "1e3", "2E-4", "0e7", "007"])
leaves = names | numbers | names.map("({})".format) | numbers.map("-{}".format)


def _above(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    two = st.tuples(inner, st.sampled_from(["+", " - ", "*", " /", "^", " "]), inner).map("".join)
    call = st.tuples(st.sampled_from(["sin", "Sqrt", "f"]), inner).map(lambda p: f"{p[0]}({p[1]})")
    return two | call | inner.map("( {} )".format) | inner.map("-{}".format)


expressions = st.recursive(leaves, _above, max_leaves=6)


@given(st.lists(st.tuples(expressions, expressions).map(" = ".join), min_size=1, max_size=4))
def test_the_trees_of_the_grammar(rules: list[str]) -> None:
    text = "\n".join(rules * 3) + "\n"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(forms, "LONG", len(text))
        expected = _read(text)
        patch.setattr(forms, "LONG", 0)
        grammar().forms.clear()
        assert _read(text) == expected


@pytest.mark.parametrize("terms", [1, 20])  # of a balance at a node with many neighbours
def test_other_names_and_numbers(terms: int, monkeypatch: pytest.MonkeyPatch) -> None:
    every = [" + ".join([f"2*(x{k} - {k}.5e-{k}) + sin( y_{k} )^2"] * terms) for k in range(1, 100)]
    rules = [f"{left} = (-z{k})/{k}" for k, left in enumerate(every, 1)]
    text = "\n".join(rules) + "\n"
    monkeypatch.setattr(forms, "LONG", len(text))
    expected = _read(text)
    monkeypatch.setattr(forms, "LONG", 0)
    grammar().forms.clear()
    assert _read(text) == expected
    (form,) = grammar().forms.values()
    assert form is not None


@pytest.mark.parametrize("number", ["1e999", "1e-999"])
def test_a_number_out_of_range_is_told(number: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forms, "LONG", 0)
    with pytest.raises(RuleSheetError, match="out of range"):
        parse(Source("x", "".join(f"x{k} = {n}\n" for k, n in enumerate(["1", "2", "3", number]))))


def _read(text: str) -> Any:
    try:
        return _tree(parse(Source("x", text)).rules)
    except RuleSheetError as error:
        return str(error)


def _tree(node: Any) -> Any:
    if isinstance(node, Span):
        return node.start, node.end
    if isinstance(node, Node):
        return type(node).__name__, *(_tree(getattr(node, f)) for f in node.__match_args__ if f != "like")
    return tuple(map(_tree, node)) if isinstance(node, tuple) else node
