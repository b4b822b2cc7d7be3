"""Sheets of many small blocks in a row, or of many equal cells: load and solve, beside a Newton by
hand.

    python -m benchmarks.chains [--small] [--only WORD]

prints the columns of ``benchmarks.networks``, and holds a sheet to the same. By hand all cells are
solved at once: Newton's method with a sparse matrix, whose entries are complex steps on the
equations of a cell.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from benchmarks.networks import HEAD, Network, aligned, line, warm_up

Cell = Callable[[Any, Any, Any], Sequence[Any]]
TINY = 1e-30


def chain(
    title: str,
    n: int,
    fields: str,
    ends: tuple[Any, Any],
    start: Any,
    cell: Cell,
    rules: Sequence[str],
) -> Network:
    """n cells with the ``fields`` (names without their numbers), each beside the one before and the
    next.

    ``cell(before, here, after)`` is what is 0, of each field; ``ends`` are the values of the fields
    before the first and after the last cell. A rule with ``{i}`` stands for all cells, ``{h}`` is
    the one before and ``{j}`` the next; rules without are written once.
    """
    names = fields.split()
    m = len(names)
    low, high = (np.broadcast_to(np.asarray(end, dtype=float), m)[:, None] for end in ends)

    def beside(x: Any) -> list[Any]:
        return [np.hstack([low, x[:, :-1]]), x, np.hstack([x[:, 1:], high])]

    def system(flat: Any) -> tuple[Any, Any]:
        parts = beside(flat.reshape(m, n))
        entries, places = [], np.arange(m * n).reshape(m, n)
        for shift in (-1, 0, 1):
            there = (np.arange(n) + shift >= 0) & (np.arange(n) + shift < n)
            for k in range(m):
                moved = [part.astype(complex) for part in parts]
                moved[1 + shift][k] += 1j * TINY
                slopes = np.array(np.broadcast_arrays(*cell(*moved))).imag / TINY
                columns = np.broadcast_to(places[k] + shift, (m, n))
                entries.append([part[:, there].ravel() for part in (slopes, places, columns)])
        data, rows, columns = (np.concatenate(part) for part in zip(*entries, strict=True))
        residual = np.array(np.broadcast_arrays(*cell(*parts))).ravel()
        return residual, csr_array(
            (data, (rows.astype(int), columns.astype(int))), shape=(m * n, m * n)
        )

    text = [rule for rule in rules if "{" not in rule]
    for i in range(1, n + 1):
        text += [rule.format(h=i - 1, i=i, j=i + 1) for rule in rules if "{" in rule]
    begin = np.broadcast_to(np.asarray(start, dtype=float).reshape(m, -1), (m, n)).ravel()
    every = [f"{name}{i}" for name in names for i in range(1, n + 1)]
    return Network(f"{title} {n}", "\n".join(text) + "\n", every, begin.copy(), system)


# --- steps in space and time ----------------------------------------------------------


def backwater(n: int) -> Network:
    """Water held up to 3 m by a weir: depths upstream by the standard step method, not the shooting
    ones."""

    def energy(y: Any) -> tuple[Any, Any]:
        area = 10.0 * y
        return y + (30.0 / area) ** 2 / 19.62, (
            0.025 * 30.0 / (area * (area / (10.0 + 2.0 * y)) ** (2 / 3))
        ) ** 2

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        (low, lost), (high, loses) = energy(before[0]), energy(here[0])
        return [high - low + 20.0 * (0.001 - (lost + loses) / 2)]

    rules = ["y0 = 3", "Q = 30", "b = 10", "rough = 0.025", "A0 = b*y0", "R0 = A0/(b + 2*y0)"]
    rules += ["E0 = y0 + (Q/A0)^2/19.62", "J0 = (rough*Q/(A0*R0^(2/3)))^2"]
    rules += ["A{i} = b*y{i}", "R{i} = A{i}/(b + 2*y{i})", "E{i} = y{i} + (Q/A{i})^2/19.62"]
    rules += ["J{i} = (rough*Q/(A{i}*R{i}^(2/3)))^2", "E{i} = E{h} - 20*(0.001 - (J{i} + J{h})/2)"]
    return chain("backwater", n, "y", (3.0, 0.0), 2.5, cell, rules)


def implicit_euler(n: int) -> Network:
    """Logistic growth by implicit steps, each with a positive and a negative root."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        return [here[0] - before[0] - 0.02 * here[0] * (1.0 - here[0] / 50.0)]

    rules = ["y0 = 5", "y{i} = y{h} + 0.02*y{i}*(1 - y{i}/50)"]
    return chain("implicit Euler", n, "y", (5.0, 0.0), 30.0, cell, rules)


