"""Blocks that differ in names alone share what is found out about them, and nothing else does."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from solver.kernel import enclosure
from solver.kernel.block import BlockKernel
from solver.path import SolveBlock
from solver.path.graph import ModelGraph
from solver.path.planner import planner

STAGE = """
function stage(Vin; Vc)
parameters Is, Vt, beta, Vcc
rules
(Vin - Vb)/10e3 = Ib + Vb/10e3
Ic = Is*exp((Vb - Ve)/Vt)
Ic = beta*Ib
Ve = 1e3*(Ic + Ib)
(Vcc - Vc)/2e3 = Ic
"""
GIVEN = "Is = 1e-14\nVt = 0.02585\nbeta = 150\nVcc = 12\n"


def stages(inputs: list[float]) -> dict[int, float]:
    calls = "".join(f"V{k} = {v!r}\ncall stage(V{k}; W{k})\n" for k, v in enumerate(inputs))
    result = solver.solve(rulesheets.loads(GIVEN + calls + STAGE))
    assert str(result.status) == "solved"
    return {k: result[f"W{k}"] for k in range(len(inputs))}


def test_blocks_that_share_their_code_have_the_answers_that_they_have_alone() -> None:
    inputs = [1.7, 2.0, 2.3, 3.1]
    assert stages(inputs) == {k: stages([v])[0] for k, v in enumerate(inputs)}


def test_stages_that_are_called_again_are_worked_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, slope_chain = [], enclosure.slope_chain
    monkeypatch.setattr(
        enclosure, "slope_chain", lambda chain: asked.append(chain) or slope_chain(chain)
    )
    stages([1.5 + 0.01 * k for k in range(20)])
    assert len(asked) == 1


def kernels(sheet: str) -> list[BlockKernel]:
    model = rulesheets.loads(sheet)
    known = frozenset(name for name, v in model.variables.items() if v.value is not None)
    path = planner(model).path(known, {})
    blocks = [step for step in path.steps if isinstance(step, SolveBlock)]
    graph = ModelGraph(model)
    return [BlockKernel(graph, block) for block in blocks]


BLOCK = "x{k} + {a}*y{k}^3 = c\nexp(x{k}) - {b}*y{k} = c{more}\n"


@pytest.mark.parametrize(
    ("other", "ranges", "same"),
    [
        ({}, "", True),
        ({"a": "3"}, "", False),
        ({"more": " - x{k}"}, "", False),
        ({}, "\n x2 >= 0", False),
    ],
)
def test_what_tells_blocks_apart(other: dict[str, str], ranges: str, same: bool) -> None:
    texts = [{"a": "2", "b": "5", "more": ""}, {"a": "2", "b": "5", "more": ""} | other]
    rules = "".join(
        BLOCK.format(k=k, **{name: text.format(k=k) for name, text in texts[k - 1].items()})
        for k in (1, 2)
    )
    one, two = kernels(f"variables\n c = 4{ranges}\nrules\n{rules}")
    assert (one._shared is two._shared) == same
