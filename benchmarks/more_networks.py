"""Networks, chains and fields of some twenty kinds: load and solve, beside a sparse Newton by hand.

    python -m benchmarks.more_networks [--size N] [KIND…]

prints lines as ``benchmarks.networks`` does. Rules are patterns, a line of the sheet for each row
of their columns. The Newton by hand takes a pattern as one function of arrays, its slopes by
complex steps (W. Squire & G. Trapp, SIAM Review 40 (1998) 110-112), from a start that somebody of
the field would take.
"""

from __future__ import annotations

import argparse
import re
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from math import cos, pi, sin
from typing import Any

import numpy as np
from scipy.sparse import csc_array

from benchmarks.networks import HEAD, Network, aligned, line, warm_up

Cell = str | float
Column = Sequence[Cell] | Cell
Link = tuple[int, int]
STEP = 1e-40


def _abs(x: Any) -> Any:
    return np.where(np.real(x) < 0.0, -x, x)


FUNCTIONS = {
    **{name: getattr(np, name) for name in ("exp", "sqrt", "sin", "cos", "tanh", "sinh")},
    "abs": _abs,
    "ln": np.log,
    "sgn": lambda x: np.sign(np.real(x)),
}


class Rules:
    """The ``lines`` of a sheet that gives ``numbers``, and the same as functions of columns."""

    def __init__(self, **numbers: float) -> None:
        self.numbers = numbers
        self.lines = [f"{name} = {v!r}" for name, v in numbers.items()]
        self.patterns: list[tuple[Callable[..., Any], list[Sequence[Cell]]]] = []

    def add(self, rule: str, **columns: Column) -> None:
        """A rule with ``{names}`` for each row of the columns that they stand for."""
        count = max(len(c) for c in columns.values() if not isinstance(c, str | int | float))
        alike = [
            [c] * count if isinstance(c, str | int | float) else list(c) for c in columns.values()
        ]
        texts = [
            [v if isinstance(v, str) else f"({float(v)!r})" for v in column] for column in alike
        ]
        self.lines += [
            rule.format(**dict(zip(columns, row, strict=True))) for row in zip(*texts, strict=True)
        ]
        left, right = re.sub(r"[{}]", "", rule).replace("^", "**").split("=")
        function = eval(
            f"lambda {', '.join(columns)}: {left} - ({right})", FUNCTIONS | self.numbers
        )
        self.patterns.append((function, alike))

    def balance(
        self,
        links: Sequence[Link],
        flows: Sequence[str],
        rest: str,
        but: Sequence[int] = (),
        **columns: Column,
    ) -> None:
        """What flows into each node, ``but`` some, along its links is the ``rest``, of columns by
        node."""
        near: dict[int, list[tuple[str, str]]] = defaultdict(list)
        for flow, (a, b) in zip(flows, links, strict=True):
            near[a].append(("-", flow))
            near[b].append(("+", flow))
        alike: dict[str, list[int]] = defaultdict(list)
        for node in sorted(near.keys() - set(but)):
            alike["".join(sign for sign, _ in near[node])].append(node)
        for signs, nodes in alike.items():
            into = " ".join(f"{sign} {{q{k}}}" for k, sign in enumerate(signs))
            mine = {f"q{k}": [near[node][k][1] for node in nodes] for k in range(len(signs))}
            own = {
                n: c if isinstance(c, str | float) else [c[i] for i in nodes]
                for n, c in columns.items()
            }
            self.add(f"0 {into} = {rest}", **mine, **own)

    def network(self, title: str, **start: float | Sequence[float]) -> Network:
        """With where Newton's method by hand starts, by the letters that names begin with."""
        cells = (cell for _, columns in self.patterns for column in columns for cell in column)
        names = [cell for cell in dict.fromkeys(cells) if isinstance(cell, str)]
        place = {name: i for i, name in enumerate(names)}
        parts = [re.fullmatch(r"([A-Za-z]+)(\d*)", name) for name in names]
        begin = [start[part[1]] for part in parts if part]
        at = [
            v[int(p[2])] if p and isinstance(v, Sequence) else v
            for v, p in zip(begin, parts, strict=True)
        ]
        return Network(
            title, "\n".join(self.lines) + "\n", names, np.array(at, float), self._system(place)
        )

    def _system(self, place: Mapping[str, int]) -> Callable[[Any], tuple[Any, Any]]:
        n, patterns = len(place), []
        for function, columns in self.patterns:
            inputs = []
            for column in columns:
                mine = np.array([place.get(v, -1) if isinstance(v, str) else -1 for v in column])
                inputs.append((mine, np.array([0.0 if isinstance(v, str) else v for v in column])))
            patterns.append((function, inputs))

        def system(x: Any) -> tuple[Any, Any]:
            found, entries, total = [], [], 0
            for function, inputs in patterns:
                at = [np.where(mine < 0, numbers, x[mine]) for mine, numbers in inputs]
                rows = total + np.arange(len(at[0]))
                total += len(rows)
                found.append(function(*at))
                for k, (mine, _) in enumerate(inputs):
                    moves = mine >= 0
                    if moves.any():
                        moved = [v + 1j * STEP * moves if i == k else v for i, v in enumerate(at)]
                        slopes = np.imag(function(*moved))[moves] / STEP
                        entries.append((slopes, rows[moves], mine[moves]))
            data, row, column = (np.concatenate(part) for part in zip(*entries, strict=True))
            return np.concatenate(found), csc_array((data, (row, column)), shape=(n, n))

        return system