def runge_kutta(n: int) -> Network:
    """The same growth by the classical explicit steps."""

    def rate(y: Any) -> Any:
        return 0.5 * y * (1.0 - y / 50.0)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        y, h = before[0], 0.02
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        return [here[0] - y - h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))]

    ks = ["a{i} = 0.5*y{h}*(1 - y{h}/50)"]
    for new, old, part in (("b", "a", "0.01"), ("c", "b", "0.01"), ("d", "c", "0.02")):
        at = f"(y{{h}} + {part}*{old}{{i}})"
        ks.append(f"{new}{{i}} = 0.5*{at}*(1 - {at}/50)")
    rules = ["y0 = 5", *ks, "y{i} = y{h} + 0.02/6*(a{i} + 2*b{i} + 2*c{i} + d{i})"]
    return chain("Runge-Kutta", n, "y", (5.0, 0.0), 30.0, cell, rules)


def pendulum(n: int) -> Network:
    """A pendulum by the trapezoidal rule: two unknowns a step."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        swing = here[0] - before[0] - 0.005 * (here[1] + before[1])
        return [swing, here[1] - before[1] + 0.005 * 9.81 * (np.sin(here[0]) + np.sin(before[0]))]

    rules = ["a0 = 1", "w0 = 0", "a{i} = a{h} + 0.005*(w{i} + w{h})"]
    rules += ["w{i} = w{h} - 0.005*9.81*(sin(a{i}) + sin(a{h}))"]
    times = 0.01 * np.arange(1, n + 1)
    start = np.array([np.cos(3.0 * times), -3.0 * np.sin(3.0 * times)])
    return chain("pendulum", n, "a w", ((1.0, 0.0), 0.0), start, cell, rules)


def gas_line(n: int) -> Network:
    """Pressure along a gas line, compressibility at the mean of each step."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        z = 1.0 - 0.002 * (here[0] + before[0]) / 2.0
        return [before[0] ** 2 - here[0] ** 2 - 2000.0 / n * z]

    rules = [
        "p0 = 60",
        "z{i} = 1 - 0.002*(p{h} + p{i})/2",
        f"p{{h}}^2 - p{{i}}^2 = {2000.0 / n!r}*z{{i}}",
    ]
    return chain("gas line", n, "p", (60.0, 0.0), 50.0, cell, rules)


def excitable(n: int) -> Network:
    """A nerve by FitzHugh and Nagumo in implicit steps: three roots a step where these are long."""
    h = 20.0 / n

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        v, w = here
        return [
            v - before[0] - h * (v - v**3 / 3.0 - w + 0.5),
            w - before[1] - h * 0.08 * (v + 0.7 - 0.8 * w),
        ]

    start, at = np.empty((2, n)), np.array([-1.0, -0.5])
    for i in range(n):  # many short explicit steps
        for _ in range(100):
            v, w = at
            at = at + h / 100.0 * np.array([v - v**3 / 3.0 - w + 0.5, 0.08 * (v + 0.7 - 0.8 * w)])
        start[:, i] = at
    rules = ["v0 = -1", "w0 = -0.5", f"h = {h!r}", "v{i} = v{h} + h*(v{i} - v{i}^3/3 - w{i} + 0.5)"]
    rules += ["w{i} = w{h} + h*0.08*(v{i} + 0.7 - 0.8*w{i})"]
    return chain("excitable", n, "v w", ((-1.0, -0.5), 0.0), start, cell, rules)


