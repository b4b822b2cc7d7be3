"""Rules read as others of their shape: the trees that the grammar makes, in the place of the
rule."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets.parse.grammar as lines
from rulesheets import loads
from rulesheets.diagnosis import RuleSheetError
from rulesheets.parse.grammar import grammar
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import Node, Operators

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
        patch.setattr(lines, "LONG", len(text))
        expected = _read(text)
        patch.setattr(lines, "LONG", 0)
        grammar().forms.clear()
        assert _read(text) == expected


@pytest.mark.parametrize("terms", [1, 20])  # of a balance at a node with many neighbours
def test_other_names_and_numbers(terms: int, monkeypatch: pytest.MonkeyPatch) -> None:
    every = [" + ".join([f"2*(x{k} - {k}.5e-{k}) + sin( y_{k} )^2"] * terms) for k in range(1, 100)]
    rules = [f"{left} = (-z{k})/{k}" for k, left in enumerate(every, 1)]
    text = "\n".join(rules) + "\n"
    monkeypatch.setattr(lines, "LONG", len(text))
    expected = _read(text)
    monkeypatch.setattr(lines, "LONG", 0)
    grammar().forms.clear()
    assert _read(text) == expected
    (form,) = grammar().forms.values()
    assert form is not None


@pytest.mark.parametrize("number", ["1e999", "1e-999"])
def test_a_number_out_of_range_is_told(number: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "LONG", 0)
    with pytest.raises(RuleSheetError, match="out of range"):
        parse(Source("x", "".join(f"x{k} = {n}\n" for k, n in enumerate(["1", "2", "3", number]))))


FUNCTIONS = """
function f(x; y)
rules
y = x^2 + 1
function g(a, b; p, q)
parameters c
rules
p = a + b*c
if a > b then q = sin(a)*f(b) else (q, z) = (a - 2, f(f(a)))
z = 3
function h(u; v)
parameters c
rules
call g(u, u; v, 2*w)
w = f(u + pi)
v > 0
"""
CALLS = [
    "x{k} = f(y{k}) + {k}.5*f(f(2)) - h((z{k}))",
    "(x{k}, y) = g({k}, -y{k})",
    "g({k}, y{k}) = (a{k}, b{k})",
    "call g(f(x{k}), y{k}; x, {k}*y{k})",
    "call sin(x{k}; y{k}*2)",
    "if x{k} > {k} then y{k} = f(x{k}) else call h(x; y{k})",
    "f(x{k}) = f(x{k})",
]


@pytest.mark.parametrize("wrong", ["", "x{k} = f(1, {k})", "y = k(x{k})", "f = x{k}"])
def test_calls_are_expanded_as_one_by_one(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rules = [rule.format(k=k) for k in range(1, 6) for rule in (*CALLS, wrong)]
    text = "\n".join(["c = 2", *rules]) + FUNCTIONS
    monkeypatch.setattr(lines, "LONG", 0)
    by_form = _model(text)
    monkeypatch.setattr(lines, "LONG", len(text))
    assert by_form == _model(text)


def test_a_pickled_model_keeps_its_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "LONG", 0)
    model = loads("".join(f"x{k} = 2*y{k}\n" for k in range(9)))
    again = pickle.loads(pickle.dumps(model))
    assert again.equations == model.equations


def _model(text: str) -> Any:
    try:
        model = loads(text)
    except RuleSheetError as error:
        return [(one.code, one.message, one.labels[0].span.line) for one in error.diagnoses]
    equations = [_tree((e.left, e.right, e.guard, e.rule, e.scope)) for e in model.equations]
    return equations, [*model.variables.values()], _tree(model.conditions), model.requirements


def _read(text: str) -> Any:
    try:
        return _tree(parse(Source("x", text)).rules)
    except RuleSheetError as error:
        return str(error)


def _tree(node: Any) -> Any:
    if isinstance(node, Span):
        return node.start, node.end
    if isinstance(node, Node):
        told = {"like", "span"} if isinstance(node, Operators) else {"like"}
        return type(node).__name__, *(
            _tree(getattr(node, f)) for f in node.__match_args__ if f not in told
        )
    return tuple(map(_tree, node)) if isinstance(node, tuple) else node
