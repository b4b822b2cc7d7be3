"""The chain behind a number: complete, in order, no longer than needed, and true."""

from __future__ import annotations

import math

import pytest

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from rulesheets.evaluate import value
from rulesheets.format import format_expression
from rulesheets.syntax.nodes import names
from solver.report.derivation import Derivation, Line, why


def derive(text: str, name: str, inputs: dict[str, float | str | None] | None = None) -> Derivation:
    return why(solver.solve(rulesheets.loads(text), inputs), name)


def direct(derivation: Derivation) -> list[Line]:
    """Every line that gives an unknown by an equation, those inside blocks included."""
    return [
        line
        for link in derivation.links
        for line in link.lines
        if line.unknown and line.equation is not None
    ]


def form(derivation: Derivation, name: str) -> str:
    line = next(line for line in direct(derivation) if line.unknown == name)
    assert line.form is not None
    return format_expression(line.form)


def found(derivation: Derivation) -> list[str]:
    return [name for link in derivation.links for name in link.unknowns]


# --- on the slider crank --------------------------------------------------------

CRANK = rulesheets.load("offset_slider_crank")


def test_forward_the_chain_is_what_the_number_needs() -> None:
    chain = why(solver.solve(CRANK), "xB")
    assert list(chain.inputs) == ["branch", "AO", "AB", "offset", "thetaAO"]
    assert found(chain) == ["position.yB", "xA", "position.yA", "xB"]
    assert form(chain, "xA") == "AO*cosd(thetaAO)"
    (guard,) = chain.links[-1].lines[-1].guards
    assert (guard.holds, guard.assumed, guard.read) == (True, False, ("branch",))


def test_crossed_the_chain_takes_the_other_arm() -> None:
    chain = why(solver.solve(CRANK, {"branch": "crossed"}), "xB")
    assert form(chain, "xB") == "-sqrt(AB^2 - (position.yB - position.yA)^2) + xA"
    assert [guard.holds for guard in direct(chain)[-1].guards] == [False]


def test_driven_by_the_slider_the_crank_angle_comes_from_a_block() -> None:
    chain = why(solver.solve(CRANK, {"xB": 9.79, "thetaAO": None}), "vB")
    (block,) = (link for link in chain.links if link.tears)
    assert set(block.unknowns) == {"thetaAO", "xA", "position.yA"}
    assert block.tears == ("thetaAO",)
    assert "thetaAO" not in chain.inputs and "xB" in chain.inputs
    assert "alphaAO" not in chain.inputs


@pytest.mark.parametrize("inputs", [{}, {"xB": 9.79, "thetaAO": None}, {"branch": "crossed"}])
@pytest.mark.parametrize("name", ["xB", "vB", "omegaAB", "aB", "alphaAB"])
def test_a_chain_can_be_followed_by_hand(inputs: dict[str, float | str | None], name: str) -> None:
    """Every form, evaluated at what the chain has told before, gives the number that it says."""
    result = solver.solve(CRANK, inputs)
    chain = why(result, name)
    known = {name: chain.values[name] for name in chain.inputs}
    for link in chain.links:
        known.update((name, chain.values[name]) for name in link.tears)
        for line in (line for line in link.lines if line.unknown and line.equation is not None):
            assert line.form is not None and line.unknown is not None
            assert set(names(line.form)) <= known.keys()
            told = chain.values[line.unknown]
            assert value(line.form, known) == pytest.approx(told, rel=1e-12, abs=1e-12)
            known[line.unknown] = told
    assert known[name] == result[name]


# --- forms ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rule", "guess", "expected"),
    [
        ("x^2 = 16", 1, "sqrt(16)"),
        ("x^2 = 16", -1, "-sqrt(16)"),
        ("sind(x) = 0.5", 30, "asind(0.5)"),
        ("sind(x) = 0.5", 150, "180 - asind(0.5)"),
        ("abs(x) = 3", -2, "-3"),
        ("x^2 - 5*x + 6 = 0", 1, "(5 - sqrt((-5)^2 - 4*6))/2"),
    ],
)
def test_the_form_is_that_of_the_answer_taken(rule: str, guess: float, expected: str) -> None:
    result = solver.solve(rulesheets.loads(rule), guesses={"x": guess})
    link = direct(why(result, "x"))[0]
    assert link.form is not None
    assert value(link.form, {}) == pytest.approx(result["x"])
    oracle = rulesheets.loads(f"x = {expected}")
    assert solver.solve(oracle)["x"] == pytest.approx(value(link.form, {}))


@pytest.mark.parametrize(
    ("rule", "whole"), [("sind(t) = 0.5", 390.0), ("sin(t) = 0.5", math.pi * 13 / 6)]
)
def test_whole_turns_are_part_of_the_form(rule: str, whole: float) -> None:
    low, high = whole - 0.1, whole + 0.1
    chain = derive(f"variables\n  t in [{low}, {high}]\nrules\n  {rule}", "t")
    assert chain.value == pytest.approx(whole)
    assert form(chain, "t") in ("asind(0.5) + 360", "asin(0.5) + 2*pi")


def test_a_function_is_run_backwards_through_its_inverse() -> None:
    chain = derive("y = twice(x)\ny = 5\nfunction twice(a; b)\nrules\n  b = 2*a", "x")
    assert math.isclose(float(chain.value or 0), 2.5)
    assert found(chain)[0] == "y" and found(chain)[-1] == "x"


# --- guards ---------------------------------------------------------------------


def test_a_guard_brings_in_what_it_reads() -> None:
    chain = derive("a = 2\nb = a + 1\nc = 9\nif b > 1 then y = 7 else y = c", "y")
    assert found(chain) == ["a", "b", "y"]


def test_a_guard_that_waits_on_the_answer_is_told_as_assumed() -> None:
    chain = derive("y = 5\nif x > 0 then y = x + 1 else y = x - 1", "x")
    (guard,) = direct(chain)[-1].guards
    assert guard.assumed and guard.holds
    assert chain.value == 4.0


def test_of_several_rules_the_one_whose_guard_held_is_told() -> None:
    text = "a = -3\nb = a\nif b > 0 then y = 1\nif b <= 0 then y = 2"
    chain = derive(text, "y")
    (equation,) = (line.equation for line in direct(chain)[-1:])
    assert equation is not None and equation.rule.line == 4


def test_a_symbol_from_a_case_is_told_as_such() -> None:
    rules = "if mode = 'hot then r = 1\nif mode = 'hot then z = 2\nif mode <> 'hot then r = 2"
    chain = derive(rules, "z", {"r": 1.0})
    assert (chain.assumed, chain.values["mode"]) == (("mode",), "hot")


# --- no chain -------------------------------------------------------------------


def test_an_input_has_no_chain() -> None:
    chain = why(solver.solve(CRANK), "AO")
    assert (chain.value, chain.links, list(chain.inputs)) == (3.0, (), ["AO"])


def test_what_has_no_value_has_reasons() -> None:
    chain = derive("a + b = 3\nc = 1", "a")
    assert chain.value is None
    assert [diagnosis.code for diagnosis in chain.diagnoses] == ["S510"]
    assert derive("a + b = 3\nc = 1", "c").value == 1.0


def test_an_unknown_name_is_refused_with_a_suggestion() -> None:
    with pytest.raises(RuleSheetError) as wrong:
        why(solver.solve(CRANK), "omegaAb")
    assert wrong.value.diagnoses[0].code == "E407"
    assert "did you mean omegaAB?" in wrong.value.diagnoses[0].notes


def test_the_front_door_has_it() -> None:
    assert solver.why is why
