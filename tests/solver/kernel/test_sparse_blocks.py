"""Blocks of many unknowns, beside a sparse Newton by hand; and where there is no answer."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import rulesheets
import solver
from benchmarks import more_networks as more
from benchmarks.chains import backwater, chemostats, epidemic, osmosis, populations
from benchmarks.networks import (
    Network,
    bratu,
    direct_current,
    gas,
    load_flow,
    pipes,
    plate,
    radiation,
)
from solver.kernel.block import BlockKernel
from solver.kernel.problem import BlockProblem, uncertainty
from solver.kernel.root_check import RootCheck, check_root, root_in_long_floats, sharp_root
from solver.path import SolveBlock
from solver.path.planner import planner

pytestmark = pytest.mark.usefixtures("processor_clock")

NETWORKS = [pipes(5), radiation(60), plate(7), plate(7, 0.02), plate(19), bratu(120)]
NETWORKS += [gas(3), gas(5), direct_current(15), direct_current(40), direct_current(600)]
NETWORKS += [load_flow(5), load_flow(6), load_flow(30)]
NETWORKS += [
    more.compressors(20),
    more.minimal_surface(8),
    more.cable_net(6),
    more.three_phases(20),
]
NETWORKS += [more.complexes(30), more.wall(6), more.dome(14)]


@pytest.mark.parametrize("network", NETWORKS, ids=lambda network: network.title)
def test_the_first_answer_is_that_of_a_newton_by_hand(network: Network) -> None:
    result = solver.solve(rulesheets.loads(network.sheet))
    assert str(result.status) == "solved"
    expected = network.by_hand()
    got = np.array([result[name] for name in network.names])
    assert np.abs(got - expected).max() <= 1e-9 * np.abs(expected).max()


def test_a_list_of_one_answer_does_not_claim_to_be_complete() -> None:
    result = solver.solve(rulesheets.loads(bratu(120).sheet))
    assert not result.complete
    assert [note.code for note in result.gaps] == ["S594"]


def test_a_large_linear_block_has_one_answer() -> None:
    assert solver.solve(rulesheets.loads(plate(19).sheet)).complete


def test_a_guess_leads_to_the_upper_answer() -> None:
    network = bratu(120)
    x = np.arange(1, 121) / 121
    guesses = dict(zip(network.names, (4 * 2.9 * x * (1 - x)).tolist(), strict=True))
    result = solver.solve(rulesheets.loads(network.sheet), guesses=guesses)
    u = np.array([result[name] for name in network.names])
    residual, jacobian = network.system(u)
    assert u.max() > 2.0
    assert np.abs(residual).max() <= 1e-7 * abs(jacobian).tocsr().max()


def test_no_answer_beyond_the_turning_point() -> None:
    result = solver.solve(rulesheets.loads(bratu(120, 4.0).sheet), timeout=5.0)
    assert str(result.status) in ("failed", "infeasible")


def test_a_large_singular_linear_block_is_not_solved() -> None:
    n = 320
    rules = [f"x{i} - x{(i + 1) % n} + 0*x{(i + 7) % n} = 0" for i in range(n)]
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"), timeout=5.0)
    assert str(result.status) != "solved"


def test_a_singular_jacobian_proves_no_root_of_a_large_block() -> None:
    """Differences round a ring say nothing at 1, where each rule misses by 1e-17: there is no
    root."""
    n = 40
    rules = [f"x{(i + 1) % n} = x{i} + (x{i} - 1)^2 + 1e-17" for i in range(n)]
    graph = planner(rulesheets.loads("\n".join(rules) + "\n")).graph
    kernel = BlockKernel(graph, SolveBlock(tuple(range(n)), tuple(f"x{i}" for i in range(n)), ()))
    problem, point = BlockProblem(kernel, {}, {}), {f"x{i}": 1.0 for i in range(n)}
    found = uncertainty(problem, point)
    assert problem.holds(point)
    assert not any(map(math.isfinite, found.errors))
    assert check_root(problem, point, found)[0] is RootCheck.NO_ROOT


@pytest.mark.parametrize("share", [1e-3, 0.5, 30.0])
def test_long_floats_find_the_root_that_many_digits_find(share: float) -> None:
    """From so many error bars beside an answer that is known to seven digits."""
    network = bratu(600)
    model = rulesheets.loads(network.sheet)
    names = tuple(network.names)
    kernel = BlockKernel(planner(model).graph, SolveBlock(tuple(range(1, 601)), names, ()))
    problem = BlockProblem(kernel, {"s": 2.0}, {})
    point = problem.named(network.by_hand().tolist())
    found = uncertainty(problem, point)
    sizes = problem.sizes_at([*point.values()])
    bars = np.array(found.errors)
    start = np.array([*point.values()]) + share * bars * np.sin(np.arange(600))
    sharp = np.array(sharp_root(problem, start.tolist(), sizes))
    near = root_in_long_floats(problem, start.tolist(), found.errors)
    if share > 1.0:
        assert near is None or np.abs(near - sharp).max() <= bars.max()
    else:
        assert near is not None and (np.abs(np.array(near) - sharp) <= 0.1 * bars).all()


def test_a_large_block_may_call_a_function_without_arguments() -> None:
    """Pipes of friction by Colebrook, whose sections are written with pi()."""
    rules = ["p0 = 5e5", "D = 0.2"]
    for k in range(1, 9):
        after = f"q{k + 1}" if k < 8 else "0"
        rules += [
            f"v{k} = q{k}/(pi()/4*D^2)",
            f"1/sqrt(f{k}) = -2*log10(1e-4/3.7 + 2.51/(1e6*v{k}*D*sqrt(f{k})))",
            f"p{k - 1} - p{k} = f{k}*50/D*1000*v{k}^2/2",
            f"q{k} = u{k} + {after}",
            f"u{k} = 0.005*sqrt(p{k}/4e5)",
        ]
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"))
    assert str(result.status) == "solved"
    assert 0.01 < result["f8"] < 0.03


def test_independent_blocks_of_two_answers_each_end_in_good_time() -> None:
    """A nozzle is subsonic or supersonic at each section: 2^40 answers, of which some are
    listed."""
    rules = [f"1.2*M{k}/(1 + 0.2*M{k}^2)^3 = {0.65 - 0.01 * k}" for k in range(40)]
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"), timeout=20.0)
    assert str(result.status) == "solved"
    assert not result.complete


def test_hundreds_of_steps_of_two_answers_each_have_their_answers_in_order() -> None:
    n = 400
    rules = [f"x{k}^2 = {k + 1}" for k in range(n)]
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"), timeout=20.0)
    assert str(result.status) == "solved"
    assert not result.complete
    negative = [[k for k in range(n) if answer[f"x{k}"] < 0.0] for answer in result.solutions[:4]]
    assert negative == [[], [n - 1], [n - 2], [n - 3]]


def test_a_row_of_blocks_of_many_answers_each_has_its_sensible_answer() -> None:
    """Rings of three queues, each ring fed by the one before: 8 answers a ring, all but one
    overloaded."""
    rings, rules, fed = 40, list[str](), "0.4"
    for ring in range(rings):
        for k in range(3):
            before, inflow = f"{ring}_{(k - 1) % 3}", fed if k == 0 else "0"
            here = f"{ring}_{k}"
            rules += [f"lam{here} = 0.3 + 0.45*lam{before} + 0.4*{inflow} - 0.05*L{here}"]
            rules += [
                f"rho{here} = lam{here}/{2 + (ring + k) % 3}",
                f"L{here} = rho{here}/(1 - rho{here})",
            ]
        fed = f"lam{ring}_2"
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"))
    assert str(result.status) == "solved"
    assert not result.complete
    inflow = 0.4
    for ring in range(rings):
        lam = [0.5] * 3
        for _ in range(200):
            for k in range(3):
                rho = lam[k] / (2 + (ring + k) % 3)
                lam[k] = (
                    0.3
                    + 0.45 * lam[k - 1]
                    + (0.4 * inflow if k == 0 else 0.0)
                    - 0.05 * rho / (1 - rho)
                )
        assert all(math.isclose(result[f"lam{ring}_{k}"], lam[k], rel_tol=1e-9) for k in range(3))
        inflow = lam[2]


@pytest.mark.parametrize("steps", [7, 20])
def test_implicit_steps_of_a_reaction_keep_to_positive_concentrations(steps: int) -> None:
    """Robertson's kinetics: three answers a step, in two of which the second species is
    negative."""
    rules, h = ["a0 = 1", "b0 = 0", "c0 = 0"], 0.1
    for i in range(1, steps + 1):
        rules.append(f"a{i} = a{i - 1} + {h}*(1e4*b{i}*c{i} - 0.04*a{i})")
        rules.append(f"b{i} = b{i - 1} + {h}*(0.04*a{i} - 1e4*b{i}*c{i} - 3e7*b{i}^2)")
        rules.append(f"a{i} + b{i} + c{i} = 1")
    result = solver.solve(rulesheets.loads("\n".join(rules) + "\n"))
    assert str(result.status) == "solved"
    a, b = 1.0, 0.0
    for i in range(1, steps + 1):
        x, y = a, max(b, 1e-5)
        for _ in range(50):
            c = 1.0 - x - y
            misses = [
                x - a - h * (1e4 * y * c - 0.04 * x),
                y - b - h * (0.04 * x - 1e4 * y * c - 3e7 * y * y),
            ]
            slopes = [
                [1.0 + h * (1e4 * y + 0.04), -h * 1e4 * (c - y)],
                [-h * (0.04 + 1e4 * y), 1.0 + h * (1e4 * (c - y) + 6e7 * y)],
            ]
            x, y = np.array([x, y]) - np.linalg.solve(slopes, misses)
        a, b = x, y
        assert math.isclose(result[f"a{i}"], a, rel_tol=1e-9)
        assert math.isclose(result[f"b{i}"], b, rel_tol=1e-9)


def test_a_short_row_of_blocks_has_all_the_answers_of_its_quadratic_equations() -> None:
    """Substrate and cells of each tank: (0.5 s - 0.2) (0.3 s0 + 1 - 0.4 s) + 0.54 x0 s = 0, two
    roots."""
    rows = [[(10.0, 0.0)]]
    for _ in range(5):
        longer = []
        for row in rows:
            s0, x0 = row[-1]
            most = 0.3 * s0 + 1.0
            for s in np.roots([-0.2, 0.5 * most + 0.08 + 0.54 * x0, -0.2 * most]):
                longer.append([*row, (s, (most - 0.4 * s) * (0.5 + s) / (1.8 * s))])
        rows = longer
    result = solver.solve(rulesheets.loads(chemostats(5).sheet))
    assert result.complete
    found = sorted([answer[f"s{i}"] for i in range(1, 6)] for answer in result.solutions)
    assert np.allclose(found, sorted([s for s, _ in row[1:]] for row in rows), rtol=1e-8, atol=0.0)


def test_a_sweep_of_a_row_keeps_to_its_sensible_answer() -> None:
    """Of 2^12 answers that in which cells live in every tank, the smaller root of each."""
    text = chemostats(12).sheet.replace("s0 = 10\n", "")
    fed = np.linspace(10.0, 11.0, 5)
    table = solver.prepare(rulesheets.loads(text), inputs=["s0"], want=["x12"]).sweep(fed)
    expected = []
    for s0 in fed:
        s, x = s0, 0.0
        for _ in range(12):
            most = 0.3 * s + 1.0
            s = min(np.roots([-0.2, 0.5 * most + 0.08 + 0.54 * x, -0.2 * most]))
            x = (most - 0.4 * s) * (0.5 + s) / (1.8 * s)
        expected.append(x)
    assert np.allclose(table["x12"], expected, rtol=1e-9, atol=0.0)


ROWS = [backwater(200), chemostats(110), epidemic(30), populations(50), osmosis(100)]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.title)
def test_a_row_of_blocks_has_the_answer_of_a_newton_by_hand_first(row: Network) -> None:
    """Water flows quietly, not shooting; what could have died out lives; salt stays behind."""
    result = solver.solve(rulesheets.loads(row.sheet))
    assert str(result.status) == "solved"
    expected = row.by_hand()
    got = np.array([result[name] for name in row.names])
    assert np.abs(got - expected).max() <= 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("n", [5, 8])
def test_exchangers_in_series_have_their_effectiveness(n: int) -> None:
    """n hot streams cross n cold ones: no start has every logarithm of a quotient of differences
    defined."""
    hot, cold = [250.0 + 5 * i for i in range(n)], [20.0 + 3 * j for j in range(n)]
    lines = [f"h{i}_0 = {v!r}" for i, v in enumerate(hot)] + [
        f"c{j}_0 = {v!r}" for j, v in enumerate(cold)
    ]
    expected = {}
    for i, j in itertools.product(range(n), range(n)):
        one, other, area = 10.0 + i, 12.5 + j, 40.0 / n
        a, b, c, d = f"h{i}_{j}", f"h{i}_{j + 1}", f"c{j}_{i}", f"c{j}_{i + 1}"
        lines += [f"q{i}_{j} = {one}*({a} - {b})", f"q{i}_{j} = {other}*({d} - {c})"]
        lines.append(f"q{i}_{j} = {area}*(({a} - {d}) - ({b} - {c}))/ln(({a} - {d})/({b} - {c}))")
        ratio = math.exp(area * (1 / one - 1 / other))
        heat = (hot[i] - cold[j]) * (ratio - 1) / (ratio / one - 1 / other)
        hot[i], cold[j] = hot[i] - heat / one, cold[j] + heat / other
        expected |= {b: hot[i], d: cold[j]}
    result = solver.solve(rulesheets.loads("\n".join(lines) + "\n"), timeout=5.0)
    assert str(result.status) == "solved"
    assert all(math.isclose(result[name], v, rel_tol=1e-9) for name, v in expected.items())
