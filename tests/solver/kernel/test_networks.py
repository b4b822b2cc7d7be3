"""Networks that need more than a plain Newton step: their answers beside the laws written out
here."""

from __future__ import annotations

import math
import tracemalloc
from itertools import pairwise, product, starmap

import numpy as np
import pytest
from scipy.optimize import brentq

import rulesheets
import solver
from benchmarks.networks import bratu
from solver.kernel.block import BlockKernel
from solver.kernel.candidates import Candidates
from solver.kernel.problem import BlockProblem
from solver.numerics.linear_algebra import Array, factorise, sparse_matrix
from solver.numerics.sparse_newton import Triplets, sparse_newton
from solver.path import SolveBlock
from solver.path.graph import ModelGraph

pytestmark = pytest.mark.usefixtures("processor_clock")


def _solved(lines: list[str]) -> solver.Result:
    result = solver.solve(rulesheets.loads("\n".join(lines) + "\n"), timeout=5.0)
    assert str(result.status) == "solved"
    return result


def test_friction_factors_do_not_hold_back_the_flows_of_water() -> None:
    """A grid of 15 nodes between two reservoirs, with the friction of Swamee and Jain."""
    number = {place: k for k, place in enumerate(product(range(5), range(3)))}
    pipes = [(k, number[i + 1, j]) for (i, j), k in number.items() if i < 4]
    pipes += [(k, number[i, j + 1]) for (i, j), k in number.items() if j < 2]
    lines = ["nu = 1e-6", "rough = 1e-4", "g = 9.81", "H0 = 80", "H14 = 78"]
    balance = {node: ["-0.02"] for node in range(1, 14)}
    for k, (a, b) in enumerate(pipes):
        lines.append(f"call pipe(H{a}, H{b}, {90 + 17 * k}, {0.2 + 0.02 * (k % 7)}; Q{k})")
        for node, term in ((a, f"- Q{k}"), (b, f"+ Q{k}")):
            balance.get(node, []).append(term)
    lines += [f"{' '.join(terms)} = 0" for terms in balance.values()]
    lines += ["function pipe(H1, H2, L, D; Q)", "parameters nu, rough, g", "rules"]
    lines += [
        "v = 4*Q/(pi*D^2)",
        "Re = abs(v)*D/nu",
        "f = 0.25/log10(rough/(3.7*D) + 5.74/Re^0.9)^2",
    ]
    result = _solved([*lines, "H1 - H2 = f*L/D*v*abs(v)/(2*g)"])
    inflow = np.zeros(15)
    for k, (a, b) in enumerate(pipes):
        length, diameter, flow = 90 + 17 * k, 0.2 + 0.02 * (k % 7), result[f"Q{k}"]
        v = 4 * flow / (math.pi * diameter**2)
        f = (
            0.25
            / math.log10(1e-4 / (3.7 * diameter) + 5.74 / (abs(v) * diameter / 1e-6) ** 0.9) ** 2
        )
        loss = f * length / diameter * v * abs(v) / (2 * 9.81)
        assert math.isclose(result[f"H{a}"] - result[f"H{b}"], loss, rel_tol=1e-9, abs_tol=1e-12)
        inflow[a] -= flow
        inflow[b] += flow
    assert np.abs(inflow[1:14] - 0.02).max() <= 1e-12