def friction(n: int) -> Network:
    """Mach numbers along a pipe by Fanno's law, subsonic and not supersonic."""

    def length(m: Any) -> Any:
        return (1.0 - m**2) / (1.4 * m**2) + 1.2 / 1.4 * np.log(1.2 * m**2 / (1.0 + 0.2 * m**2))

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        return [length(before[0]) - length(here[0]) - 0.5 / n]

    law = "(1 - M{i}^2)/(1.4*M{i}^2) + 1.2/1.4*ln(1.2*M{i}^2/(1 + 0.2*M{i}^2))"
    rules = [
        "M0 = 0.4",
        "f0 = " + law.format(i=0),
        f"f{{i}} = f{{h}} - {0.5 / n!r}",
        "f{i} = " + law,
    ]
    return chain("friction", n, "M", (0.4, 0.0), 0.5, cell, rules)


# --- stages of a plant ----------------------------------------------------------------


def exchangers(n: int) -> Network:
    """Cold water through exchangers in a row, each with hot water of its own."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        t, q, hot = here
        one, other = 95.0 - t, hot - before[0]
        mean = (one - other) / np.log(one / other)
        return [q - 20.0 * (t - before[0]), q - 60.0 / n * (95.0 - hot), q - 40.0 / n * mean]

    rules = ["t0 = 15", f"C = {60.0 / n!r}", f"UA = {40.0 / n!r}", "Q{i} = 20*(t{i} - t{h})"]
    rules += ["Q{i} = C*(95 - u{i})", "Q{i} = UA*(d{i} - e{i})/ln(d{i}/e{i})"]
    rules += ["d{i} = 95 - t{i}", "e{i} = u{i} - t{h}"]
    t = 95.0 - 80.0 * np.exp(-1.4 / n * np.arange(1, n + 1))
    q = 20.0 * np.diff(t, prepend=15.0)
    return chain(
        "exchangers", n, "t Q u", ((15.0, 0.0, 0.0), 0.0), [t, q, 95.0 - n / 60 * q], cell, rules
    )


def chemostats(n: int) -> Network:
    """Cells that grow in tanks in a row by the law of Monod; in the first they could be washed
    out."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        s, x = here
        grown = 0.9 * s / (0.5 + s) * x
        fed = 0.3 * (before[0] - s) + 0.1 * (10.0 - s)
        return [fed - 2.0 * grown, 0.3 * before[1] - 0.4 * x + grown]

    rules = ["s0 = 10", "x0 = 0", "m{i} = 0.9*s{i}/(0.5 + s{i})"]
    rules += ["0.3*(s{h} - s{i}) + 0.1*(10 - s{i}) = 2*m{i}*x{i}"]
    rules += ["0.3*x{h} - 0.4*x{i} + m{i}*x{i} = 0"]
    return chain("chemostats", n, "s x", ((10.0, 0.0), 0.0), [[0.3], [4.8]], cell, rules)


