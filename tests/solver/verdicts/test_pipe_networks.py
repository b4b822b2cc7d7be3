"""Networks of pipes, each of which is laminar or turbulent: 2^n cases, one of which has the answer.

Oracle: the flows balance at every junction, and the head lost along every pipe, by the formula for
the Reynolds number at hand, is the difference of the heads at its ends.
"""

from __future__ import annotations

import math

import pytest

import solver
from rulesheets import loads

PIPE = """function pipe(Hx, Hy, Q, D)
parameters L, eps, nu
rules
  v = Q/(pi*D^2/4)
  Re = abs(v)*D/nu
  if Re < 2000 then f*Re = 64 else f = 0.25/log10(eps/(3.7*D) + 5.74/Re^0.9)^2
  Hx - Hy = f*L/D*v*abs(v)/(2*9.81)
"""
H0, ROUGHNESS = 60.0, 0.00015

NINE_PIPES = (
    1.4452082350665266e-05,
    50.0,
    (
        (0, 1, 0.05),
        (0, 2, 0.25),
        (0, 3, 0.05),
        (2, 4, 0.1),
        (3, 5, 0.1),
        (2, 5, 0.25),
        (2, 4, 0.15),
        (3, 5, 0.1),
        (0, 4, 0.2),
    ),
    (0.00183, 0.00024, 0.00024, 0.00391, 0.00592),
)
PARALLEL = (
    8e-06,
    100.0,
    ((0, 1, 0.1), (0, 2, 0.05), (0, 3, 0.1), (0, 2, 0.15), (0, 2, 0.2), (1, 3, 0.08)),
    (0.006, 0.001, 0.0002),
)


def sheet(network) -> str:
    """The heads at the nodes, the first one given, and the flows that leave at the others."""
    nu, length, pipes, drawn = network
    lines = ["variables", f"  H0 = {H0}", f"  L = {length}", f"  eps = {ROUGHNESS}", f"  nu = {nu}"]
    lines += [f"  q{node} = {q}" for node, q in enumerate(drawn, 1)]
    lines += [f"  D{k} = {pipe[2]}" for k, pipe in enumerate(pipes, 1)] + ["rules"]
    for node in range(1, len(drawn) + 1):
        arriving = [f"Q{k}" for k, pipe in enumerate(pipes, 1) if pipe[1] == node]
        leaving = [f"Q{k}" for k, pipe in enumerate(pipes, 1) if pipe[0] == node]
        lines.append(f"  {' + '.join(arriving)} = {' + '.join([f'q{node}', *leaving])}")
    lines += [f"  call pipe(H{a}, H{b}, Q{k}, D{k})" for k, (a, b, _) in enumerate(pipes, 1)]
    return "\n".join(lines) + "\n" + PIPE


def head_lost(flow: float, width: float, length: float, nu: float) -> float:
    v = flow / (math.pi * width**2 / 4)
    reynolds = abs(v) * width / nu
    if reynolds < 2000:
        return 32 * nu * length * v / (9.81 * width**2)
    factor = 0.25 / math.log10(ROUGHNESS / (3.7 * width) + 5.74 / reynolds**0.9) ** 2
    return factor * length / width * v * abs(v) / (2 * 9.81)


def check(network, answer) -> None:
    _, length, pipes, drawn = network
    nu = answer["nu"]
    balance = [0.0] + [-q for q in drawn]
    for k, (a, b, _) in enumerate(pipes, 1):
        flow = answer[f"Q{k}"]
        balance[a], balance[b] = balance[a] - flow, balance[b] + flow
        lost = answer[f"H{a}"] - answer[f"H{b}"]
        assert lost == pytest.approx(
            head_lost(flow, answer[f"D{k}"], length, nu), rel=1e-9, abs=1e-12
        )
    assert balance[1:] == pytest.approx([0.0] * len(drawn), abs=1e-12)


def solved(network, changes=None):
    """The answers, each of which is checked."""
    found = solver.solve(loads(sheet(network)), changes or {})
    assert found.status is solver.Status.SOLVED
    for answer in found.solutions:
        check(network, {**found.inputs, **answer})
    return found.solutions


def test_flows_in_both_regimes():
    assert len(solved(NINE_PIPES)) == 1


def test_a_width_for_a_flow():
    (forward,) = solved(PARALLEL)
    widths = [one["D2"] for one in solved(PARALLEL, {"D2": None, "Q2": forward["Q2"]})]
    assert any(width == pytest.approx(0.05, rel=1e-6) for width in widths)


def test_rows_by_viscosity():
    model = loads(sheet(PARALLEL))
    plan = solver.prepare(model, ["nu"])
    given = {name: variable.value for name, variable in model.variables.items()}
    for share in (1.0, 1.1, 1.2, 0.9, 0.8, 3.0, 2.5):
        nu = share * PARALLEL[0]
        check(PARALLEL, {**given, **dict(zip(plan.want, plan(nu), strict=True)), "nu": nu})


@pytest.mark.parametrize(
    ("network", "given", "cleared", "free"),
    [
        # the only pipe to its node carries what is drawn there, whatever its diameter is
        (NINE_PIPES, "Q1", "D1", {"D1", "H1"}),
        # a flow from the reservoir gives the head at its end, and so the flows beside it
        (PARALLEL, "Q2", "D1", {"D1", "H1", "H3", "Q1", "Q3", "Q6"}),
    ],
    ids=["dead end", "beside"],
)
def test_what_only_the_case_decides_is_not_called_free(
    network, given: str, cleared: str, free: set[str]
) -> None:
    model = loads(sheet(network))
    value = solver.solve(model)[given]
    result = solver.solve(model, {given: value, cleared: None})
    (diagnosis,) = result.diagnoses
    assert (str(result.status), diagnosis.code) == ("partial", "S510")
    assert set(diagnosis.variables) == free
