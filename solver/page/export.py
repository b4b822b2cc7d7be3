"""A sheet as one file that needs nothing else: its figures and values over a grid of inputs, with sliders.

Every state that the file shows was solved and checked; between the points of the grid it shows nothing.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping, Sequence
from hashlib import sha256
from math import isfinite, prod
from pathlib import Path
from typing import Any, NamedTuple

from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.inputs import override
from rulesheets.model import Model, Value, Variable
from rulesheets.units.quantity import displaying
from solver.page.figures import geometry, handles, needed, outline, rectangle
from solver.page.rail import turn
from solver.solving import solve
from solver.sweeps.sweep import sweep

STATIC = Path(__file__).parent / "static"

MOST = 3
"""Sliders of an exported page."""

STATES = 20_000
"""States of the grid at most: some megabytes."""

POINTS = 41
"""Points of a slider that nobody has given a range, if it is the only one."""

DIGITS = 8

SAID = "Solved beforehand by Backsolve; every state shown was checked against every rule."

Axes = Mapping[str, Sequence[Value]]


class Exported(NamedTuple):
    """The page, how many states it has, and how many of them have an answer."""

    page: str
    states: int
    solved: int


def export(
    model: Model,
    inputs: Mapping[str, Value | None],
    guesses: Mapping[str, float],
    axes: Axes,
    want: Sequence[str] | None = None,
) -> Exported:
    """The page of a sheet for every combination of the values of ``axes``.

    Without ``axes`` the inputs are taken that move its figures. Raises RuleSheetError (E445) for more
    sliders or states than a page holds.
    """
    axes = axes or first_axes(model, inputs, guesses)
    if len(axes) > MOST:
        raise RuleSheetError(error("E445", f"a page has {MOST} sliders at most, and {len(axes)} are given"))
    states = prod(map(len, axes.values()))
    if states > STATES:
        notes = ("take larger steps, or fewer sliders",)
        message = f"{states:,} states are more than the {STATES:,} that a page holds"
        raise RuleSheetError(error("E445", message, notes=notes))
    rows = _solved(model, inputs, guesses, axes, want)
    solved = sum(row is not None for row in rows)
    return Exported(_page(model.name, _document(model, inputs, axes, rows)), states, solved)


def first_axes(model: Model, inputs: Mapping[str, Value | None], guesses: Mapping[str, float]) -> Axes:
    """The inputs that drive the figures, else the first numbers; ranges about their values."""
    result = solve(model, inputs, guesses=guesses)
    numbers = [name for name, value in result.inputs.items() if isinstance(value, float)]
    drivers = list(dict.fromkeys(handle.driver for handle in handles(result)))
    chosen = (drivers or numbers)[: MOST - 1]
    points = POINTS if len(chosen) < 2 else POINTS // 2
    return {name: _range(model, name, float(result.inputs[name]), points) for name in chosen}


def _range(model: Model, name: str, value: float, points: int) -> list[Value]:
    whole, variable = turn(model, name), model.variables[name]
    if whole:
        return [value + whole * k / 72 for k in range(-36, 37)]
    low, high = (value / 2, value * 1.5) if value else (-1.0, 1.0)
    low, high = max(min(low, high), variable.low), min(max(low, high), variable.high)
    return [low + (high - low) * k / (points - 1) for k in range(points)]


def _solved(
    model: Model,
    inputs: Mapping[str, Value | None],
    guesses: Mapping[str, float],
    axes: Axes,
    want: Sequence[str] | None,
) -> list[dict[str, Value] | None]:
    """The values of every state, None where there is no answer; the last axis runs fastest."""
    given = {name: value for name, value in inputs.items() if name not in axes}
    known = override(model, given, guesses).values
    wanted = dict.fromkeys((*(want or [v.name for v in _shown(model)]), *needed(model)))
    names = [n for n in wanted if n not in known and n not in axes]
    table = sweep(model, axes, names, grid=True, given=given, guesses=guesses)
    columns = {name: table[name].tolist() for name in (*axes, *names)}
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return [{**known, **row} if solved else None for row, solved in zip(rows, table.solved, strict=True)]


def _shown(model: Model) -> list[Variable]:
    return [v for v in model.variables.values() if v.posted and not v.passed]


def _document(
    model: Model,
    inputs: Mapping[str, Value | None],
    axes: Axes,
    rows: Sequence[Mapping[str, Value] | None],
) -> dict[str, Any]:
    """What the browser draws: the variables in the units shown, and every figure, state by state."""
    effective = {n: inputs.get(n, v.value) for n, v in model.variables.items()}
    shown = _shown(model)
    drawn = [None if row is None else geometry(model, row) for row in rows]
    outlines = list(map(outline, model.figures))
    return {
        "name": model.name,
        "axes": [
            {
                "name": name,
                "values": [_number(value, displaying(model.variables[name])) for value in values],
                "at": _place(model, name, values),
            }
            for name, values in axes.items()
        ],
        "variables": [
            {
                "name": v.name,
                "unit": v.display_unit or v.unit or "",
                "comment": v.comment,
                "scale": displaying(v),
            }
            for v in shown
        ],
        "given": [v.name for v in shown if v.name in axes or effective[v.name] is not None],
        "figures": outlines,
        "boxes": [_box(number, figure, drawn) for number, figure in enumerate(outlines)],
        "said": SAID,
        "values": [
            None if row is None else [_number(row.get(v.name), displaying(v)) for v in shown] for row in rows
        ],
        "drawn": [None if some is None else list(map(_flat, some)) for some in drawn],
    }


def _place(model: Model, name: str, values: Sequence[Value]) -> int:
    """The place of the sheet's own value on an axis, else the middle."""
    own = model.variables[name].value
    if own is not None and own in values:
        return list(values).index(own)
    if isinstance(own, float) and all(isinstance(value, float) for value in values):
        return min(range(len(values)), key=lambda k: abs(float(values[k]) - own))
    return len(values) // 2


def _box(number: int, figure: dict[str, Any], drawn: Sequence[list[Any] | None]) -> list[float] | None:
    places = [place for some in drawn if some and some[number] for place in some[number]["places"]]
    return [_round(value) for value in rectangle(places, figure["polar"])] if places else None


def _flat(one: dict[str, Any] | None) -> list[float] | None:
    """Coordinates and angles one after the other."""
    if one is None:
        return None
    return [_round(value) for value in (*(c for place in one["places"] for c in place), *one["angles"])]


def _number(value: Value | None, scale: tuple[float, float]) -> Value | None:
    if value is None or isinstance(value, str):
        return value
    return _round(value * scale[0] + scale[1]) if isfinite(value) else None


def _round(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _page(name: str, data: dict[str, Any]) -> str:
    """The file. Its policy allows its own script alone, so that no word of a sheet can run."""
    script = (STATIC / "export.js").read_text(encoding="utf-8").strip()
    style = (STATIC / "export.css").read_text(encoding="utf-8").strip()
    written = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    written = written.replace("<", "\\u003c")
    seal = base64.b64encode(sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; script-src 'sha256-{seal}'; style-src 'unsafe-inline'"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(name)}</title>\n<style>{style}</style>\n</head>\n<body>\n"
        f'<script type="application/json" id="data">{written}</script>\n<script>{script}</script>\n'
        "</body>\n</html>\n"
    )
