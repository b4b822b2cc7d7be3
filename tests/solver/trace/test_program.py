"""A record without the conditions that others imply says what it said with them, of any numbers."""

from __future__ import annotations

import math
import random

import pytest

import rulesheets
import solver
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable
from solver.trace.program import Ending, Program, checks_and_bounds, simplified
from solver.trace.python import compile_scalar

ODD = [
    math.nan,
    math.inf,
    -math.inf,
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    5e-324,
    -1e-310,
    1e-160,
    1e200,
    -1e150,
    30.0,
]
ONE, TWO = ("neg", "abs", "sqrt", "sind", "cosd"), ("add", "sub", "mul", "div", "max")
COMPARED, JOINED = ("lt", "le", "eq"), ("and", "or", "xor")


def numbers(rng: random.Random) -> list[tuple[float, float]]:
    plain = [rng.choice((1.0, 1e-3, 1e4)) * rng.gauss(0.0, 1.0) for _ in range(30)]
    return [(rng.choice((*ODD, *plain)), rng.choice((*ODD, *plain))) for _ in range(60)]


def random_program(rng: random.Random) -> Program:
    flow = Flow()
    nodes = [flow.input(0), flow.input(1), *map(flow.constant, (0.0, 2.0, -3.0, 1e-13))]
    logical: list[int] = []
    for _ in range(rng.randrange(4, 22)):
        kind = rng.choice((*ONE, *TWO, *COMPARED, *COMPARED, *JOINED, "not", "where"))
        try:
            if kind in ONE:
                new = (
                    flow.node(kind, rng.choice(nodes))
                    if kind[3:] == "d"
                    else flow.add(kind, rng.choice(nodes))
                )
                nodes.append(new)
            elif kind in TWO:
                nodes.append(flow.add(kind, rng.choice(nodes), rng.choice(nodes)))
            elif kind in COMPARED:
                logical.append(flow.add(kind, rng.choice(nodes), rng.choice(nodes)))
            elif kind == "where" and logical:
                nodes.append(
                    flow.add(kind, rng.choice(logical), rng.choice(nodes), rng.choice(nodes))
                )
            elif kind in JOINED and logical:
                logical.append(flow.node(kind, rng.choice(logical), rng.choice(logical)))
            elif logical:
                logical.append(flow.add("not", rng.choice(logical)))
        except NotCompilable:
            continue
    results = rng.sample(nodes[2:], 2)
    holds = [rng.choice((node, flow.add("not", node))) for node in logical if rng.random() < 0.6]
    known = (flow.true, flow.false)
    checks = tuple(node for node in (*holds, *flow.checks) if node not in known)
    finite = tuple(
        n for n in nodes if flow.value_of(n) is None and (n in results or rng.random() < 0.4)
    )
    bounds = (flow.node("finite", number) for number in finite)
    return Program(flow, 2, (Ending(tuple(results), (*checks, *bounds)),))


@pytest.mark.parametrize("seed", range(40))
def test_a_lean_program_says_what_the_whole_one_says(seed: int) -> None:
    rng = random.Random(seed)
    told = 0
    for _ in range(25):
        program = random_program(rng)
        whole, short = compile_scalar(program), compile_scalar(simplified(program))
        for pair in numbers(rng):
            assert whole(*pair) == short(*pair), (program, pair)
            told += whole(*pair) is not None
    assert told


def test_of_a_slider_crank_little_is_left_to_ask() -> None:
    plan = solver.prepare(
        rulesheets.load("offset_slider_crank"), ["thetaAO"], ["xB", "vB", "omegaAB"]
    )
    plan(-30.0)
    (program,) = plan.records.programs
    assert [len(some) <= 3 for some in checks_and_bounds(program.flow, program.holds)] == [
        True,
        True,
    ]
