"""Results built by hand: what a report is given, without a solve."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from rulesheets.diagnosis import Diagnosis, Label, Severity
from rulesheets.model import Equation, Model, Value, Variable
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import Call, Name, Number, Power, Sum
from solver.facts import Status
from solver.path import Evaluate, Path
from solver.solution.solving import Result, Solution

SOURCE = Source("sheets/hypotenuse.tk", "c^2 =  a^2 + b^2\nangle = atan2d(b, a)\n")

RULES = (Span(SOURCE, 0, 16), Span(SOURCE, 17, 37))


def square(name: str) -> Power:
    return Power(Name(name), Number(2.0))


def model() -> Model:
    """A right triangle: c from a and b, and a local angle."""
    variables = (
        Variable("a", value=3.0, unit="mm", posted=True, comment="one leg"),
        Variable("b", value=4.0, unit="mm", posted=True, comment="the other leg"),
        Variable("c", guess=1.0, unit="mm", posted=True, comment="hypotenuse"),
        Variable("kind", value="right", posted=True),
        Variable("f.angle"),
    )
    angle = Call("atan2d", (Name("b"), Name("a")))
    equations = (
        Equation(0, square("c"), Sum((square("a"), square("b"))), (), RULES[0]),
        Equation(1, Name("f.angle"), angle, (), RULES[1], scope="f."),
    )
    return Model("hypotenuse", {v.name: v for v in variables}, equations, ())


GIVEN: Mapping[str, Value] = {"a": 3.0, "b": 4.0, "kind": "right"}

PATH = Path((Evaluate(0, "c", 2), Evaluate(1, "f.angle")))


@pytest.fixture
def solved() -> Result:
    """c = 5, or -5."""
    both = ({**GIVEN, "c": c, "f.angle": 53.13010235415598} for c in (5.0, -5.0))
    return Result(
        model=model(),
        status=Status.SOLVED,
        solutions=tuple(Solution(answer, 1.2e-16, 2) for answer in both),
        complete=True,
        inputs=GIVEN,
        guesses={"c": 1.0},
        wanted=("a", "b", "c", "kind"),
        undetermined=(),
        explain=tuple,
        path=PATH,
    )


@pytest.fixture
def unsolved() -> Result:
    """b is not given, and a diagnosis points at the first rule."""
    inputs: Mapping[str, Value] = {"a": 3.0, "kind": "right"}
    diagnosis = Diagnosis(
        "S501",
        Severity.ERROR,
        "b and c are not determined",
        (Label(RULES[0], "waits for two"),),
        ("give b or c",),
        ("b", "c"),
    )
    return Result(
        model=model(),
        status=Status.PARTIAL,
        solutions=(),
        complete=False,
        inputs=inputs,
        guesses={"c": 1.0},
        wanted=("a", "b", "c", "kind"),
        undetermined=("b", "c"),
        explain=lambda: (diagnosis,),
        path=Path((), ("b", "c", "f.angle")),
        partial=inputs,
    )