def test_brackets_that_cancel_do_not_make_a_cable_net_steep() -> None:
    """A square net of cables, prestressed by 1 % and loaded: lengths by Pythagoras, displacements
    unknown."""
    n, inner = 4, range(1, 5)
    ends = [((i, j), (i + 1, j)) for i in range(n + 1) for j in inner]
    ends += [((i, j), (i, j + 1)) for i in inner for j in range(n + 1)]
    free = list(product(inner, inner))

    def coordinate(node: tuple[int, int], axis: int) -> str:
        at = float((*node, 0)[axis])
        return f"({at} + {'uvw'[axis]}_{node[0]}_{node[1]})" if node in free else repr(at)

    lines = ["EA = 1e6"]
    forces: dict[tuple[int, int], list[list[str]]] = {node: [[], [], []] for node in free}
    for k, (a, b) in enumerate(ends):
        parts = [f"({coordinate(b, axis)} - {coordinate(a, axis)})" for axis in range(3)]
        lines += [f"l{k} = sqrt({'^2 + '.join(parts)}^2)", f"N{k} = EA*(l{k} - 0.99)/0.99"]
        for node, sign in ((a, "+"), (b, "-")):
            for axis in range(3) if node in free else ():
                forces[node][axis].append(f"{sign} N{k}*{parts[axis]}/l{k}")
    lines += [
        f"0 {' '.join(terms)} = {load}"
        for row in forces.values()
        for terms, load in zip(row, (0, 0, 200), strict=True)
    ]
    result = _solved(lines)
    sag = np.array([[result[f"w_{i}_{j}"] for j in inner] for i in inner])
    assert sag.max() < 0.0
    assert np.abs(sag - sag.T).max() <= 1e-9 and np.abs(sag - sag[::-1]).max() <= 1e-9
    lifted = 0.0
    for k, (a, b) in enumerate(ends):
        assert result[f"l{k}"] >= 1.0 - 1e-3 and result[f"N{k}"] > 0.0
        w = [result[f"w_{i}_{j}"] if (i, j) in free else 0.0 for i, j in (a, b)]
        lifted += result[f"N{k}"] * (w[1] - w[0]) / result[f"l{k}"] * ((a in free) - (b in free))
    assert math.isclose(abs(lifted), 200.0 * len(free), rel_tol=1e-9)


def test_a_ladder_of_diodes_is_solved_where_their_currents_vanish() -> None:
    """``exp(V/Vt) - 1`` of a node far from the source rounds by more than the currents there."""
    n = 300
    lines = ["Is = 1e-12", "Vt = 0.02585", "R = 100", "V0 = 5"]
    for i in range(1, n + 1):
        onward = f" + I{i + 1}" if i < n else ""
        lines += [f"I{i} = (V{i - 1} - V{i})/R", f"Id{i} = Is*(exp(V{i}/Vt) - 1)"]
        lines += [f"I{i} = Id{i} + V{i}/1e4{onward}"]
    result = _solved(lines)
    voltages = [result[f"V{i}"] for i in range(n + 1)]
    assert all(before > after > 0.0 for before, after in pairwise(voltages))
    currents = [(a - b) / 100 for a, b in pairwise(voltages)] + [0.0]
    for i, v in enumerate(voltages[1:]):
        to_ground = 1e-12 * math.expm1(v / 0.02585) + v / 1e4
        assert math.isclose(currents[i] - currents[i + 1], to_ground, rel_tol=1e-6)