def some(letter: str, count: int, first: int = 0) -> list[str]:
    return [f"{letter}{i}" for i in range(first, first + count)]


def lattice(n: int, m: int = 0) -> list[Link]:
    """The links of n x m nodes, each to the next in its row and to that in the next row."""
    m = m or n
    along = [(i * m + j, i * m + j + 1) for i in range(n) for j in range(m - 1)]
    return along + [(i * m + j, i * m + m + j) for i in range(n - 1) for j in range(m)]


def at(values: Sequence[Cell], links: Sequence[Link], side: int) -> list[Cell]:
    return [values[link[side]] for link in links]


def around(n: int, letter: str, edge: Callable[[int, int], float]) -> dict[str, list[Cell]]:
    """Columns of the inner points ``o`` of n x n, and of their neighbours ``w``, ``e``, ``s``,
    ``n``."""

    def name(i: int, j: int) -> Cell:
        inner = 0 < i <= n and 0 < j <= n
        return f"{letter}{(i - 1) * n + j - 1}" if inner else edge(i, j)

    inner = [(i, j) for i in range(1, n + 1) for j in range(1, n + 1)]
    moves = {"o": (0, 0), "w": (-1, 0), "e": (1, 0), "s": (0, -1), "n": (0, 1)}
    return {key: [name(i + di, j + dj) for i, j in inner] for key, (di, dj) in moves.items()}


# --- water, gas and air ---


def water(n: int) -> Network:
    """Pipes after Hazen and Williams, fed by a pump from a sump, with a tank at the opposite
    corner."""
    rules, links, m = Rules(), lattice(n), n * n
    h, q = [*some("H", m - 1), 40.0], some("Q", len(links))
    rules.add("{a} - {b} = 30*{q}*abs({q})^0.852", a=at(h, links, 0), b=at(h, links, 1), q=q)
    rules.add("{h} = 60 - 40*{p}^2", h=["H0"], p=["P0"])
    rules.balance([*links, (-1, 0)], [*q, "P0"], "{d}", [-1, m - 1], d=[0.8 / m] * m)
    return rules.network(f"water {n} x {n}", H=45.0, Q=0.05, P=0.5)


def manifold(n: int) -> Network:
    """A header with n nozzles."""
    rules, p, m, q = Rules(r=20.0 / n**3, C=1.0), [3.0, *some("p", n)], some("m", n), some("q", n)
    rules.add("{a} - {b} = r*{m}^2", a=p[:-1], b=p[1:], m=m)
    rules.add("{q} = C*sqrt({p})", q=q, p=p[1:])
    rules.add("{m} = {next} + {q}", m=m, next=[*m[1:], 0.0], q=q)
    return rules.network(f"manifold {n}", p=2.0, q=1.5, m=[1.5 * (n - i) for i in range(n)])