def compressors(n: int) -> Network:
    """Stages of a compressor, the head of each by the flow through its middle."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        (t0, p0), (t, p) = before, here
        flow = 20.0 * 287.0 * (t + t0) / (p + p0) / (0.2 * 250.0)
        head = (0.5 - 0.4 * flow**2) * 250.0**2 / 10.0
        return [1005.0 * (t - t0) - head, p - p0 * (1.0 + 0.88 * head / (1005.0 * t0)) ** 3.5]

    rules = ["t0 = 288", "p0 = 101325", "f{i} = 20*287*(t{h} + t{i})/(p{h} + p{i})/(0.2*250)"]
    rules += ["H{i} = (0.5 - 0.4*f{i}^2)*250^2/10", "1005*(t{i} - t{h}) = H{i}"]
    rules += ["p{i} = p{h}*(1 + 0.88*H{i}/(1005*t{h}))^3.5"]
    t = 288.0 + 2.5 * np.arange(1, n + 1)
    start = np.array([t, 101325.0 * (t / 288.0) ** 3])
    return chain("compressors", n, "t p", ((288.0, 101325.0), 0.0), start, cell, rules)


def cooling_tower(n: int) -> Network:
    """Water and air in counterflow by the law of Merkel, in steps from the cold end."""
    step = 1.2 / n

    def saturated(t: Any) -> Any:
        pressure = 611.2 * np.exp(17.62 * t / (243.12 + t))
        return 1.006 * t + 0.622 * pressure / (101325.0 - pressure) * (2501.0 + 1.86 * t)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        (t0, h0), (t, h) = before, here
        moved = step * (saturated(t) - h + saturated(t0) - h0) / 2.0
        return [4.19 * (t - t0) - moved, h - h0 - 1.1 * moved]

    laws = ["p{i} = 611.2*exp(17.62*t{i}/(243.12 + t{i}))", "w{i} = 0.622*p{i}/(101325 - p{i})"]
    laws.append("s{i} = 1.006*t{i} + w{i}*(2501 + 1.86*t{i})")
    rules = ["t0 = 26", "H0 = 55", *(law.format(i=0) for law in laws), *laws]
    rules += [f"m{{i}} = {step!r}*(s{{i}} - H{{i}} + s{{h}} - H{{h}})/2"]
    rules += ["4.19*(t{i} - t{h}) = m{i}", "H{i} = H{h} + 1.1*m{i}"]
    along = np.arange(1, n + 1) / n
    start = [26.0 + 6.0 * along, 55.0 + 25.0 * along]
    return chain("cooling tower", n, "t H", ((26.0, 55.0), 0.0), start, cell, rules)


# --- circuits, queues, choices --------------------------------------------------------


def mosfets(n: int) -> Network:
    """Stages with a resistor at the source: one of two roots for each current is below the
    threshold."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        gate, over, current = here
        drawn = 0.001 * over**2
        return [
            gate - 4.0 + 600.0 * before[2],
            over - gate + 1.0 + 1000.0 * current,
            current - drawn,
        ]

    rules = ["i0 = 0.001", "g{i} = 4 - 600*i{h}", "o{i} = g{i} - 1 - 1000*i{i}"]
    return chain(
        "MOSFETs", n, "g o i", ((0.0, 0.0, 0.001), 0.0), [[4.0], [1.0], [0.001]], cell,
        [*rules, "i{i} = 0.001*o{i}^2"],
    )  # fmt: skip


def queues(n: int) -> Network:
    """Servers in a row; the fuller one is, the more come back to it."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        rate, wait = here
        return [
            rate - 0.999 * before[0] * (1.0 - 0.2 * before[0]) - 0.2 * rate**2,
            wait * (1.0 - rate) - 1.0,
        ]

    rules = [
        "a0 = 0.5",
        "a{i} = 0.999*s{h} + 0.2*a{i}*r{i}",
        "r{i} = a{i}/1",
        "s0 = a0*(1 - 0.2*a0)",
    ]
    rules += ["s{i} = a{i}*(1 - 0.2*r{i})", "w{i} = 1/(1 - a{i})"]
    return chain("queues", n, "a w", (0.5, 0.0), [[0.4], [1.6]], cell, rules)


def choices(n: int) -> Network:
    """Shares of a logit model, each with its own and its neighbour's crowding."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        return [here[0] * (1.0 + np.exp(-(1.0 - 4.0 * here[0] + 2.0 * before[0]))) - 1.0]

    rules = ["p0 = 0.3", "u{i} = 1 - 4*p{i} + 2*p{h}", "p{i} = 1/(1 + exp(-u{i}))"]
    return chain("choices", n, "p", (0.3, 0.0), 0.4, cell, rules)


