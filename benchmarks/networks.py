"""Networks of many unknowns: load and solve, beside a sparse Newton by hand on the same equations.

    python -m benchmarks.networks [--small] [--peers] [--write]

prints a line a network: processor seconds of the Newton by hand, to load and to solve, the ratio of
both together to the first, whether that is at most 30 (or half a second), the largest error beside
the Newton's answer, and the peak of memory. Others get the same rules (krylov the residual by hand)
and the same start.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np
from scipy.optimize import root
from scipy.sparse import block_array, csr_array, diags_array, eye_array, hstack, kron, vstack
from scipy.sparse.linalg import spsolve

import rulesheets
import solver
from benchmarks.pages import ROOT, markdown_table, place
from benchmarks.peers import Equations, run
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
)

SIGMA = 5.67e-8


@dataclass(frozen=True)
class Network:
    """A sheet, the ``names`` of unknowns, and their residual with its sparse Jacobian from a
    ``start``."""

    title: str
    sheet: str
    names: list[str]
    start: Any
    system: Callable[[Any], tuple[Any, Any]]

    def by_hand(self) -> Any:
        x = self.start.copy()
        for _ in range(100):
            residual, jacobian = self.system(x)
            step = spsolve(jacobian.tocsc(), residual)
            x = x - step
            if np.abs(step).max() <= 1e-12 * np.abs(x).max():
                return x
        raise ArithmeticError(f"{self.title}: no convergence")


def _second_difference(n: int) -> Any:
    return diags_array([1.0, -2.0, 1.0], offsets=[-1, 0, 1], shape=(n, n))


def bratu(n: int, strength: float = 2.0) -> Network:
    """u'' + strength exp(u) = 0 between ends at 0, on n inner points; the lower of its two
    answers."""
    step2 = 1.0 / (n + 1) ** 2
    u = ["0", *(f"u{i}" for i in range(1, n + 1)), "0"]
    rules = [
        f"({u[i - 1]} - 2*{u[i]} + {u[i + 1]})/{step2!r} + s*exp({u[i]}) = 0"
        for i in range(1, n + 1)
    ]
    matrix = _second_difference(n) / step2

    def system(x: Any) -> tuple[Any, Any]:
        source = strength * np.exp(x)
        return matrix @ x + source, matrix + diags_array(source)

    return Network(f"Bratu {n}", _sheet(f"s = {strength}", *rules), u[1:-1], np.zeros(n), system)


def radiation(n: int) -> Network:
    """n radiation shields between walls of 800 and 300 K."""
    t = ["800", *(f"T{i}" for i in range(1, n + 1)), "300"]
    rules = [f"q = 0.8*{SIGMA}*({t[i]}^4 - {t[i + 1]}^4)" for i in range(n + 1)]
    ends = np.zeros(n)
    ends[0], ends[-1] = 800.0**4, 300.0**4
    matrix = _second_difference(n)

    def system(x: Any) -> tuple[Any, Any]:
        return matrix @ x**4 + ends, matrix @ diags_array(4 * x**3)

    return Network(f"shields {n}", _sheet(*rules), t[1:-1], np.full(n, 600.0), system)


def plate(n: int, loss: float = 0.0) -> Network:
    """Conduction in a plate of n x n points, one edge at 400 K, the others at 300 K; ``loss``:
    radiation."""

    def at(i: int, j: int) -> str:
        if i == 0:
            return "400"
        return f"T_{i}_{j}" if i <= n and 1 <= j <= n else "300"

    inner = [(i, j) for i in range(1, n + 1) for j in range(1, n + 1)]
    around = [
        f"{at(i - 1, j)} + {at(i + 1, j)} + {at(i, j - 1)} + {at(i, j + 1)}" for i, j in inner
    ]
    lost = [f"{loss}*{SIGMA}*({at(i, j)}^4 - 300^4)" if loss else "0" for i, j in inner]
    rules = [
        f"k*({near} - 4*{at(i, j)}) = {q}"
        for (i, j), near, q in zip(inner, around, lost, strict=True)
    ]
    one = _second_difference(n)
    matrix = 1.5 * csr_array(kron(one, eye_array(n)) + kron(eye_array(n), one))
    edges = np.array(
        [400.0 * (i == 1) + 300.0 * ((i == n) + (j == 1) + (j == n)) for i, j in inner]
    )

    def system(x: Any) -> tuple[Any, Any]:
        radiated, slope = loss * SIGMA * (x**4 - 300.0**4), loss * SIGMA * 4 * x**3
        return matrix @ x + 1.5 * edges - radiated, matrix - diags_array(slope)

    title = f"plate {n} x {n}{', radiating' if loss else ''}"
    names = [at(i, j) for i, j in inner]
    return Network(title, _sheet("k = 1.5", *rules), names, np.full(n * n, 330.0), system)


def pipes(n: int) -> Network:
    """A grid of pipes, fed at one corner, with a demand at each other node and head losses as
    q|q|."""
    nodes, ends, flows, balances, drop = _grid(n, "0.01")
    heads = [f"H_{i}_{j}" for i, j in nodes]
    place = {node: k for k, node in enumerate(nodes)}
    losses = [
        f"{heads[place[a]]} - {heads[place[b]]} = 200*{q}*abs({q})"
        for q, (a, b) in zip(flows, ends, strict=True)
    ]
    m = len(nodes) - 1

    def system(x: Any) -> tuple[Any, Any]:
        h, q = x[:m], x[m:]
        fed = np.array([100.0 if a == (0, 0) else 0.0 for a, _ in ends])
        residual = np.concatenate([drop @ h + fed - 200 * q * np.abs(q), -drop.T @ q - 0.01])
        return residual, block_array([[drop, diags_array(-400 * np.abs(q))], [None, -drop.T]])

    start = np.concatenate([np.full(m, 90.0), np.full(len(ends), 0.05)])
    return Network(
        f"pipes {n} x {n}",
        _sheet("H_0_0 = 100", *losses, *balances),
        [*heads[1:], *flows],
        start,
        system,
    )


def gas(n: int) -> Network:
    """The same with gas at 60 bar, whose squared pressure falls as q|q|."""
    nodes, ends, flows, balances, drop = _grid(n, demand := repr(20 / n**2))
    pressures = [f"p_{i}_{j}" for i, j in nodes]
    place = {node: k for k, node in enumerate(nodes)}
    losses = [
        f"{pressures[place[a]]}^2 - {pressures[place[b]]}^2 = k*{q}*abs({q})"
        for q, (a, b) in zip(flows, ends, strict=True)
    ]
    m = len(nodes) - 1
    fed = np.array([3600.0 if a == (0, 0) else 0.0 for a, _ in ends])

    def system(x: Any) -> tuple[Any, Any]:
        p, q = x[:m], x[m:]
        residual = np.concatenate(
            [drop @ p**2 + fed - 0.7 * q * np.abs(q), -drop.T @ q - float(demand)]
        )
        slopes = drop @ diags_array(2 * p)
        return residual, block_array([[slopes, diags_array(-1.4 * np.abs(q))], [None, -drop.T]])

    start = np.concatenate([np.full(m, 55.0), np.full(len(ends), 1.0)])
    sheet = _sheet("p_0_0 = 60", "k = 0.7", *losses, *balances)
    return Network(f"gas {n} x {n}", sheet, [*pressures[1:], *flows], start, system)


def _grid(n: int, demand: str) -> tuple[list[Any], list[Any], list[str], list[str], Any]:
    """Nodes of a grid, their links, the flows of these, balances of all nodes but the first, and
    the matrix (links, nodes but the first) of differences along the links."""
    nodes = [(i, j) for i in range(n) for j in range(n)]
    ends = [((i, j), (i + di, j + dj)) for i, j in nodes for di, dj in ((1, 0), (0, 1))]
    ends = [(a, b) for a, b in ends if max(b) < n]
    flows = [f"Q{k}" for k in range(len(ends))]
    place = {node: k for k, node in enumerate(nodes)}
    near: list[list[str]] = [[] for _ in nodes]
    for q, (a, b) in zip(flows, ends, strict=True):
        near[place[a]].append(f"- {q}")
        near[place[b]].append(f"+ {q}")
    balances = [f"0 {' '.join(terms)} = {demand}" for terms in near[1:]]
    rows = np.repeat(np.arange(len(ends)), 2)
    columns = np.array([place[node] for pair in ends for node in pair])
    signs = np.tile([1.0, -1.0], len(ends))
    drop = csr_array((signs, (rows, columns)), shape=(len(ends), len(nodes)))[:, 1:]
    return nodes, ends, flows, balances, drop


def direct_current(n: int) -> Network:
    """n nodes in a ring with chords at 400 V, where each but the first draws constant power: near
    400 V there is one answer, and many where the voltage has broken down."""
    lines = [(i, (i + 1) % n) for i in range(n)] + [(i, (i + n // 3) % n) for i in range(0, n, 4)]
    conductance = 20.0 * n / 15
    matrix = np.zeros((n, n))
    for a, b in lines:
        matrix[[a, b], [b, a]] -= conductance
        matrix[[a, b], [a, b]] += conductance
    near = [[j for j in range(n) if j != i and matrix[i, j]] for i in range(n)]
    power = 2000.0 + 100.0 * (np.arange(1, n) % 5)
    rules = ["V0 = 400", f"G = {conductance!r}"]
    for i in range(1, n):
        total = " + ".join(
            f"{float(-matrix[i, j] / conductance)!r}*G*(V{j} - V{i})" for j in near[i]
        )
        rules += [f"I{i} = {total}", f"V{i}*I{i} = {float(power[i - 1])!r}"]
    inner, fed = csr_array(matrix[1:, 1:]), matrix[1:, 0] * 400.0

    def system(v: Any) -> tuple[Any, Any]:
        current = -(inner @ v) - fed
        return v * current - power, diags_array(current) - diags_array(v) @ inner

    names = [f"V{i}" for i in range(1, n)]
    return Network(f"direct current {n}", _sheet(*rules), names, np.full(n - 1, 400.0), system)


def load_flow(n: int) -> Network:
    """n buses in a ring with chords: bus 0 holds voltage and angle, each fifth its voltage; others
    draw."""
    lines = [(i, (i + 1) % n) for i in range(n)] + [(i, (i + n // 3) % n) for i in range(0, n, 4)]
    admittance = np.zeros((n, n), dtype=complex)
    for k, (a, b) in enumerate(lines):
        y = 1.0 / complex(0.01 + 0.002 * (k % 5), 0.06 + 0.01 * (k % 7))
        admittance[[a, b], [b, a]] -= y
        admittance[[a, b], [a, b]] += y + 0.01j
    holds = np.arange(n) % 5 == 0
    power = np.where(holds, 0.55, -0.15 - 0.01 * (np.arange(n) % 3))
    reactive = -0.05 * np.ones(n)
    v = ["1.04" if i == 0 else "1.02" if holds[i] else f"V{i}" for i in range(n)]
    a = ["0" if i == 0 else f"a{i}" for i in range(n)]

    def sent(i: int, one: str) -> str:
        terms = []
        for j in map(int, np.flatnonzero(admittance[i])):
            g, b = float(admittance[i, j].real), float(admittance[i, j].imag)
            parts = {"cos": g if one == "cos" else -b, "sin": b if one == "cos" else g}
            turned = (
                f"{parts['cos']!r}*cos({a[i]} - {a[j]}) + {parts['sin']!r}*sin({a[i]} - {a[j]})"
            )
            terms.append(f"{v[i]}*{v[j]}*({turned})")
        return " + ".join(terms)

    rules = [f"{sent(i, 'cos')} = {float(power[i])!r}" for i in range(1, n)]
    draws = np.flatnonzero(~holds)
    rules += [f"{sent(int(i), 'sin')} = {float(reactive[i])!r}" for i in draws]
    y, angles = csr_array(admittance), slice(1, n)

    def system(x: Any) -> tuple[Any, Any]:
        size, angle = np.where(np.arange(n) == 0, 1.04, 1.02), np.zeros(n)
        angle[angles], size[draws] = x[: n - 1], x[n - 1 :]
        u = size * np.exp(1j * angle)
        current, unit = y @ u, u / size
        by_size = diags_array(u) @ (y @ diags_array(unit)).conj() + diags_array(
            current.conj() * unit
        )
        by_angle = 1j * diags_array(u) @ (diags_array(current) - y @ diags_array(u)).conj()
        sent = u * current.conj()
        residual = np.concatenate([(sent.real - power)[1:], (sent.imag - reactive)[draws]])
        both = hstack([by_angle.tocsc()[:, 1:], by_size.tocsc()[:, draws]]).tocsr()
        return residual, vstack([both.real[1:], both.imag[draws]])

    names = [*a[1:], *(v[i] for i in draws)]
    start = np.concatenate([np.zeros(n - 1), np.ones(len(draws))])
    return Network(f"load flow {n}", _sheet(*rules), names, start, system)


def truss(panels: int) -> Network:
    """A cantilever of crossed panels of 1 m, 5 bars each, that bends so far that angles change."""
    stiffness, load = 2.0e8, -2.0e4 / panels**2
    place = {(i, j): (float(i), float(j)) for i in range(panels + 1) for j in (0, 1)}
    bars = []
    for i in range(panels):
        bars += [
            ((i, 0), (i + 1, 0)),
            ((i, 1), (i + 1, 1)),
            ((i, 0), (i + 1, 1)),
            ((i, 1), (i + 1, 0)),
        ]
        bars.append(((i + 1, 0), (i + 1, 1)))
    free = [node for node in place if node[0] > 0]
    at = {node: 2 * k for k, node in enumerate(free)}

    def name(letter: str, node: tuple[int, int]) -> str:
        rest = str(place[node][letter == "v"])
        return f"({rest} + {letter}_{node[0]}_{node[1]})" if node in at else rest

    rules, pulls = [], {node: ([], []) for node in free}  # type: ignore[var-annotated]
    for k, (one, other) in enumerate(bars):
        dx, dy = (f"({name(c, other)} - {name(c, one)})" for c in "uv")
        length = float(np.hypot(*np.subtract(place[other], place[one])))
        rules += [f"l{k} = sqrt({dx}^2 + {dy}^2)", f"N{k} = EA*(l{k} - {length!r})/{length!r}"]
        for node, sign in ((one, "+"), (other, "-")):
            if node in at:
                pulls[node][0].append(f"{sign} N{k}*{dx}/l{k}")
                pulls[node][1].append(f"{sign} N{k}*{dy}/l{k}")
    for node in free:
        rules += [
            f"0 {' '.join(pulls[node][0])} = 0",
            f"0 {' '.join(pulls[node][1])} + {load!r} = 0",
        ]
    ends = np.array([[at.get(one, -1), at.get(other, -1)] for one, other in bars])
    fixed = np.array([[place[one], place[other]] for one, other in bars])
    rest = np.hypot(*(fixed[:, 1] - fixed[:, 0]).T)
    columns = np.concatenate([ends[:, 0], ends[:, 0] + 1, ends[:, 1], ends[:, 1] + 1]).reshape(
        4, -1
    )
    moves = np.repeat(ends >= 0, 2, axis=1).T

    def system(x: Any) -> tuple[Any, Any]:
        points = fixed + np.where(ends[:, :, None] >= 0, x.reshape(-1, 2)[ends // 2], 0.0)
        d = points[:, 1] - points[:, 0]
        length = np.hypot(*d.T)
        e, pull = d / length[:, None], stiffness * (length - rest) / rest
        along = e[:, :, None] * e[:, None, :]
        tangent = (stiffness / rest - pull / length)[:, None, None] * along
        tangent += (pull / length)[:, None, None] * np.eye(2)
        full = np.concatenate(
            [
                np.concatenate([-tangent, tangent], axis=2),
                np.concatenate([tangent, -tangent], axis=2),
            ],
            axis=1,
        )
        residual = np.tile([0.0, load], len(free))
        force = np.concatenate([pull[:, None] * e, -pull[:, None] * e], axis=1).T
        np.add.at(residual, columns[moves], force[moves])
        both = moves.T[:, :, None] & moves.T[:, None, :]
        rows = np.broadcast_to(columns.T[:, :, None], full.shape)[both]
        across = np.broadcast_to(columns.T[:, None, :], full.shape)[both]
        return residual, csr_array((full[both], (rows, across)), shape=(len(x), len(x)))

    start, names = np.zeros(2 * len(free)), [f"{c}_{i}_{j}" for i, j in free for c in "uv"]
    sheet = _sheet(f"EA = {stiffness!r}", *rules)
    return Network(f"truss of {len(bars)} bars", sheet, names, start, system)


def column(trays: int) -> Network:
    """Distillation of three components at constant relative volatility, condenser and reboiler
    included."""
    volatility, feed, z = np.array([4.0, 2.0, 1.0]), 100.0, np.array([0.4, 0.3, 0.3])
    top, reflux, where, n = 40.0, 3.0, trays // 2, trays + 2
    liquid = np.where(np.arange(n) < where, reflux * top, reflux * top + feed)
    liquid[-1] = feed - top
    vapour = (reflux + 1) * top
    x = [[f"x{c}_{j}" for j in range(n)] for c in range(3)]
    rules = []
    for j in range(n):
        share = " + ".join(f"{volatility[c]}*{x[c][j]}" for c in range(3))
        rules += [f"y{c}_{j} = {volatility[c]}*{x[c][j]}/({share})" for c in range(3)]
        for c in range(3):
            into = f"{vapour}*y{c}_{j + 1}" if j + 1 < n else "0"
            into += f" + {liquid[j - 1]}*{x[c][j - 1]}" if j else ""
            into += f" + {feed * z[c]}" if j == where else ""
            out = f"{liquid[j] + (top if j == 0 else 0.0)}*{x[c][j]}" + (
                f" + {vapour}*y{c}_{j}" if j else ""
            )
            rules.append(f"{into} = {out}")
    boils = np.ones(n)
    boils[0] = 0.0

    def system(flat: Any) -> tuple[Any, Any]:
        share = flat.reshape(3, n)
        total = volatility @ share
        y = volatility[:, None] * share / total
        out = liquid + top * (np.arange(n) == 0)
        residual = -out * share - vapour * boils * y
        residual[:, :-1] += vapour * y[:, 1:]
        residual[:, 1:] += liquid[:-1] * share[:, :-1]
        residual[:, where] += feed * z
        up, down = eye_array(n, k=1), eye_array(n, k=-1)
        flows = vapour * (up - diags_array(boils))
        own = down @ diags_array(liquid) - diags_array(out)
        blocks = [
            [
                flows
                @ diags_array(
                    volatility[c] * ((c == d) / total - volatility[d] * share[c] / total**2)
                )
                + (own if c == d else 0.0 * own)
                for d in range(3)
            ]
            for c in range(3)
        ]
        return residual.ravel(), block_array(blocks)

    names = [name for row in x for name in row]
    return Network(f"column of {trays} trays", _sheet(*rules), names, np.repeat(z, n), system)


def _sheet(*rules: str) -> str:
    return "\n".join(rules) + "\n"


def networks(small: bool) -> Iterator[Network]:
    for n in (4, 10) if small else (4, 10, 20, 40):
        yield pipes(n)
    for n in (6,) if small else (3, 6, 20):
        yield gas(n)
    for n in (40,) if small else (15, 40, 300):
        yield direct_current(n)
    for n in (50, 200) if small else (5, 50, 200, 2000):
        yield radiation(n)
    for n in (6, 20) if small else (6, 20, 40, 100):
        yield plate(n)
        yield plate(n, 0.02)
    for n in (50, 200) if small else (50, 200, 1000, 10_000):
        yield bratu(n)
    for n in (9, 30) if small else (9, 30, 118):
        yield load_flow(n)
    yield truss(20 if small else 200)
    yield column(10 if small else 40)


# --- others on the same rules ---------------------------------------------------


def _value(node: Expression, values: Mapping[str, Any], module: Any) -> Any:
    """An expression in the numbers of another library."""
    match node:
        case Number(number):
            return number
        case Name(name):
            return values[name]
        case Negative(inner):
            return -_value(inner, values, module)
        case Sum(terms):
            first, *rest = (_value(term, values, module) for term in terms)
            return reduce(add, rest, first)
        case Product(left, right):
            return _value(left, values, module) * _value(right, values, module)
        case Quotient(left, right):
            return _value(left, values, module) / _value(right, values, module)
        case Power(base, exponent):
            return _value(base, values, module) ** _value(exponent, values, module)
        case Call("abs", (inner,)) if hasattr(module, "fabs"):
            return module.fabs(_value(inner, values, module))
        case Call("abs", (inner,)):
            return module.abs2(_value(inner, values, module))
        case Call(function, arguments):
            return getattr(module, function)(*(_value(part, values, module) for part in arguments))
    raise NotImplementedError(type(node).__name__)


def _rules(network: Network) -> tuple[Any, list[str], list[float]]:
    """The model, its unknowns, and a start: that of the Newton by hand, and 1 for what it does not
    know."""
    model = rulesheets.loads(network.sheet)
    start = dict(zip(network.names, network.start.tolist(), strict=True))
    given = {
        e.left.name
        for e in model.equations
        if isinstance(e.left, Name) and isinstance(e.right, Number)
    }
    unknowns = [name for name in model.variables if name in start or name not in given]
    return model, unknowns, [start.get(name, 1.0) for name in unknowns]


def _residuals(model: Any, values: dict[str, Any], module: Any) -> list[Any]:
    for equation in model.equations:
        if isinstance(equation.left, Name) and isinstance(equation.right, Number):
            values.setdefault(equation.left.name, equation.right.value)
    sides = ((e.left, e.right) for e in model.equations)
    found = [_value(left, values, module) - _value(right, values, module) for left, right in sides]
    return [residual for residual in found if not isinstance(residual, float)]


def by_casadi(network: Network) -> tuple[bool, Any]:
    import casadi

    model, unknowns, start = _rules(network)
    x = casadi.SX.sym("x", len(unknowns))
    residuals = _residuals(model, dict(zip(unknowns, casadi.vertsplit(x), strict=True)), casadi)
    finder = casadi.rootfinder(
        "finder", "newton", {"x": x, "g": casadi.vertcat(*residuals)}, {"error_on_fail": True}
    )
    found = finder(x0=start, p=[])["x"].full().ravel()
    return True, [found[unknowns.index(name)] for name in network.names]


def by_gekko(network: Network) -> tuple[bool, Any]:
    from gekko import GEKKO

    model, unknowns, start = _rules(network)
    other = GEKKO(remote=False)
    x = dict(zip(unknowns, (other.Var(value=v) for v in start), strict=True))
    for residual in _residuals(model, dict(x), other):
        other.Equation(residual == 0)
    other.options.RTOL = other.options.OTOL = 1e-10
    other.solve(disp=False)
    return other.options.APPSTATUS == 1, [x[name].value[0] for name in network.names]


def by_krylov(network: Network) -> tuple[bool, Any]:
    """scipy's ``root`` without a Jacobian, on the residual by hand."""
    found = root(lambda x: network.system(x)[0], network.start, method="krylov")
    return bool(found.success), found.x


