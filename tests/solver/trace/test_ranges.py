"""What ranges tell of spans of rows is so in each row, and long sweeps say what single solves
say."""

from __future__ import annotations

import random
from functools import cache

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets.functions import TABLE
from solver.files.tables import WORDS
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow
from solver.trace.graph import LOGICAL, NotCompilable
from solver.trace.llvm import NativeKernel, available
from solver.trace.ranges import Ranges
from solver.trace.rows import Steady

ONE = ("neg", "abs", "sqrt", "rint", "sin", "cosd", "sind", "expm1", "log1p")
TWO = ("add", "sub", "mul", "div", "max", "pow", "directiond", "direction")
CALLED = (
    "exp",
    "ln",
    "atan",
    "atand",
    "asin",
    "acosd",
    "atan2",
    "atan2d",
    "cosh",
    "tand",
    "mod",
    "gamma",
)
COMPARED, JOINED = ("lt", "le", "eq"), ("and", "or", "xor")
SPANS, EACH = 40, 60


def random_graph(rng: random.Random) -> tuple[Flow, list[int]]:
    """Numbers and conditions of two inputs."""
    flow = Flow()
    numbers = [flow.input(0), flow.input(1), *map(flow.constant, (0.0, 2.0, -3.0, 1e-3))]
    conditions: list[int] = []
    for _ in range(rng.randrange(4, 30)):
        kind = rng.choice(
            (*ONE, *TWO, *TWO, "call", *COMPARED, *COMPARED, *JOINED, "not", "where", "choose")
        )
        try:
            if kind in ONE:
                numbers.append(flow.node(kind, rng.choice(numbers)))
            elif kind in TWO:
                numbers.append(flow.node(kind, rng.choice(numbers), rng.choice(numbers)))
            elif kind == "call":
                name = rng.choice(CALLED)
                numbers.append(
                    flow.node("call", name, *rng.choices(numbers, k=TABLE[name].arity[0]))
                )
            elif kind in COMPARED:
                conditions.append(flow.node(kind, rng.choice(numbers), rng.choice(numbers)))
            elif kind in JOINED and conditions:
                conditions.append(flow.node(kind, rng.choice(conditions), rng.choice(conditions)))
            elif kind == "not" and conditions:
                conditions.append(flow.node("not", rng.choice(conditions)))
            elif kind == "where" and conditions:
                numbers.append(flow.node("where", rng.choice(conditions), *rng.sample(numbers, 2)))
            elif kind == "choose" and conditions:
                three = rng.choices(conditions, k=3)
                conditions.append(flow.node("where", *three))
        except NotCompilable:
            continue
    return flow, [
        *numbers[2:],
        *conditions,
        *(flow.node("finite", n) for n in rng.choices(numbers, k=3)),
    ]


def columns_of(rng: np.random.Generator, reach: float) -> list[np.ndarray]:
    """Two inputs (spans, rows), the first and the last of a span among its rows."""
    found = []
    for _ in range(2):
        middle = rng.choice((1.0, 1e-3, 50.0), SPANS) * rng.normal(size=SPANS) + rng.choice(
            (0.0, 30.0), SPANS
        )
        width = 10.0 ** rng.uniform(-9.0, reach, SPANS) * rng.integers(0, 2, SPANS)
        found.append(middle[:, None] + width[:, None] * rng.uniform(-1.0, 1.0, (SPANS, EACH)))
    return found