def compressors(n: int) -> Network:
    """Two gas pipelines of n nodes with cross links, and compressors of given power in five
    places."""
    rules, links, m = Rules(k=40.0 / n), lattice(2, n), 2 * n
    p, q = [60.0 if i in (0, n) else f"p{i}" for i in range(m)], some("q", len(links))
    driven = [a % n % (n // 5) == n // 5 - 1 and b == a + 1 for a, b in links]
    for chosen, rule in (
        (False, "{a}^2 - {b}^2 = k*{q}*abs({q})"),
        (True, "0.2 = {q}*(({b}/{a})^0.28 - 1)"),
    ):
        there = [k for k, d in enumerate(driven) if d == chosen]
        mine = [links[k] for k in there]
        rules.add(rule, a=at(p, mine, 0), b=at(p, mine, 1), q=[q[k] for k in there])
    rules.balance(links, q, "{d}", [0, n], d=[10.0 / n] * m)
    return rules.network(
        f"compressors {n}", p=60.0, q=[10.0 * (1 - a % n / n) + 0.1 for a, _ in links]
    )


def ventilation(n: int) -> Network:
    """Leaks of a house of n floors with 4 rooms each, driven by wind and warm air."""
    rules, m = Rules(C=0.02), 4 * n
    p, links = some("p", m), lattice(n, 4)
    q, inside, outside = (
        some("q", len(links)),
        some("o", m),
        [3.0 - 2.0 * (i % 4) for i in range(m)],
    )
    rules.add(
        "{q} = 5*C*sgn({a} - {b})*abs({a} - {b})^0.65", q=q, a=at(p, links, 0), b=at(p, links, 1)
    )
    lift = [outside[i] - 0.4 * (i // 4) for i in range(m)]
    rules.add("{q} = C*sgn({w} - {p})*abs({w} - {p})^0.65", q=inside, w=lift, p=p)
    rules.balance(links, q, "0 - {o}", o=inside)
    return rules.network(
        f"ventilation {n}", p=[-0.4 * (i // 4) - 0.3 * (i % 4) for i in range(m)], q=0.0, o=0.0
    )


# --- heat ---


def slab(n: int) -> Network:
    """A field of n x n lumps that conduct the better the hotter they are and radiate; one is
    heated."""
    rules, links, m = Rules(), lattice(n), n * n
    t, q = some("T", m), some("q", len(links))
    a, b = at(t, links, 0), at(t, links, 1)
    rules.add("{q} = (0.5 + 0.001*({a} + {b})/2)*({a} - {b})", q=q, a=a, b=b)
    heat = [500.0 * (i == m // 2) for i in range(m)]
    rules.balance(links, q, "5e-9*({t}^4 - 300^4) - {w}", t=t, w=heat)
    return rules.network(f"slab {n} x {n}", T=350.0, q=0.0)


def wall(n: int) -> Network:
    """n x n lumps that conduct by a power of their temperature, heated below and radiating
    above."""
    rules, links, m = Rules(), lattice(n), n * n
    t, q, s = some("T", m), some("q", len(links)), some("s", m)
    rules.add(
        "{q} = 2*(({a} + {b})/600)^1.5*({a} - {b})", q=q, a=at(t, links, 0), b=at(t, links, 1)
    )
    rules.add("{s} = 5e-8*({t}^4 - 290^4)", s=s[:n], t=t[:n])
    rules.add("{s} = 0.1*({t} - 300)", s=s[n:-n], t=t[n:-n])
    rules.add("{s} = 5*({t} - 800)", s=s[-n:], t=t[-n:])
    rules.balance(links, q, "{s}", s=s)
    return rules.network(f"wall {n} x {n}", T=500.0, q=0.0, s=0.0)


def evaporators(n: int) -> Network:
    """Effects in series: the vapour of each heats the next, and the boiling point rises."""
    rules = Rules(F=10.0, A=4.0 * n)
    t, v, s = [130.0, *some("T", n - 1, 1), 55.0], some("V", n + 1), [10.0, *some("S", n, 1)]
    x = [0.05, *some("x", n, 1)]
    rules.add("{b} = {a} - {v}", a=s[:-1], b=s[1:], v=v[1:])
    rules.add("{b}*{x} = F*0.05", b=s[1:], x=x[1:])
    rules.add("{v}*(2500 - 2.4*{a}) = A*{U}*({a} - {b} - 2*{x})", v=v[:-1], a=t[:-1], b=t[1:], x=x[1:],
              U=[3.0 - 1.5 * i / n for i in range(n)])  # fmt: skip
    rules.add("{v}*(2500 - 2.4*{a}) + 4*{s}*({a} - {b}) = {w}*(2500 - 2.4*{b})", v=v[:-1], w=v[1:], a=t[:-1],
              b=t[1:], s=s[:-1])  # fmt: skip
    start = {
        "T": [130.0 - 75.0 * i / n for i in range(n + 1)],
        "S": [10.0 - 4.0 * i / n for i in range(n + 1)],
    }
    return rules.network(f"evaporators {n}", V=4.0 / n, x=0.07, **start)


def heating(n: int) -> Network:
    """Consumers along a line of district heating that loses heat the faster the less flows."""
    rules, t, flow, m = (
        Rules(loss=0.3 / n),
        [90.0, *some("T", n, 1)],
        [*some("M", n, 1), 0.0],
        some("m", n, 1),
    )
    rules.add("{b} = 10 + ({a} - 10)*exp(0 - loss/{M})", a=t[:-1], b=t[1:], M=flow[:-1])
    rules.add(
        "{q} = 4.18*{m}*({t} - 40)", q=[20.0 / n * (5 + i % 3) for i in range(n)], m=m, t=t[1:]
    )
    rules.add("{a} = {b} + {m}", a=flow[:-1], b=flow[1:], m=m)
    start = [0.6 * (n + 1 - i) / n + 0.01 for i in range(n + 1)]
    return rules.network(
        f"heating {n}", T=[90.0 - 15.0 * i / n for i in range(n + 1)], M=start, m=0.6 / n
    )


def turbine(n: int) -> Network:
    """Stages after Stodola, steam drawn from each third one."""
    rules, p, t, m = (
        Rules(),
        [100.0, *some("p", n - 1, 1), 0.05],
        [800.0, *some("T", n, 1)],
        some("m", n, 1),
    )
    k = [20.0 * (1 + i) ** 2 for i in range(n)]
    rules.add("{m}^2*{t} = {k}*({a}^2 - {b}^2)", m=m, t=t[:-1], a=p[:-1], b=p[1:], k=k)
    rules.add("{u} = {t}*(1 - 0.85*(1 - ({b}/{a})^0.23))", u=t[1:], t=t[:-1], a=p[:-1], b=p[1:])
    drawn = [0.01 * (i % 3 == 0) for i in range(n - 1)]
    rules.add("{b} = {a} - {e}*{p}", a=m[:-1], b=m[1:], p=p[1:-1], e=drawn)
    start = {
        "p": [100.0 - 90.0 * i / n for i in range(n + 1)],
        "T": [800.0 - 300.0 * i / n for i in range(n + 1)],
    }
    return rules.network(f"turbine {n}", m=10.0, **start)


# --- chemistry ---


def absorber(n: int) -> Network:
    """Mole ratios in a column of n stages in counterflow."""
    rules, x, y = Rules(L=1.2, G=1.0, m=0.9), [0.0, *some("x", n)], [*some("y", n), 0.15]
    rules.add("{y}/(1 + {y}) = m*{x}/(1 + {x})", x=x[1:], y=y[:-1])
    rules.add("L*{a} + G*{b} = L*{x} + G*{y}", a=x[:-1], b=y[1:], x=x[1:], y=y[:-1])
    return rules.network(f"absorber {n}", x=0.05, y=0.05)


def complexes(n: int) -> Network:
    """A metal with up to n ligands."""
    rules, m = Rules(), some("M", n + 1)
    rules.add(
        "{b} = {k}*{a}*{l}", a=m[:-1], b=m[1:], l="L", k=[10.0 ** (4 - 4 * k / n) for k in range(n)]
    )
    rules.add(" + ".join(f"{{{name}}}" for name in m) + " = 0.01", **{name: [name] for name in m})
    bound = " + ".join(f"{k}*{{{name}}}" for k, name in enumerate(m) if k)
    rules.add("{L} + " + bound + " = 0.03", **{name: [name] for name in m}, L=["L"])
    return rules.network(f"complexes {n}", M=0.01 / n, L=1e-3)


# --- structures ---


def cable(n: int) -> Network:
    """A heavy rope of n parts, 110 m long between ends 100 m apart."""
    rules = Rules(k=1e6)
    x, y = [0.0, *some("x", n - 1, 1), 100.0], [0.0, *some("y", n - 1, 1), 0.0]
    force, length = some("N", n), some("l", n)
    rules.add(
        "{l} = sqrt(({b} - {a})^2 + ({d} - {c})^2)", l=length, a=x[:-1], b=x[1:], c=y[:-1], d=y[1:]
    )
    rules.add("{N} = k*({l} - {r})/{r}", N=force, l=length, r=110.0 / n)
    columns = {"N": force[:-1], "M": force[1:], "l": length[:-1], "m": length[1:]}
    for u, load in ((x, 0.0), (y, -2000.0 / n)):
        rules.add(
            "{M}*({b} - {o})/{m} - {N}*({o} - {a})/{l} = {p}",
            a=u[:-2],
            o=u[1:-1],
            b=u[2:],
            p=load,
            **columns,
        )
    depth = [80.0 * i / n * (1 - i / n) for i in range(n + 1)]
    return rules.network(
        f"cable {n}", x=[100.0 * i / n for i in range(n + 1)], y=depth, N=2500.0, l=110.0 / n
    )


def cable_net(n: int) -> Network:
    """A net of n x n inner nodes, 5 % too short for its frame, under its weight."""
    rules = Rules(k=1000.0)
    links = [
        (a, b)
        for a, b in lattice(n + 2)
        if any(0 < i // (n + 2) <= n and 0 < i % (n + 2) <= n for i in (a, b))
    ]
    place = [divmod(i, n + 2) for i in range((n + 2) ** 2)]
    inner = [0 < i <= n and 0 < j <= n for i, j in place]
    spots = {c: [f"{c}{k}" if inner[k] else float((*p, 0)["xyz".index(c)]) for k, p in enumerate(place)]
             for c in "xyz"}  # fmt: skip
    lengths, forces = some("l", len(links)), some("N", len(links))
    ends = {f"{c}{side}": at(spots[c], links, side) for c in "xyz" for side in (0, 1)}
    rules.add("{l} = sqrt(({x1} - {x0})^2 + ({y1} - {y0})^2 + ({z1} - {z0})^2)", l=lengths, **ends)
    rules.add("{N} = k*({l} - 0.95)/0.95", N=forces, l=lengths)
    for c, load in (("x", 0.0), ("y", 0.0), ("z", -5.0)):
        pulls = some(f"p{c}", len(links))
        rules.add(
            "{p} = {N}*({b} - {a})/{l}",
            p=pulls,
            N=forces,
            l=lengths,
            a=ends[f"{c}0"],
            b=ends[f"{c}1"],
        )
        rules.balance(links, pulls, "{w}", [k for k, here in enumerate(inner) if not here], w=-load)
    flat = {c: [float(p[c == "y"]) for p in place] for c in "xy"}
    return rules.network(
        f"cable net {n} x {n}", z=0.0, l=1.0, N=50.0, px=0.0, py=0.0, pz=0.0, **flat
    )


def arch(n: int) -> Network:
    """A shallow arch between hinges under 90 % of the load at which it snaps through."""
    rules, h = Rules(D=1.0, A=100.0), 1.0 / n
    w = [0.0, *some("w", n - 1, 1), 0.0]
    m, s = [0.0, *some("m", n - 1, 1), 0.0], [0.0, *some("s", n)]
    rules.add(
        "{m} = ({a} - 2*{o} + {b})*{k}", m=m[1:-1], a=w[:-2], o=w[1:-1], b=w[2:], k=float(n * n)
    )
    slope = [0.2 * pi * cos(pi * (i + 0.5) / n) for i in range(n)]
    rules.add("{t} = {s} + (({b} - {a})*{z} + (({b} - {a})*{n})^2*{h}/2)", t=s[1:], s=s[:-1], a=w[:-1],
              b=w[1:], z=slope, n=float(n), h=h)  # fmt: skip
    bend = [-0.2 * pi**2 * sin(pi * i / n) for i in range(1, n)]
    rules.add("D*({a} - 2*{o} + {b})*{k} = {p} + A*{N}*({o} + {c})", a=m[:-2], o=m[1:-1], b=m[2:],
              k=float(n * n), p=[-17.0 * sin(pi * i / n) for i in range(1, n)], N=s[-1], c=bend)  # fmt: skip
    return rules.network(f"arch {n}", w=0.0, m=0.0, s=0.0)


def dome(n: int) -> Network:
    """Bars between the crown and three rings of n nodes, the outermost held, under a load on each
    node."""
    rules, rings = Rules(E=1e7), [0, *(k for k in (1, 2, 3) for _ in range(n))]
    turn = [2 * pi * (k - 1) / n for k in range(3 * n + 1)]
    x, y = ([4.0 * r * f(t) for r, t in zip(rings, turn, strict=True)] for f in (cos, sin))
    spots, held = (
        {"u": x, "v": y, "w": [2.0 - 0.2 * r * r for r in rings]},
        range(2 * n + 1, 3 * n + 1),
    )
    links = [(0, k) for k in range(1, n + 1)]
    for inner in (1, n + 1):
        beside = [(inner + k, inner + (k + 1) % n) for k in range(n)]
        links += beside + [(a, a + n) for a, _ in beside] + [(a, b + n) for a, b in beside]
    moves = {c: [0.0 if k in held else f"{c}{k}" for k in range(len(rings))] for c in spots}
    apart = {c: [place[b] - place[a] for a, b in links] for c, place in spots.items()}
    rest = [float(np.hypot(np.hypot(*two), one)) for *two, one in zip(*apart.values(), strict=True)]
    length, force = some("L", len(links)), some("N", len(links))
    ends = {f"{c}{side}": at(moves[c], links, side) for c in spots for side in (0, 1)}
    ends |= {f"d{c}": apart[c] for c in spots}
    squares = " + ".join(f"({{d{c}}} + {{{c}1}} - {{{c}0}})^2" for c in spots)
    rules.add(f"{{L}} = sqrt({squares})", L=length, **ends)
    rules.add("{N} = E*({L} - {r})/{r}", N=force, L=length, r=rest)
    for c, load in (("u", 0.0), ("v", 0.0), ("w", 1000.0 / n)):
        pulls = some(f"p{c}", len(links))
        ends_of = {"d": apart[c], "a": ends[f"{c}0"], "b": ends[f"{c}1"]}
        rules.add("{p} = {N}*({d} + {b} - {a})/{L}", p=pulls, N=force, L=length, **ends_of)
        rules.balance(links, pulls, "{z}", held, z=load)
    zero = dict.fromkeys(("u", "v", "w", "N", "pu", "pv", "pw"), 0.0)
    return rules.network(f"dome {n}", L=rest, **zero)


def minimal_surface(n: int) -> Network:
    """A soap film over a saddle, in triangles."""
    rules, m = Rules(), n + 1
    u = [[f"u{(i - 1) * n + j - 1}" if 0 < i <= n and 0 < j <= n else ((i / m) ** 2 - (j / m) ** 2) / 2
          for j in range(n + 2)] for i in range(n + 2)]  # fmt: skip
    cells = [(i, j) for i in range(m) for j in range(m)]
    area = {"v": some("v", m * m), "w": some("w", m * m)}
    corner = {k: [u[i + k // 2][j + k % 2] for i, j in cells] for k in range(4)}
    for c, one, p, q in (("v", 0, 2, 1), ("w", 3, 1, 2)):
        rule = "{w} = sqrt(1 + (({o} - {p})^2 + ({o} - {q})^2)*{k})"
        rules.add(rule, w=area[c], o=corner[one], p=corner[p], q=corner[q], k=float(m * m))
    inner = [(i, j) for i in range(1, m) for j in range(1, m)]
    weights = {"V": ("v", 0, 0), "S": ("v", -1, 0), "T": ("v", 0, -1), "W": ("w", -1, -1), "X": ("w", 0, -1),
               "Y": ("w", -1, 0)}  # fmt: skip
    columns = {
        k: [area[c][(i + di) * m + j + dj] for i, j in inner] for k, (c, di, dj) in weights.items()
    }
    columns |= {k: [u[i + di][j + dj] for i, j in inner] for k, di, dj in (("o", 0, 0), ("e", 1, 0),
              ("n", 0, 1), ("b", -1, 0), ("a", 0, -1))}  # fmt: skip
    rules.add("({o} - {e})*(1/{V} + 1/{X}) + ({o} - {n})*(1/{V} + 1/{Y}) + "
              "({o} - {b})*(1/{S} + 1/{W}) + ({o} - {a})*(1/{T} + 1/{W}) = 0", **columns)  # fmt: skip
    saddle, steep = ([((i / m) ** 2 - (j / m) ** 2) / 2 for i, j in inner],
                     [float(np.sqrt(1 + (i / m) ** 2 + (j / m) ** 2)) for i, j in cells])  # fmt: skip
    return rules.network(f"minimal surface {n} x {n}", u=saddle, v=steep, w=steep)


# --- fields ---


def screening(n: int) -> Network:
    """Poisson and Boltzmann in a square, one edge at a high potential."""
    rules = Rules(k=20.0)
    field = around(n, "u", lambda i, j: 6.0 * (i == 0))
    rules.add("({w} + {e} + {s} + {n} - 4*{o})*{m} = k*sinh({o})", m=float((n + 1) ** 2), **field)
    return rules.network(f"screening {n} x {n}", u=1.0)


def junction(n: int) -> Network:
    """The potential of a diode without a voltage, doped up to 1e7 times its intrinsic carriers."""
    doping = [1e7 if i >= n // 2 else -1e5 for i in range(n)]
    ends = [float(np.arcsinh(doping[0] / 2)), float(np.arcsinh(doping[-1] / 2))]
    rules, u = Rules(), [ends[0], *some("u", n - 2, 1), ends[1]]
    rules.add("({a} - 2*{o} + {b})*{k} = exp({o}) - exp(-{o}) - {d}", a=u[:-2], o=u[1:-1], b=u[2:],
              k=1e4 * n * n, d=doping[1:-1])  # fmt: skip
    return rules.network(f"junction {n}", u=[float(np.arcsinh(d / 2)) for d in doping])


def bearing(n: int) -> Network:
    """A gas film under a pad that tapers (Reynolds)."""
    rules, p, h = Rules(L=20.0), [1.0, *some("p", n), 1.0], 1.0 / (n + 1)
    gap = [2.0 - (i + 0.5) * h for i in range(n + 1)]
    rules.add(
        "{q} = ({a} + {b})/2*({g}^3*({a} - {b})/{h} + L*{g})", q="q", a=p[:-1], b=p[1:], g=gap, h=h
    )
    return rules.network(f"bearing {n}", p=[1.0 + 2.0 * i / n for i in range(n)], q=30.0)


# --- electricity ---


def three_phases(n: int) -> Network:
    """A feeder of n nodes with three phases, coupled and loaded unequally."""
    rules, own, mutual = Rules(), complex(0.02, 0.04) * 20 / n, complex(0.005, 0.015) * 20 / n
    fed = [complex(1.0), complex(-0.5, -(0.75**0.5)), complex(-0.5, 0.75**0.5)]
    v = [
        [[getattr(fed[p], k), *some(f"V{'abc'[p]}{k[0]}", n)] for k in ("real", "imag")]
        for p in range(3)
    ]
    i = [[[*some(f"I{'abc'[p]}{k}", n), 0.0] for k in "ri"] for p in range(3)]
    for p in range(3):
        columns = {f"{c}{s}": i[s][k][:-1] for s in range(3) for k, c in enumerate("xy")}
        z = {s: own if s == p else mutual for s in range(3)}
        real = " + ".join(f"{z[s].real!r}*{{x{s}}} - {z[s].imag!r}*{{y{s}}}" for s in range(3))
        imag = " + ".join(f"{z[s].real!r}*{{y{s}}} + {z[s].imag!r}*{{x{s}}}" for s in range(3))
        for k, drop in enumerate((real, imag)):
            rules.add(f"{{a}} - {{b}} = {drop}", a=v[p][k][:-1], b=v[p][k][1:], **columns)
        ends = {"v": v[p][0][1:], "w": v[p][1][1:], "x": i[p][0][:-1], "X": i[p][0][1:],
                "y": i[p][1][:-1], "Y": i[p][1][1:]}  # fmt: skip
        load = [(0.5 + 0.4 * ((k + p) % 3)) / n for k in range(n)]
        rules.add("{v}*({x} - {X}) + {w}*({y} - {Y}) = {s}", s=load, **ends)
        rules.add("{w}*({x} - {X}) - {v}*({y} - {Y}) = {s}", s=[0.3 * s for s in load], **ends)
    start: dict[str, float] = {
        f"V{'abc'[p]}{k[0]}": getattr(fed[p], k) for p in range(3) for k in ("real", "imag")
    }
    return rules.network(
        f"three phases {n}", **start, **{f"I{c}{k}": 0.1 for c in "abc" for k in "ri"}
    )


def solar(n: int) -> Network:
    """n solar cells in series, unequally lit, each with a diode that takes its current past it."""
    rules, v, s = Rules(I0=1e-9, a=0.035, U=0.4 * n), some("v", n), [0.0, *some("s", n - 1, 1)]
    lit = [5.0 - 1.5 * (k % 4 == 1) - 0.02 * (k % 7) for k in range(n)]
    cell = "{i} = {l} - I0*(exp(({v} + {i}*0.005)/a) - 1) - {v}/20 + 1e-6*(exp(-{v}/0.04) - 1)"
    rules.add(cell, i="I", l=lit, v=v)
    rules.add("{t} = {s} + {v}", t=[*s[1:], "U0"], s=s, v=v)
    rules.add("{t} = {s}", t=["U0"], s=[0.4 * n])
    return rules.network(f"solar {n}", I=4.0, v=[-0.4 if k % 4 == 1 else 0.6 for k in range(n)],
              s=[0.4 * k for k in range(n)], U=0.4 * n)  # fmt: skip


def transistors(n: int) -> Network:
    """Amplifiers after Ebers and Moll, in a chain."""
    rules = Rules(I=1e-14, T=0.02585)
    b, c, e, f, r = (some(letter, n) for letter in "bceFR")
    rules.add("{f} = I*(exp(({b} - {e})/T) - 1)", f=f, b=b, e=e)
    rules.add("{r} = I*(exp(({b} - {c})/T) - 1)", r=r, b=b, c=c)
    rules.add(
        "(5 - {c})/2200 = {f} - {r}*1.5 + ({c} - {next})/100000", c=c, f=f, r=r, next=[*b[1:], 0.0]
    )
    rules.add("{e}/220 = {f}*1.01 - {r}", e=e, f=f, r=r)
    rules.add("({last} - {b})/100000 + (5 - {b})/{k} = {b}/10000 + {f}/100 + {r}/2", last=[0.0, *c[:-1]],
              b=b, f=f, r=r, k=[47e3 + 3e3 * (k % 3) for k in range(n)])  # fmt: skip
    return rules.network(f"transistors {n}", b=0.9, c=3.0, e=0.2, F=1e-3, R=0.0)


def magnets(n: int) -> Network:
    """Flux in a frame of n x n limbs that saturate, driven by a coil."""
    rules, links, m = Rules(), lattice(n), n * n
    u, q = [0.0, *some("u", m - 1, 1)], some("f", len(links))
    coil = [200.0 * (k == len(links) // 3) for k in range(len(links))]
    rules.add(
        "{a} - {b} + {w} = 20*{f} + 8*{f}^9", a=at(u, links, 0), b=at(u, links, 1), w=coil, f=q
    )
    rules.balance(links, q, "{z}", [0], z=0.0)
    return rules.network(f"magnets {n} x {n}", u=0.0, f=0.5)


# --- many agents ---


def traffic(n: int) -> Network:
    """n pairs of towns, each with a road of its own and one shared with the next; drivers weigh the
    times."""
    rules = Rules(W=0.5)
    x, v, s, t = some("x", n), some("v", n), some("s", n), some("t", n)
    demand = [8.0 + 3.0 * (k % 5) for k in range(n)]
    rules.add("{x} = {d}/(1 + exp(W*({t} - {s})))", x=x, d=demand, t=t, s=s)
    rules.add("{t} = 10*(1 + 0.15*(({x} + 0.3*{y})/6)^4)", t=t, x=x, y=[*x[1:], x[0]])
    rules.add(
        "{v} = {d} - {x} + {e} - {y}",
        v=v,
        d=demand,
        x=x,
        e=[*demand[1:], demand[0]],
        y=[*x[1:], x[0]],
    )
    rules.add("{s} = 12*(1 + 0.15*({v}/12)^4)", s=s, v=v)
    return rules.network(f"traffic {n}", x=[d / 2 for d in demand], v=12.0, s=14.0, t=12.0)


def epidemic(n: int) -> Network:
    """The share of infected in n towns, above the threshold."""
    rules, x = Rules(), some("x", n)
    near = {"a": [x[i - 1] for i in range(n)], "b": [x[(i + 1) % n] for i in range(n)]}
    near["c"] = [x[(i + n // 3) % n] for i in range(n)]
    rules.add(
        "{k}*(1 - {x})*({a} + {b} + {c}) = {x}",
        x=x,
        k=[0.4 + 0.1 * (i % 4) for i in range(n)],
        **near,
    )
    return rules.network(f"epidemic {n}", x=0.5)


def ages(n: int) -> Network:
    """Classes of a population whose births fall with its size; it could die out."""
    rules, m = Rules(), some("N", n)
    rules.add(
        "{b} = {s}*{a}", a=m[:-1], b=m[1:], s=[0.98 - 0.6 * (i / n) ** 4 for i in range(n - 1)]
    )
    every = {name: [name] for name in m}
    rules.add("{t} = " + " + ".join(f"{{{name}}}" for name in m), t=["total"], **every)
    births = {name: [name] for name in m[n // 5 : n // 2]}
    total = " + ".join(f"{{{name}}}" for name in births)
    rules.add(f"{{n}} = 0.4*exp(0 - {{t}}/1000)*({total})", n=["N0"], t=["total"], **births)
    return rules.network(f"ages {n}", N=[100.0 - 90.0 * i / n for i in range(n)], total=1500.0)


KINDS: dict[Callable[[int], Network], tuple[int, ...]] = {
    water: (5, 12, 30),
    manifold: (20, 300),
    compressors: (20, 100),
    ventilation: (8, 60),
    slab: (6, 25),
    wall: (6, 30),
    evaporators: (6, 20),
    heating: (20, 100),
    turbine: (15, 150),
    absorber: (20, 100, 400),
    complexes: (10, 30),
    cable: (20, 100, 500),
    cable_net: (6, 20),
    arch: (40, 400),
    dome: (14, 30),
    minimal_surface: (8, 30),
    screening: (10, 50),
    junction: (50, 1000),
    bearing: (40, 1000),
    three_phases: (20, 150),
    solar: (20, 300),
    transistors: (20, 200),
    magnets: (6, 20),
    traffic: (30, 600),
    epidemic: (40, 1000),
    ages: (40, 200),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help="some kinds alone")
    parser.add_argument("--size", type=int, help="this size instead")
    options = parser.parse_args()
    warm_up()
    print(aligned(HEAD))
    held = count = 0
    for kind, sizes in KINDS.items():
        if options.kinds and kind.__name__ not in options.kinds:
            continue
        for n in (options.size,) if options.size else sizes:
            cells = line(kind(n), peers=False)
            print(aligned(cells), flush=True)
            held, count = held + (cells[5] == "yes"), count + 1
    print(f"{held} of {count} held")


if __name__ == "__main__":
    main()
