"""A model, its answers and their derivations for the page; and a sheet as one file with sliders.

Every state that the file shows was solved and checked; between grid points it has none.
"""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import chain, compress
from math import isfinite, prod
from pathlib import Path
from typing import Any, TypeAlias

from rulesheets.diagnosis import Diagnosis, refusal, render
from rulesheets.inputs import override
from rulesheets.model import Equation, Model, Premise, Value, Values, Variable
from rulesheets.syntax.nodes import conjunction
from rulesheets.units import displaying
from solver.facts import Status
from solver.page import boxes, geometry, handles, needed, outline, turn
from solver.path import activity, equations_of
from solver.path.cases import outcomes
from solver.report.derivation import Derivation, Page
from solver.report.path import Places, Plain, Tex, rule_text, steps_to_show
from solver.report.sheet import diagnosis_json, finite, with_warnings
from solver.solution.solving import Result, solve
from solver.sweeps.sweep import sweep

Guard: TypeAlias = tuple[Premise, ...]
_SCOPE = re.compile(r"\\text\{[^{}]*\.\}")
"""The name of a call in front of a local, which the rule itself does not write."""

NO_CODE = (
    "a page runs no code of a sheet; if you trust the file, solve the sheet with --allow-python "
    "in the terminal, or load it with allow_python=True and show it in a notebook"
)


def described(model: Model) -> dict[str, Any]:
    """Variables in the order of the sheet, rules in the order of the text, and figures."""
    places = Places(model)
    return {
        "name": model.name,
        "variables": list(map(_variable, model.variables.values())),
        "rules": [
            {
                "text": rule_text(group[0].rule),
                "place": places.of(group[0]),
                "scope": group[0].scope,
                "names": sorted({name for equation in group for name in equation.names}),
            }
            for group in places.groups.values()
        ],
        "figures": list(map(outline, model.figures)),
    }


def _variable(variable: Variable) -> dict[str, Any]:
    sizes = ((name, getattr(variable, name)) for name in ("low", "high"))
    limits = {name: size if isfinite(size) else None for name, size in sizes}
    names = ("name", "value", "guess", "comment", "posted")
    own = {name: getattr(variable, name) for name in names}
    return {**own, **limits, "unit": variable.shown_unit, "scale": list(displaying(variable))}


def typeset(model: Model) -> list[list[str]]:
    """Every rule as LaTeX, a line for the equations of each of its cases: ``if``, ``else if`` and
    ``otherwise``, the first that applies counts."""
    return [list(_cases(model, group)) for group in Places(model).groups.values()]


def _cases(model: Model, group: Sequence[Equation]) -> Iterator[str]:
    notation, cases = Tex(), dict[Guard, list[str]]()
    for equation in group:
        body = f"{notation.written(equation.left)} = {notation.written(equation.right)}"
        cases.setdefault(equation.guard, []).append(body)
    earlier = list[Guard]()
    for guard, bodies in cases.items():
        kept = [
            one.holds or not _covered(earlier, (*guard[:at], one._replace(holds=True)))
            for at, one in enumerate(guard)
        ]
        own = list(compress(guard, kept))
        word = "if" if all(kept) else "else if" if own else "otherwise"
        said = notation.written(conjunction(model.outcomes(own))) if own else ""
        case = rf" \quad \text{{{word} }} {said}" if guard else ""
        earlier.append(guard)
        yield _SCOPE.sub("", r", \quad ".join(bodies) + case)


def _covered(guards: Sequence[Guard], start: Guard) -> bool:
    """Whether one of the guards applies wherever the premises of ``start`` hold."""
    further = {one[len(start)] for one in guards if one[: len(start)] == start != one}
    return start in guards or any(
        all(_covered(guards, (*start, one._replace(holds=holds))) for holds in (True, False))
        for one in further
    )


def complaint(diagnosis: Diagnosis) -> dict[str, Any]:
    """A diagnosis with its places, and as printed in the terminal."""
    places, names = [], ("file", "start", "end", "line")
    for label in diagnosis.labels:
        places.append({name: getattr(label.span, name) for name in names})
    told = {**diagnosis_json(diagnosis), "places": places, "printed": render(diagnosis)}
    return told | ({"notes": [NO_CODE]} if diagnosis.code == "E313" else {})