@pytest.mark.parametrize("native", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_ranges_enclose_every_row(seed: int, native: bool) -> None:
    rng = random.Random(seed)
    told = 0
    for _ in range(5):
        flow, wanted = random_graph(rng)
        columns = columns_of(
            np.random.default_rng(rng.getrandbits(32)), rng.choice((-3.0, 0.0, 2.0))
        )
        if native and not available():
            pytest.skip("needs the extra jit")
        try:
            kernel = (NativeKernel if native else ArrayKernel)(flow, wanted)
        except NotCompilable:
            continue
        logical = [is_condition(flow, node) for node in wanted]
        results = [np.empty(SPANS * EACH, dtype=bool if yes else float) for yes in logical]
        kernel([column.ravel() for column in columns], results)
        pairs = Ranges(flow, wanted)(
            [(column.min(axis=1), column.max(axis=1)) for column in columns]
        )
        for node, values, pair, yes in zip(wanted, results, pairs, logical, strict=True):
            rows = values.reshape(SPANS, EACH)
            low, high = (np.broadcast_to(end, SPANS) for end in pair)
            if yes:
                told += int(low.sum() + high.sum())
                assert rows[low].all() and not rows[high].any(), flow.nodes[node]
            else:
                known = ~np.isnan(low)
                assert (np.isnan(high) == ~known).all()
                inside = (low[:, None] <= rows) & (rows <= high[:, None])
                assert inside[known].all(), flow.nodes[node]
    assert told


def is_condition(flow: Flow, node: int) -> bool:
    kind, *rest = flow.nodes[node]
    if kind == "const":
        return isinstance(rest[0], bool)
    return kind in LOGICAL or (kind == "where" and is_condition(flow, int(rest[1])))


# --- long sweeps ---

CIRCLE = "variables\n  s\n  x\n  y\n  r\nrules\n  x^2 + y^2 = 25\n  y = s*x + 1\n  r = x*y + s\n"
POSITIVE = "variables\n  s\n  x in [0, 10]\n  y\nrules\n  x^2 - 3*x = s\n  y = 2*x + s\n"
"""Two answers below 0 and one above."""
CORNER = (
    "variables\n  s\n  x\n  y\nrules\n  x^2 - 2*x = s\n  if x > 1.5 then y = 2*x else y = 3*x^2 - "
    "x\n"
)
SCALED = "variables\n  s\n  k\n  x\n  y\nrules\n  k*x^2 - 3*x = s\n  y = x*k - 1/x\n"


SWEEPS = {
    "the whole stroke": ("offset_slider_crank", [np.linspace(4.575, 10.82, 30_000)]),
    "to the end of the stroke": ("offset_slider_crank", [np.linspace(10.7, 10.8167, 9_000)]),
    "there and back": (
        "offset_slider_crank",
        [np.r_[np.linspace(6, 9, 9_000), np.linspace(9, 6, 9_000)]],
    ),
    "circle": (CIRCLE, [np.linspace(-2.0, 3.0, 20_000)]),
    "one of two ends": (POSITIVE, [np.linspace(-2.3, 2.0, 20_000)]),
    "a branch bends": (CORNER, [np.linspace(-0.99, 1.0, 20_000)]),
    "two inputs": (SCALED, [np.linspace(-0.5, 2.0, 20_000), np.linspace(2.0, 1.0, 20_000)]),
}


@cache
def asked(name: str) -> tuple[rulesheets.Model, list[str], list[str], dict[str, None]]:
    source, columns = SWEEPS[name]
    if source.startswith("variables"):
        return rulesheets.loads(source), ["s", "k"][: len(columns)], ["x", "y"], {}
    return rulesheets.load(source), ["xB"], ["thetaAO", "vB", "aB"], {"thetaAO": None}


@cache
def solved(name: str, row: int) -> solver.Result:
    model, inputs, want, given = asked(name)
    numbers = (float(column[row]) for column in SWEEPS[name][1])
    return solver.solve(model, given | dict(zip(inputs, numbers, strict=True)), want)


@pytest.mark.parametrize("jit", [False, True])
@pytest.mark.parametrize("name", SWEEPS)
def test_long_sweeps_count_and_show_what_solves_find(
    name: str, jit: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond the end of a stroke and at its dead centre, where answers end and where they bend."""
    if jit:
        pytest.importorskip("llvmlite")
    monkeypatch.setattr("solver.sweeps.PIECE", 2**12)
    monkeypatch.setattr("solver.trace.rows.SPAN", 64)
    by_ranges = list[int]()
    filled = Steady.__call__
    monkeypatch.setattr(
        Steady, "__call__", lambda *a: by_ranges.append(filled(*a)) or by_ranges[-1]
    )
    plan, columns = solver.prepare(*asked(name)), SWEEPS[name][1]
    plan(*(float(column[700]) for column in columns))
    table = plan.sweep(*columns, jit=jit)
    if "end of the stroke" not in name:
        assert any(by_ranges)
    changes = np.flatnonzero(np.diff(table.answers))
    near = [row + k for row in changes[:4] for k in (-1, 0, 1, 2)]
    count, rng = len(columns[0]), np.random.default_rng(8)
    rows = {0, 1, count - 1, *near, *rng.integers(0, count, 6), *range(513, count, 4096)}
    for row in sorted(int(row) for row in rows if row < count):
        alone = solved(name, row)
        assert WORDS[table.status[row]] == str(alone.status)
        assert table.answers[row] == len(alone.solutions)
        shown = [float(table[n][row]) for n in plan.want]
        found = [[one[n] for n in plan.want] for one in alone.solutions]
        assert not found or any(shown == pytest.approx(one, rel=1e-6, abs=1e-6) for one in found)