# --- blocks that do not depend on one another ---------------------------------------


def channels(n: int) -> Network:
    """Depths of flow in the reaches of a river that tributaries join, by the law of Manning."""
    flows = 5.0 + 0.1 * np.arange(1, n + 1)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        area = here[0] * (6.0 + 2.0 * here[0])
        wetted = 6.0 + 2.0 * 5.0**0.5 * here[0]
        return [flows - area ** (5 / 3) / wetted ** (2 / 3) * 0.001**0.5 / 0.03]

    rules = ["Q0 = 5", "Q{i} = Q{h} + 0.1", "A{i} = y{i}*(6 + 2*y{i})", "P{i} = 6 + 2*sqrt(5)*y{i}"]
    rules += ["Q{i} = A{i}*(A{i}/P{i})^(2/3)*sqrt(0.001)/0.03"]
    return chain("channels", n, "y", (0.0, 0.0), 2.0, cell, rules)


def titration(n: int) -> Network:
    """Hydrogen ions along a titration of acetic acid, one of three roots at each point."""
    base = 0.09 / n * np.arange(1, n + 1)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        h = here[0]
        return [(h + base) * h * (h + 1.8e-5) - 1e-14 * (h + 1.8e-5) - 0.1 * 1.8e-5 * h]

    rules = ["b0 = 0", f"b{{i}} = b{{h}} + {0.09 / n!r}", "h{i} + b{i} = 1e-14/h{i} + a{i}"]
    rules += ["a{i} = 0.1*1.8e-5/(h{i} + 1.8e-5)"]
    return chain("titration", n, "h", (0.0, 0.0), 1.8e-5 * (0.1 - base) / base, cell, rules)


def states(n: int) -> Network:
    """Volumes of a gas at rising pressures by the equation of van der Waals."""
    pressures = 1e5 + 40e5 / n * np.arange(1, n + 1)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        return [(pressures + 0.364 / here[0] ** 2) * (here[0] - 4.27e-5) - 8.314 * 320.0]

    rules = ["T = 320", "p0 = 1e5", f"p{{i}} = p{{h}} + {40e5 / n!r}"]
    rules += ["(p{i} + 0.364/V{i}^2)*(V{i} - 4.27e-5) = 8.314*T"]
    return chain("states", n, "V", (0.0, 0.0), [8.314 * 320.0 / pressures], cell, rules)


# --- cells that all depend on one another, with answers that are partly 0 ------------


def epidemic(n: int) -> Network:
    """An infection that stays in towns along a road, not the answer in which nobody is ill."""

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        s, i = here
        caught = 0.5 * s * (i + 0.1 * before[1] + 0.1 * after[1])
        return [0.02 * (1.0 - s) - caught, caught - 0.22 * i]

    rules = ["i0 = 0", f"i{n + 1} = 0", "0.02*(1 - s{i}) = c{i}", "c{i} = 0.22*i{i}"]
    rules += ["c{i} = 0.5*s{i}*(i{i} + 0.1*i{h} + 0.1*i{j})"]
    return chain("epidemic", n, "s i", (0.0, 0.0), [[0.4], [0.05]], cell, rules)


def populations(n: int) -> Network:
    """Species that compete with their neighbours: all of them live in one of 2^n answers."""
    growth = 1.0 + 0.1 * (np.arange(1, n + 1) % 3)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        return [here[0] * (growth - here[0] - 0.3 * before[0] - 0.2 * after[0])]

    rules = [
        "x0 = 0",
        f"x{n + 1} = 0",
        *(f"g{i} = {1.0 + 0.1 * (i % 3)!r}" for i in range(1, n + 1)),
    ]
    rules += ["x{i}*(g{i} - x{i} - 0.3*x{h} - 0.2*x{j}) = 0"]
    return chain("populations", n, "x", (0.0, 0.0), 0.7, cell, rules)