def answered(result: Result) -> dict[str, Any]:
    """Status, every answer with its figures, messages, and the state of every rule."""
    shown = [finite(answer) for answer in result.solutions]
    return {
        "status": str(result.status),
        "complete": result.complete,
        "inputs": dict(result.inputs),
        "guesses": dict(result.guesses),
        "undetermined": list(result.undetermined),
        "solutions": shown,
        "partial": finite(result.partial),
        "figures": [geometry(result.model, answer) for answer in result.solutions],
        "diagnoses": [complaint(diagnosis) for diagnosis in with_warnings(result).diagnoses],
        "rules": _rules(result),
    }


def _rules(result: Result) -> list[dict[str, Any]]:
    """The state of each rule and the number of the step of the path that uses it (0: none)."""
    known = result.solutions[0] if result.solutions else result.partial
    decided = outcomes(result.model, known, result.inputs)
    place: dict[int, int] = {}
    for number, step in enumerate(steps_to_show(result.path), 1):
        for index in equations_of(step):
            if activity(result.model.equations[index], decided):
                place.setdefault(index, number)
    blamed = {(label.span.file, label.span.start) for d in result.diagnoses for label in d.labels}
    rows = []
    for group in Places(result.model).groups.values():
        steps = [place[equation.index] for equation in group if equation.index in place]
        named = {name for equation in group for name in equation.names}
        missing = sorted(name for name in named if name not in known)
        state, unsolved = "used" if steps else "idle", result.status is not Status.SOLVED
        if unsolved and (group[0].rule.file, group[0].rule.start) in blamed:
            state = "broken"
        elif unsolved and missing:
            state = "waiting"
        waits = missing if state == "waiting" else []
        rows.append({"state": state, "step": min(steps, default=0), "waits": waits})
    return rows


def derived(derivation: Derivation) -> dict[str, Any]:
    """The inputs that a number depends on, then each step: formula, rule and conditions."""
    page = Page(derivation, Tex())
    given = [page.known(name) for name in (*derivation.inputs, *derivation.assumed)]
    lines = []
    for link in derivation.links:
        for line in link.lines:
            tex, unit = " = ".join(page.chain(line)), page.unit(line.unknown)
            shown: dict[str, Any] = {"tex": tex, "unit": unit, "within": bool(link.tears)}
            if line.equation is not None:
                shown["place"], shown["rule"] = page.places.rule(line.equation)
                guards = page.guards(line, Plain())
                shown["because"] = [f"{word} {said}" for word, said, _ in guards]
            lines.append(shown)
    return {"head": page.head(), "given": given, "lines": lines}


STATIC = Path(__file__).parent / "static"

MOST = 3
"""Sliders of an exported page."""

STATES = 20_000
"""States of the grid at most: some megabytes."""

POINTS = 41
"""Points of a slider without a given range, if it is the only one."""

DIGITS = 8

SAID = "Solved beforehand by Backsolve; every state shown was checked against every rule."

Axes = Mapping[str, Sequence[Value]]


def export(
    model: Model,
    inputs: Mapping[str, Value | None],
    guesses: Mapping[str, float],
    axes: Axes,
    want: Sequence[str] | None = None,
) -> tuple[str, int, int]:
    """The page of a sheet for every combination of the values of ``axes``, the number of its
    states, and of those with an answer.

    Without ``axes`` the inputs that move its figures are used. Raises RuleSheetError (E445) for
    more sliders or states than a page can hold.
    """
    axes = axes or first_axes(model, inputs, guesses)
    if len(axes) > MOST:
        raise refusal("E445", f"a page has {MOST} sliders at most, and {len(axes)} are given")
    states = prod(map(len, axes.values()))
    if states > STATES:
        notes = ("take larger steps, or fewer sliders",)
        message = f"{states:,} states are more than the {STATES:,} that a page holds"
        raise refusal("E445", message, None, *notes)
    given = {name: value for name, value in inputs.items() if name not in axes}
    known = override(model, given, guesses).values
    wanted = dict.fromkeys((*(want or [v.name for v in _shown(model)]), *needed(model)))
    names = [n for n in wanted if n not in known and n not in axes]
    table = sweep(model, axes, names, grid=True, given=given, guesses=guesses)
    columns = {name: table[name].tolist() for name in (*axes, *names)}  # the last axis runs fastest
    rows = list[dict[str, Value] | None]()
    for *row, solved in zip(*columns.values(), table.solved, strict=True):
        rows.append({**known, **dict(zip(columns, row, strict=True))} if solved else None)
    document = _document(model, inputs, axes, rows)
    return _page(model.name, document), states, int(table.solved.sum())


