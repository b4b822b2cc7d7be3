"""The same question gives the same bits: after any other questions, in any order, and in any
thread."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeAlias

import pytest

import rulesheets
import solver
from rulesheets.model import Value
from solver.solution.solving import Result

MODELS = Path(__file__).parents[2] / "models"

Question: TypeAlias = tuple[dict[str, Value | None], tuple[str, ...] | None]
Sheet: TypeAlias = Callable[[], rulesheets.Model]

PRECISE = """\
variables
  a = 3
  b = 4
rules
  (x - a)^2 + (y - b)^2 = 25
  x*y = c
  c = 1e-9*erf(a) + 0.3
  z^3 - 3*z + b = jn(2, x) + exp(-a*y)
"""
DELICATE = """\
variables
  t = 20
  r = 2
  l = 5
rules
  u = tanh(t) + s
  s = sin(pi()*r) - 1
  (w - r*cosd(v))^2 + (r*sind(v))^2 = l^2
  w = 7 - 1e-14*l
"""
WRITTEN = {"precise": PRECISE, "delicate": DELICATE}

QUESTIONS: dict[str, list[Question]] = {
    "offset_slider_crank": [
        *(({"thetaAO": angle}, None) for angle in (-30.0, -31.0, 47.5, 180.0)),
        *(({"xB": place, "thetaAO": None}, None) for place in (9.79, 5.0)),
        ({"thetaAO": -31.0}, ("vB",)),
        ({"thetaAO": -30.0, "branch": "crossed"}, None),
        (
            {
                "xB": 9.79,
                "vB": -40.0,
                "aB": 100.0,
                "thetaAO": None,
                "omegaAO": None,
                "alphaAO": None,
            },
            None,
        ),
        ({"xB": 100.0, "thetaAO": None}, None),
    ],
    "colebrook": [
        *(({"v": speed}, None) for speed in (1.0, 1.25, 0.5)),
        ({"hf": 2.0, "v": None}, None),
        ({"hf": 2.0, "D": None}, None),
        ({"f": 0.02, "k": None}, None),
        ({"v": 1.25}, ("Re",)),
    ],
    "precise": [({"a": a, "b": b}, None) for a in (3.0, 2.5) for b in (4.0, 1e-3)],
    "delicate": [({"t": t, "r": r}, None) for t in (20.0, 30.0) for r in (2.0, 1.5)],
}


def load(name: str) -> rulesheets.Model:
    if name in WRITTEN:
        return rulesheets.loads(WRITTEN[name])
    return rulesheets.load(str(MODELS / name / "model.tk"))


def bits(result: Result) -> object:
    """All that a result says, floats to the last bit."""
    return (
        result.status,
        result.complete,
        result.undetermined,
        [
            {n: v.hex() if isinstance(v, float) else v for n, v in s.items()}
            for s in result.solutions
        ],
        [{n: e.hex() for n, e in solution.error.items()} for solution in result.solutions],
        [(str(d.code), d.message, d.notes) for d in result.diagnoses],
        {name: [attempt.method for attempt in tried] for name, tried in result.attempts.items()},
    )


def asked(model: rulesheets.Model, question: Question) -> object:
    inputs, want = question
    return bits(solver.solve(model, inputs, want=want))


@pytest.fixture(scope="module")
def fresh() -> dict[tuple[str, int], object]:
    """What a model says that was asked nothing before."""
    return {
        (name, k): asked(load(name), question)
        for name, questions in QUESTIONS.items()
        for k, question in enumerate(questions)
    }


@pytest.mark.parametrize("seed", range(2))
def test_after_any_other_questions(fresh: dict[tuple[str, int], object], seed: int) -> None:
    dice = random.Random(seed)
    models = {name: load(name) for name in QUESTIONS}
    order = [(name, k) for name, questions in QUESTIONS.items() for k in range(len(questions))] * 2
    dice.shuffle(order)
    for name, k in order:
        assert asked(models[name], QUESTIONS[name][k]) == fresh[name, k]


def test_in_any_thread(fresh: dict[tuple[str, int], object]) -> None:
    """All at once, on models that the threads share."""
    models = {name: load(name) for name in QUESTIONS}
    order = [(name, k) for name, questions in QUESTIONS.items() for k in range(len(questions))] * 2
    random.Random(4).shuffle(order)
    together = threading.Barrier(4)

    def some(share: list[tuple[str, int]]) -> list[tuple[str, int]]:
        together.wait()
        return [
            (name, k)
            for name, k in share
            if asked(models[name], QUESTIONS[name][k]) != fresh[name, k]
        ]

    with ThreadPoolExecutor(4) as threads:
        different = list(threads.map(some, (order[k::4] for k in range(4))))
    assert different == [[]] * 4