def fin(n: int) -> Network:
    """A fin that loses heat to the air and by radiation."""
    step = 0.3 / n

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        lost = 80.0 * (here[0] - 293.0) + 4e-7 * (here[0] ** 4 - 293.0**4)
        return [before[0] - 2.0 * here[0] + after[0] - step**2 * lost]

    rules = ["T0 = 600", f"T{n + 1} = 293", f"h = {step!r}"]
    rules += ["T{h} - 2*T{i} + T{j} = h^2*(80*(T{i} - 293) + 4e-7*(T{i}^4 - 293^4))"]
    return chain("fin", n, "T", (600.0, 293.0), 400.0, cell, rules)


def habitat(n: int) -> Network:
    """A species that spreads and grows between shores where it dies; it might live nowhere."""
    step = 10.0 / (n + 1)

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        return [before[0] - 2.0 * here[0] + after[0] + step**2 * here[0] * (1.0 - here[0])]

    rules = [
        "u0 = 0",
        f"u{n + 1} = 0",
        f"h = {step!r}",
        "u{h} - 2*u{i} + u{j} + h^2*u{i}*(1 - u{i}) = 0",
    ]
    start = [0.9 * np.sin(np.pi / (n + 1) * np.arange(1, n + 1))]
    return chain("habitat", n, "u", (0.0, 0.0), start, cell, rules)


def osmosis(n: int) -> Network:
    """Membranes in series: the flux of each depends on the flow and the salt that the one before
    has left."""
    area, lowers = 40.0 / n, 0.05 / n

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        (q0, c0, p0, _, _), (q, c, p, flux, salt) = before, here
        mean = (c0 + c) / 2.0
        driven = p0 - 0.75 * mean * np.exp(0.14 * n * flux / q0) + 0.75 * salt
        passed = salt * (flux + 0.01 * area) - 0.01 * area * mean
        lost = lowers * ((q0 + q) / 2.0) ** 1.7
        return [
            flux - 0.02 * area * driven,
            passed,
            q0 - q - flux,
            q0 * c0 - q * c - flux * salt,
            p0 - p - lost,
        ]

    rules = ["q0 = 10", "c0 = 35", "p0 = 60"]
    polarised = f"(c{{h}} + c{{i}})/2*exp({0.14 * n!r}*J{{i}}/q{{h}})"
    rules += [f"J{{i}} = 0.02*{area!r}*(p{{h}} - 0.75*{polarised} + 0.75*s{{i}})"]
    rules += [
        f"s{{i}}*(J{{i}} + 0.01*{area!r}) = 0.01*{area!r}*(c{{h}} + c{{i}})/2",
        "q{i} = q{h} - J{i}",
    ]
    rules += [
        "q{i}*c{i} = q{h}*c{h} - J{i}*s{i}",
        f"p{{i}} = p{{h}} - {lowers!r}*((q{{h}} + q{{i}})/2)^1.7",
    ]
    along = np.arange(1, n + 1) / n
    start = [
        10 - 6 * along,
        35 + 50 * along,
        60 - along,
        (12 - 10 * along) / n,
        0.5 + 15 * along**2,
    ]
    return chain("osmosis", n, "q c p J s", ((10.0, 35.0, 60.0, 0.0, 0.0), 0.0), start, cell, rules)