def test_a_large_block_without_a_root_is_no_full_matrix() -> None:
    """Bratu's equation on 600 points, beyond its turning point: full matrices took 350 MB."""
    model = rulesheets.loads(bratu(600, 4.0).sheet)
    tracemalloc.start()
    result = solver.solve(model, timeout=20.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert str(result.status) in ("failed", "infeasible")
    assert peak <= 50e6


def test_flows_that_are_rounding_leave_no_heat_conduction_undetermined() -> None:
    """A cube that conducts better where it is hot: no heat flows across its planes of symmetry."""
    n = 6

    def at(*place: int) -> str:
        inside = min(place) >= 1 and max(place) <= n
        return "T_{}_{}_{}".format(*place) if inside else "500" if place[2] == 0 else "300"

    lines = ["s = 500"]
    for i, j, k in product(range(1, n + 1), repeat=3):
        near = (
            (i - 1, j, k),
            (i + 1, j, k),
            (i, j - 1, k),
            (i, j + 1, k),
            (i, j, k - 1),
            (i, j, k + 1),
        )
        heat = " + ".join(f"cond({other}, {at(i, j, k)})" for other in starmap(at, near))
        lines.append(f"{heat} + s = 0")
    lines += ["function cond(a, b; q)", "rules", "q = (15 + 0.01*(a + b)/2)*(a - b)"]
    result = _solved(lines)
    assert math.isclose(result["T_1_2_3"], result["T_6_5_3"], rel_tol=1e-12)
    assert 300.0 < result["T_1_1_6"] < result["T_3_3_1"] < 550.0


def test_a_large_singular_sparse_matrix_is_not_made_dense() -> None:
    n = 3000
    places = np.arange(n)
    rows, columns = np.tile(places, 2), np.concatenate([places, (places + 1) % n])
    ring = sparse_matrix(np.repeat([1.0, -1.0], n), rows, columns, (n, n))
    tracemalloc.start()
    factor = factorise(ring, np.ones(n))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert factor.rank < n
    assert peak <= 8 * n * n / 4


def _viscous(n: int) -> list[str]:
    """Burgers' equation, u u' = 0.1 u'' from 1 to -0.8, whose front nearly floats between the
    ends."""
    dx = 2.0 / (n + 1)
    u = ["1", *(f"u{i}" for i in range(1, n + 1)), "-0.8"]
    rules = [
        f"{u[i]}*({u[i + 1]} - {u[i - 1]})/(2*dx) = nu*({u[i + 1]} - 2*{u[i]} + {u[i - 1]})/dx^2"
        for i in range(1, n + 1)
    ]
    return ["nu = 0.1", f"dx = {dx!r}", *rules]


def test_a_root_that_newton_shows_to_be_simple_is_not_singular_for_its_condition() -> None:
    result = _solved(_viscous(5000))
    coarse = _solved(_viscous(1249))
    assert abs(result["u2500"] - coarse["u625"]) < 1e-4 + 0.01 * abs(result["u2500"])


@pytest.mark.parametrize(("other", "alone"), [(0.0, 0.0), (1e-6, 1e-6), (1e-3, 1e-3), (1.0, 1.0)])
def test_steps_tell_how_far_a_root_is_alone(other: float, alone: float) -> None:
    """Roots 1 and 1 - other along the direction in which all unknowns move together."""
    i = np.arange(60)

    def residual(x: Array) -> Array:
        return (x - 1) ** 2 + other * (x - 1) + x - np.roll(x, -1)

    def jacobian(x: Array) -> Triplets:
        return np.r_[2 * (x - 1) + other + 1, -np.ones(60)], np.r_[i, i], np.r_[i, (i + 1) % 60]

    found = sparse_newton(residual, jacobian, 1 + 0.5 * np.cos(i), np.ones(60))
    assert found.converged
    assert found.alone <= alone
    assert found.alone > 0.0 or other <= 1e-6


def test_nodes_led_far_off_do_not_hold_back_a_net_of_springs() -> None:
    """Ten by ten weights in a net of springs, coordinates unknown: limited steps unfold it."""
    n, lines, ends = (
        10,
        ["k = 200"],
        dict[tuple[int, int], list[tuple[str, list[str], list[str]]]](),
    )

    def place(i: int, j: int) -> list[str]:
        if 0 < i < n + 1 and 0 < j < n + 1:
            return [f"{axis}{i}_{j}" for axis in "xyz"]
        return [f"{i}.0", f"{j}.0", repr(0.3 * (i + j) / n)]

    def spring(one: tuple[int, int], other: tuple[int, int]) -> None:
        a, b, name = place(*one), place(*other), f"{one[0]}_{one[1]}_{other[0]}_{other[1]}"
        squares = " + ".join(f"({q} - {p})^2" for p, q in zip(a, b, strict=True))
        lines.extend([f"l{name} = sqrt({squares})", f"q{name} = k*(l{name} - 0.8)/l{name}"])
        ends.setdefault(one, []).append((name, a, b))
        ends.setdefault(other, []).append((name, b, a))

    for i, j in product(range(n + 1), range(1, n + 1)):
        spring((i, j), (i + 1, j))
        spring((j, i), (j, i + 1))
    for i, j in product(range(1, n + 1), repeat=2):
        for axis, load in enumerate((0, 0, 5)):
            pulls = (f"q{name}*({b[axis]} - {a[axis]})" for name, a, b in ends[i, j])
            lines.append(f"{' + '.join(pulls)} = {load}")
    result = _solved(lines)
    heights = [result[f"z{i}_{j}"] for i, j in product(range(1, n + 1), repeat=2)]
    assert min(heights) < 0.0


def _patches(n: int) -> list[str]:
    """Prey and predators on a ring of patches: one answer has both everywhere."""
    lines = ["r = 1", "K = 10", "a = 0.5", "h = 0.2", "m = 0.6", "c = 0.7", "d = 0.1"]
    for k in range(n):
        sides = (k - 1) % n, (k + 1) % n
        eaten = f"a*N{k}*P{k}/(1 + a*h*N{k})"
        spread = [" + ".join(f"d*({s}{j} - {s}{k})" for j in sides) for s in "NP"]
        lines.append(f"r*N{k}*(1 - N{k}/K) - {eaten} + {spread[0]} + {0.01 * (k % 7)} = 0")
        lines.append(f"c*{eaten} - m*P{k} + {spread[1]} + 0.05 = 0")
    return lines


@pytest.mark.parametrize("n", [15, 200])
def test_populations_are_positive(n: int) -> None:
    result = _solved(_patches(n))
    assert min(result[f"{s}{k}"] for s in "NP" for k in range(n)) > 0.0


def test_voltages_below_the_rounding_of_exponentials_keep_their_meaning() -> None:
    """A ladder whose nodes take a fifth of the one before: the last stands at 1e-42 V."""
    n, lines = 80, ["Is = 1e-12", "Vt = 0.02585", "V0 = 5"]
    for k in range(1, n + 1):
        onwards = f" + I{k + 1}" if k < n else ""
        lines.append(f"I{k} = (V{k - 1} - V{k})/100")
        lines.append(f"D{k} = Is*(exp(V{k}/Vt) - 1)")
        lines.append(f"I{k} = D{k} + V{k}/60{onwards}")
    result = _solved(lines)
    ratio = result["V60"] / result["V59"]
    expected = 1 + 100 / 120 - math.sqrt((1 + 100 / 120) ** 2 - 1)
    assert abs(ratio - expected) < 1e-9
    assert 0.0 < result["V80"] < 1e-40


@pytest.mark.parametrize(("side", "supply", "every", "load"), [(9, 15, 2, 500)])
def test_voltages_of_a_circuit_come_down(side: int, supply: int, every: int, load: int) -> None:
    """Resistors and diodes between the nodes of a grid, where exp(supply/0.026) is beyond
    floats."""
    node = {place: f"V{k}" for k, place in enumerate(product(range(side), range(side)))}
    lines, near = (
        ["Is = 1e-14", "nVt = 0.026", f"V0 = {supply}"],
        {name: ["0"] for name in node.values()},
    )
    beside = [((i, j), (i + di, j + dj)) for (i, j) in node for di, dj in ((1, 0), (0, 1))]
    for k, (one, other) in enumerate(pair for pair in beside if pair[1] in node):
        a, b = (node[one], node[other]) if k % 3 else (node[other], node[one])
        law = (
            f"Is*(exp(({a} - {b})/nVt) - 1)"
            if k % every == 0
            else f"({a} - {b})/{100 + 37 * (k % 29)}"
        )
        lines.append(f"i{k} = {law}")
        near[a].append(f"- i{k}")
        near[b].append(f"+ i{k}")
    lines += [f"{' '.join(near[name])} = {name}/{load}" for name in node.values() if name != "V0"]
    result = _solved(lines)
    assert all(0.0 <= result[name] <= supply for name in node.values())


@pytest.mark.parametrize("n", [30, 100])
def test_fractions_are_positive_and_not_next_to_a_pole(n: int) -> None:
    """An absorber of n stages, whose ratios x/(1 - x) have a pole where fractions are of the size
    of 1."""
    lines = ["L0 = 40", "x0 = 0.001", f"G{n + 1} = 100", f"y{n + 1} = 0.08"]
    for i in range(1, n + 1):
        lines.append(f"y{i}/(1 - y{i}) = 0.7*x{i}/(1 - x{i}) + 0.2*x{i}^2")
        lines.append(f"L{i - 1}*x{i - 1} + G{i + 1}*y{i + 1} = L{i}*x{i} + G{i}*y{i}")
        lines.append(f"L{i - 1}*(1 - x{i - 1}) = L{i}*(1 - x{i})")
        lines.append(f"G{i + 1}*(1 - y{i + 1}) = G{i}*(1 - y{i})")
    result = _solved(lines)
    assert all(0.0 < result[f"{s}{k}"] < 0.2 for s in "xy" for k in range(1, n + 1))


def test_each_of_many_terms_is_a_small_part_of_their_sum() -> None:
    """Prices of sectors that buy from one another, with demands that share an income."""
    n = 400
    lines = ["Y = 1000" + "".join(f" + 0.05*p{i}*q{i}" for i in range(n))]
    lines.append("P = " + " + ".join(f"p{i}^-1.5" for i in range(n)))
    for i in range(n):
        inputs = " + ".join(
            f"{0.05 + 0.03 * ((i + k) % 5)}*p{(i * 7 + k * k * 31) % n}^-0.5" for k in (1, 2, 3, 4)
        )
        lines.append(f"c{i} = (0.4 + {inputs})^-2")
        lines.append(f"p{i} = 1.25*c{i}*(1 + 0.1*q{i}^0.3)")
        lines.append(f"q{i} = {0.5 + 0.2 * (i % 9)}*p{i}^-2.5*Y/P")
    result = _solved(lines)
    spent = sum(result[f"p{i}"] * result[f"q{i}"] for i in range(n))
    assert math.isclose(result["Y"], 1000 + 0.05 * spent, rel_tol=1e-9)
    assert all(result[f"{s}{i}"] > 0.0 for s in "cpq" for i in range(n))


def test_a_nearest_miss_out_of_the_domain_is_not_told() -> None:
    """A rule by itself may divide by 0 there."""
    model = rulesheets.loads("y = 1/x\ny = x + 1\n")
    graph = ModelGraph(model)
    kernel = BlockKernel(graph, SolveBlock((0, 1), ("x", "y"), ("x",)))
    problem = BlockProblem(kernel, {}, {})
    candidates = Candidates(problem)
    candidates.note({"x": 0.0, "y": 1.0})
    assert candidates.nearest == ({}, ())
    candidates.note({"x": 1.0, "y": 1.0})
    assert candidates.nearest == ({"x": 1.0, "y": 1.0}, (0.0, -1.0))


def test_utilities_begin_at_zero() -> None:
    """A demand that chooses among stations by their queues (multinomial logit)."""
    n, lines = 100, ["D = 4000", "a = 0.5", "S = " + " + ".join(f"exp(U{j})" for j in range(100))]
    for j in range(n):
        lines.append(f"U{j} = {(j * 37 % 200) / 100} - a*w{j}")
        lines.append(f"w{j} = 1 + (f{j}/{30 + j * 13 % 30})^4*0.5")
        lines.append(f"f{j} = D*exp(U{j})/S")
    result = _solved(lines)
    assert math.isclose(sum(result[f"f{j}"] for j in range(n)), 4000, rel_tol=1e-9)
    assert all(result[f"{s}{j}"] > 0.0 for s in "wf" for j in range(n))


def test_nothing_flows_through_closed_valves() -> None:
    """A grid of pipes between a reservoir and demands, across which check valves lead back."""
    side, lines = 25, ["H0 = 60"]
    number = {place: k for k, place in enumerate(product(range(side), repeat=2))}
    balance: list[list[str]] = [[] for _ in number]
    pipes = [
        (k, number[p])
        for (i, j), k in number.items()
        for p in ((i + 1, j), (i, j + 1))
        if p in number
    ]
    valves = [
        (number[i + 1, j + 1], number[i, j]) for i in range(0, 24, 3) for j in range(0, 24, 5)
    ]
    for k, (a, b) in enumerate([*pipes, *valves]):
        r = 500 + 8500 * (k * 37 % 101) / 101
        law = f"H{a} - H{b} = {r}*Q{k}*abs(Q{k})^0.852"
        lines.append(law if k < len(pipes) else f"Q{k} = max(H{a} - H{b}, 0)/{r / 50}")
        balance[a].append(f"- Q{k}")
        balance[b].append(f"+ Q{k}")
    for k, terms in enumerate(balance[1:], 1):
        lines.append(f"{' '.join(terms)} = {(0.2 + 0.8 * (k * 29 % 97) / 97) * 0.4 / len(number)}")
    result = _solved(lines)
    closed = [result[f"Q{k}"] == 0.0 for k in range(len(pipes), len(pipes) + len(valves))]
    back = [result[f"H{a}"] <= result[f"H{b}"] for a, b in valves]
    assert closed == back
    assert any(closed)


def test_flows_of_a_tree_go_on_to_one_branch_for_the_most_part() -> None:
    """District heating along a tree whose junctions are many: flows, losses of heat and
    pressures."""
    rng, n = np.random.default_rng(55), 500
    lines = ["cp = 4.186", "Tg = 8", "S0 = 85", "p0 = 600"]
    above = [0, *(int(rng.integers(max(0, i - 5), i)) for i in range(1, n))]
    for i in range(1, n):
        onwards = [k for k in range(i + 1, n) if above[k] == i]
        loss, back = (
            round(float(rng.uniform(0.005, 0.03)), 4),
            "".join(f" + m{k}*E{k}" for k in onwards),
        )
        lines.append(f"m{i} = d{i}" + "".join(f" + m{k}" for k in onwards))
        lines.append(f"S{i} = Tg + (S{above[i]} - Tg)*exp(-{loss}/(m{i}*cp))")
        lines.append(f"{round(float(rng.uniform(20, 120)), 1)} = cp*d{i}*(S{i} - R{i})")
        lines += [f"R{i} = 35 + 0.1*(S{i} - 60)", f"m{i}*N{i} = d{i}*R{i}{back}"]
        lines.append(f"E{i} = Tg + (N{i} - Tg)*exp(-{loss}/(m{i}*cp))")
        lines.append(f"p{above[i]} - p{i} = {round(float(rng.uniform(0.01, 0.2)), 3)}*m{i}^2")
    result = _solved(lines)
    assert all(
        result[f"d{i}"] > 0.0 and 30.0 < result[f"R{i}"] < result[f"S{i}"] < 85.0
        for i in range(1, n)
    )


@pytest.mark.parametrize("n", [40, 90])
def test_age_classes_live(n: int) -> None:
    """Births fall with the total: one child each where 0.4*exp(-total/1000)*(years of births) is
    1."""
    stay = [0.98 - 0.6 * (i / n) ** 4 for i in range(n - 1)]
    lines = [f"N{i + 1} = {s!r}*N{i}" for i, s in enumerate(stay)]
    lines.append("total = " + " + ".join(f"N{i}" for i in range(n)))
    lines.append(
        f"N0 = 0.4*exp(-total/1000)*({' + '.join(f'N{i}' for i in range(n // 5, n // 2))})"
    )
    result = _solved(lines)
    alive = np.cumprod([1.0, *stay])
    total = 1000 * math.log(0.4 * alive[n // 5 : n // 2].sum())
    found = np.array([result[f"N{i}"] for i in range(n)], dtype=float)
    np.testing.assert_allclose(found, total * alive / alive.sum(), rtol=1e-9)


def test_the_flow_of_a_heating_line_is_not_that_of_its_last_consumer() -> None:
    """The flow at the head by shooting: none is left after the last consumer."""
    n, lines = 20, ["T0 = 90", "M21 = 0"]
    for i in range(1, n + 1):
        lines += [f"T{i} = 10 + (T{i - 1} - 10)*exp(-0.015/M{i})", f"M{i} = M{i + 1} + m{i}"]
        lines.append(f"{5 + i % 3} = 4.18*m{i}*(T{i} - 40)")

    def left(head: float) -> float:
        temperature = 90.0
        for i in range(1, n + 1):
            temperature = 10 + (temperature - 10) * math.exp(-0.015 / head)
            head -= (5 + i % 3) / (4.18 * (temperature - 40))
        return head

    result = _solved(lines)
    heads = np.linspace(2.0, 0.8, 1000)  # the largest root: below it the line would cool down
    low = next(head for head in heads if left(head) < 0.0)
    assert math.isclose(float(result["M1"]), brentq(left, low, low + 0.01), rel_tol=1e-9)