PEERS = {"casadi newton": by_casadi, "gekko": by_gekko, "scipy root(krylov)": by_krylov}
LIMIT = 5.0
"""Seconds that a peer may take."""


def peer(network: Network, solve: Callable[[Network], tuple[bool, Any]], expected: Any) -> str:
    """Seconds of a peer from the rules (krylov: from the residual) to the answer, or what came of
    it."""
    end = run(lambda equations, start: solve(network), Equations(lambda x, m: [], 0), (), LIMIT)
    if not end.success or end.x is None:
        return end.said if end.said == "time limit" else "fails"
    error = np.abs(np.array(end.x) - expected).max() / np.abs(expected).max()
    return f"{end.seconds:.2f}" if error < 1e-3 else "elsewhere"


# --- measured -------------------------------------------------------------------


@dataclass(frozen=True)
class Measured:
    """Processor seconds of the Newton by hand, of loading and solving; error beside it; MB at the
    peak."""

    hand: float
    load: float
    solve: float
    error: float
    memory: float

    @property
    def held(self) -> bool:
        return (
            self.load + self.solve <= max(30 * self.hand, 0.5)
            and self.error < 1e-6
            and self.memory <= 1e3
        )


def measure(network: Network) -> Measured:
    network.by_hand()
    began = time.process_time()
    expected = network.by_hand()
    hand = time.process_time()
    model = rulesheets.loads(network.sheet)
    loaded = time.process_time()
    result = solver.solve(model, timeout=60.0)
    ended = time.process_time()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    error = np.inf
    if str(result.status) == "solved":
        got = np.array([result[name] for name in network.names], dtype=float)
        error = float(np.abs(got - expected).max() / np.abs(expected).max())
    return Measured(hand - began, loaded - hand, ended - loaded, error, memory)