def feeder(n: int) -> Network:
    """Three phases along a feeder with mutual impedances, constant power drawn from each at each
    node."""
    own, mutual, p, q = (0.06 / n, 0.12 / n), (0.02 / n, 0.05 / n), 3e5 / n, 1e5 / n
    z = np.full((3, 3), complex(*mutual)) + np.eye(3) * (complex(*own) - complex(*mutual))
    source = 2400.0 * np.exp(-2j / 3 * np.pi * np.arange(3))

    def cell(before: Any, here: Any, after: Any) -> list[Any]:
        (va, vb), (ia, ib) = (here[:3], here[3:6]), (here[6:9], here[9:])
        drop_a = np.tensordot(z.real, ia, 1) - np.tensordot(z.imag, ib, 1)
        drop_b = np.tensordot(z.real, ib, 1) + np.tensordot(z.imag, ia, 1)
        size = va**2 + vb**2
        left_a, left_b = ia - after[6:9], ib - after[9:]
        drawn = [left_a - (p * va + q * vb) / size, left_b - (p * vb - q * va) / size]
        return [*(before[:3] - va - drop_a), *(before[3:6] - vb - drop_b), *drawn[0], *drawn[1]]

    rules = [f"Rs = {own[0]!r}", f"Xs = {own[1]!r}", f"Rm = {mutual[0]!r}", f"Xm = {mutual[1]!r}"]
    for k, phase in enumerate("abc"):
        rules += [
            f"v{phase}0 = {float(source[k].real)!r}",
            f"w{phase}0 = {float(source[k].imag)!r}",
        ]
        rules += [f"i{phase}{n + 1} = 0", f"j{phase}{n + 1} = 0"]
        of = {o: "s" if o == phase else "m" for o in "abc"}
        real = " + ".join(f"(R{of[o]}*i{o}{{i}} - X{of[o]}*j{o}{{i}})" for o in of)
        imag = " + ".join(f"(R{of[o]}*j{o}{{i}} + X{of[o]}*i{o}{{i}})" for o in of)
        rules += [
            f"v{phase}{{h}} - v{phase}{{i}} = {real}",
            f"w{phase}{{h}} - w{phase}{{i}} = {imag}",
        ]
        size = f"(v{phase}{{i}}^2 + w{phase}{{i}}^2)"
        rules.append(
            f"i{phase}{{i}} - i{phase}{{j}} = ({p!r}*v{phase}{{i}} + {q!r}*w{phase}{{i}})/{size}"
        )
        rules.append(
            f"j{phase}{{i}} - j{phase}{{j}} = ({p!r}*w{phase}{{i}} - {q!r}*v{phase}{{i}})/{size}"
        )
    low = [*source.real, *source.imag, *([0.0] * 6)]
    start = np.array(low)[:, None]
    return chain("feeder", n, "va vb vc wa wb wc ia ib ic ja jb jc", (low, 0.0), start, cell, rules)


KINDS = (
    (backwater, 40, 600), (implicit_euler, 50, 500, 2000), (runge_kutta, 200, 2000), (pendulum, 100, 1000),
    (gas_line, 50, 500), (exchangers, 20, 200, 600), (chemostats, 5, 50, 300), (compressors, 10, 100),
    (mosfets, 60, 600), (queues, 200, 2000), (choices, 30, 300), (channels, 60, 600), (titration, 50, 500),
    (epidemic, 5, 50, 500), (populations, 5, 50, 500), (feeder, 5, 50, 300),
    (excitable, 60, 600), (friction, 5, 60, 600), (cooling_tower, 5, 60, 300), (states, 60, 600),
    (fin, 30, 600), (habitat, 5, 30, 600), (osmosis, 20, 400),
)  # fmt: skip


def chains(small: bool, only: str) -> Iterator[Network]:
    for kind, *sizes in KINDS:
        if only in kind.__name__:
            yield from (kind(n) for n in (sizes[:1] if small else sizes))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="the smallest size of each kind")
    parser.add_argument("--only", default="", help="kinds with this in their name")
    options = parser.parse_args()
    warm_up()
    print(aligned(HEAD))
    for network in chains(options.small, options.only):
        print(aligned(line(network, peers=False)), flush=True)


if __name__ == "__main__":
    main()