def first_axes(
    model: Model, inputs: Mapping[str, Value | None], guesses: Mapping[str, float]
) -> Axes:
    """The inputs that drive the figures, else the first numbers; ranges that hold their values."""
    result = solve(model, inputs, guesses=guesses)
    numbers = [name for name, value in result.inputs.items() if isinstance(value, float)]
    drivers = list(dict.fromkeys(handle.driver for handle in handles(result)))
    chosen = (drivers or numbers)[: MOST - 1]
    points = POINTS if len(chosen) < 2 else POINTS // 2
    return {name: _range(model, name, float(result.inputs[name]), points) for name in chosen}


def _range(model: Model, name: str, value: float, points: int) -> list[float]:
    whole, variable = turn(model, name), model.variables[name]
    if whole:
        return [value + whole * k / 72 for k in range(-36, 37)]
    low, high = (value / 2, value * 1.5) if value else (-1.0, 1.0)
    low, high = max(min(low, high), variable.low), min(max(low, high), variable.high)
    found = [low + (high - low) * k / (points - 1) for k in range(points)]
    found[min(range(points), key=lambda k: abs(found[k] - value))] = value
    return found


def _shown(model: Model) -> list[Variable]:
    return [v for v in model.variables.values() if v.posted and not v.passed]


def _document(
    model: Model, inputs: Mapping[str, Value | None], axes: Axes, rows: Sequence[Values | None]
) -> dict[str, Any]:
    """The data for the browser: variables in display units, and figures, state by state."""
    effective = {n: inputs.get(n, v.value) for n, v in model.variables.items()}
    shown = _shown(model)
    drawn = [None if row is None else geometry(model, row) for row in rows]
    outlines = list(map(outline, model.figures))

    def flat(one: dict[str, Any] | None) -> list[float] | None:
        """Coordinates and angles one after the other."""
        return None if one is None else list(map(_round, chain(*one["places"], one["angles"])))

    names = ("name", "comment", "unit", "scale")
    scales = {name: displaying(variable) for name, variable in model.variables.items()}
    axis = {name: [_number(value, scales[name]) for value in axes[name]] for name in axes}
    told = [(v.name, scales[v.name]) for v in shown]
    return {
        "name": model.name,
        "axes": [
            {"name": name, "values": axis[name], "at": _place(model, name, some)}
            for name, some in axes.items()
        ],
        "variables": [{name: _variable(v)[name] for name in names} for v in shown],
        "given": [v.name for v in shown if v.name in axes or effective[v.name] is not None],
        "figures": outlines,
        "boxes": [box and list(map(_round, box)) for box in boxes(outlines, drawn)],
        "said": SAID,
        "values": [row and [_number(row.get(n), scale) for n, scale in told] for row in rows],
        "drawn": [None if some is None else list(map(flat, some)) for some in drawn],
    }


def _place(model: Model, name: str, values: Sequence[Value]) -> int:
    """The place of the sheet's own value on an axis, else the middle."""
    own = model.variables[name].value
    if isinstance(own, float) and all(isinstance(value, float) for value in values):
        return min(range(len(values)), key=lambda k: abs(float(values[k]) - own))
    return len(values) // 2 if own is None or own not in values else list(values).index(own)


def _number(value: Value | None, scale: tuple[float, float]) -> Value | None:
    if value is None or isinstance(value, str):
        return value
    return _round(value * scale[0] + scale[1]) if isfinite(value) else None


def _round(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _page(name: str, data: dict[str, Any]) -> str:
    """The file. Its policy allows only its own script, so that no text of a sheet can run."""
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
