"""Networks of many unknowns: load and solve, beside a sparse Newton by hand on the same equations.

``python -m benchmarks.networks [--small]`` prints a line a network: seconds to load and to solve, the ratio
of both together to the Newton by hand, and the largest error beside its answer.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array, kron
from scipy.sparse.linalg import spsolve

import rulesheets
import solver

SIGMA = 5.67e-8


@dataclass(frozen=True)
class Network:
    """A sheet, the ``names`` of unknowns, and their residual with its sparse Jacobian from a ``start``."""

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
    """u'' + strength exp(u) = 0 between ends at 0, on n inner points; the lower of its two answers."""
    step2 = 1.0 / (n + 1) ** 2
    u = ["0", *(f"u{i}" for i in range(1, n + 1)), "0"]
    rules = [f"({u[i - 1]} - 2*{u[i]} + {u[i + 1]})/{step2!r} + s*exp({u[i]}) = 0" for i in range(1, n + 1)]
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
    """Conduction in a plate of n x n points, one edge at 400 K, the others at 300 K; ``loss``: radiation."""

    def at(i: int, j: int) -> str:
        if i == 0:
            return "400"
        return f"T_{i}_{j}" if i <= n and 1 <= j <= n else "300"

    inner = [(i, j) for i in range(1, n + 1) for j in range(1, n + 1)]
    around = [f"{at(i - 1, j)} + {at(i + 1, j)} + {at(i, j - 1)} + {at(i, j + 1)}" for i, j in inner]
    lost = [f"{loss}*{SIGMA}*({at(i, j)}^4 - 300^4)" if loss else "0" for i, j in inner]
    rules = [f"k*({near} - 4*{at(i, j)}) = {q}" for (i, j), near, q in zip(inner, around, lost, strict=True)]
    one = _second_difference(n)
    matrix = 1.5 * csr_array(kron(one, eye_array(n)) + kron(eye_array(n), one))
    edges = np.array([400.0 * (i == 1) + 300.0 * ((i == n) + (j == 1) + (j == n)) for i, j in inner])

    def system(x: Any) -> tuple[Any, Any]:
        radiated, slope = loss * SIGMA * (x**4 - 300.0**4), loss * SIGMA * 4 * x**3
        return matrix @ x + 1.5 * edges - radiated, matrix - diags_array(slope)

    title = f"plate {n} x {n}{', radiating' if loss else ''}"
    names = [at(i, j) for i, j in inner]
    return Network(title, _sheet("k = 1.5", *rules), names, np.full(n * n, 330.0), system)


def pipes(n: int) -> Network:
    """A grid of pipes, fed at one corner, with a demand at each other node and head losses as q|q|."""
    nodes = [(i, j) for i in range(n) for j in range(n)]
    ends = [((i, j), (i + di, j + dj)) for i, j in nodes for di, dj in ((1, 0), (0, 1))]
    ends = [(a, b) for a, b in ends if max(b) < n]
    heads, flows = [f"H_{i}_{j}" for i, j in nodes], [f"Q{k}" for k in range(len(ends))]
    place = {node: k for k, node in enumerate(nodes)}
    near: list[list[str]] = [[] for _ in nodes]
    for q, (a, b) in zip(flows, ends, strict=True):
        near[place[a]].append(f"- {q}")
        near[place[b]].append(f"+ {q}")
    losses = [
        f"{heads[place[a]]} - {heads[place[b]]} = 200*{q}*abs({q})"
        for q, (a, b) in zip(flows, ends, strict=True)
    ]
    balances = [f"0 {' '.join(terms)} = 0.01" for terms in near[1:]]
    rows = np.repeat(np.arange(len(ends)), 2)
    columns = np.array([place[node] for pair in ends for node in pair])
    signs = np.tile([1.0, -1.0], len(ends))
    drop = csr_array((signs, (rows, columns)), shape=(len(ends), len(nodes)))[:, 1:]
    m = len(nodes) - 1

    def system(x: Any) -> tuple[Any, Any]:
        from scipy.sparse import block_array

        h, q = x[:m], x[m:]
        fed = np.array([100.0 if a == (0, 0) else 0.0 for a, _ in ends])
        residual = np.concatenate([drop @ h + fed - 200 * q * np.abs(q), -drop.T @ q - 0.01])
        return residual, block_array([[drop, diags_array(-400 * np.abs(q))], [None, -drop.T]])

    start = np.concatenate([np.full(m, 90.0), np.full(len(ends), 0.05)])
    return Network(
        f"pipes {n} x {n}", _sheet("H_0_0 = 100", *losses, *balances), [*heads[1:], *flows], start, system
    )


def _sheet(*rules: str) -> str:
    return "\n".join(rules) + "\n"


def networks(small: bool) -> Iterator[Network]:
    for n in (4, 10) if small else (4, 10, 20, 40):
        yield pipes(n)
    for n in (50, 200) if small else (5, 50, 200, 2000):
        yield radiation(n)
    for n in (6, 20) if small else (6, 20, 40, 100):
        yield plate(n)
        yield plate(n, 0.02)
    for n in (200,) if small else (50, 200, 1000, 10_000):
        yield bratu(n)


def measure(network: Network) -> str:
    began = time.perf_counter()
    expected = network.by_hand()
    hand = time.perf_counter()
    model = rulesheets.loads(network.sheet)
    loaded = time.perf_counter()
    result = solver.solve(model, timeout=60.0)
    ended = time.perf_counter()
    line = f"{network.title:24s} {loaded - hand:8.3f} {ended - loaded:8.3f}"
    if str(result.status) != "solved":
        return f"{line} {result.status}"
    got = np.array([result[name] for name in network.names], dtype=float)
    error = np.abs(got - expected).max() / np.abs(expected).max()
    return f"{line} {(ended - hand) / (hand - began):8.1f} {error:8.1e}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true")
    print(f"{'network':24s} {'load':>8s} {'solve':>8s} {'ratio':>8s} {'error':>8s}")
    for network in networks(parser.parse_args().small):
        print(measure(network), flush=True)


if __name__ == "__main__":
    main()