def in_its_own_process(network: Network) -> Measured:
    """So that the peak of memory is that of one network."""
    receiver, sender = multiprocessing.get_context("fork").Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(
        target=lambda: sender.send(measure(network))
    )
    child.start()
    sender.close()
    found: Measured = receiver.recv()
    child.join()
    return found


HEAD = ["network", "by hand", "load", "solve", "ratio", "held", "error", "MB"]


def line(network: Network, peers: bool) -> list[str]:
    found = in_its_own_process(network)
    ratio = (found.load + found.solve) / found.hand
    cells = [
        network.title,
        f"{found.hand:.3f}",
        f"{found.load:.3f}",
        f"{found.solve:.3f}",
        f"{ratio:.0f}",
    ]
    cells += ["yes" if found.held else "no", f"{found.error:.0e}", f"{found.memory:.0f}"]
    expected = network.by_hand() if peers else None
    return cells + [peer(network, solve, expected) for solve in PEERS.values() if peers]


def warm_up() -> None:
    """Import what solves import, so that no network pays for it."""
    for network in (pipes(5), load_flow(5), truss(10)):
        solver.solve(rulesheets.loads(network.sheet))
        network.by_hand()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true")
    parser.add_argument(
        "--peers", action="store_true", help="casadi, gekko and scipy's krylov as well"
    )
    parser.add_argument("--write", action="store_true", help="put the table into docs/speed.md")
    options = parser.parse_args()
    warm_up()
    peers = options.peers or options.write
    head = HEAD + (list(PEERS) if peers else [])
    lines = []
    print(aligned(head))
    for network in networks(options.small):
        lines.append(line(network, peers))
        print(aligned(lines[-1]), flush=True)
    if options.write:
        place(ROOT / "docs" / "speed.md", "speed: networks", markdown_table(head, lines))


def aligned(cells: list[str]) -> str:
    widths = [8] * (len(HEAD) - 1) + [20] * len(PEERS)
    return cells[0].ljust(28) + "".join(
        cell.rjust(w) for cell, w in zip(cells[1:], widths, strict=False)
    )


if __name__ == "__main__":
    main()
