"""Answers the requests of a page about one sheet, in values that JSON can represent.

For the server it runs as a separate process: one JSON object a line in, one a line out. The process
ends when the server does: its input is then closed, and a thread waits for that whatever is being
solved.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from math import isfinite
from queue import SimpleQueue
from typing import Any

import numpy as np

from rulesheets.deadline import TimeIsUp, time_limit
from rulesheets.diagnosis import RuleSheetError
from rulesheets.inputs import parse_input
from rulesheets.loading import loads
from rulesheets.model import Model, Row, Value
from rulesheets.units import converted, value_and_unit
from rulesheets.units.check import check_units
from solver.facts import Status
from solver.lane import Json
from solver.page import geometry, handles, nearest, needed, rail, turn
from solver.page.description import answered, complaint, derived, described, typeset
from solver.report.derivation import why, why_text
from solver.report.sheet import finite
from solver.solution.solving import Result, solve
from solver.sweeps import Plan, prepare
from solver.sweeps.sweep import shown_columns, sweep

Answers = tuple[Status, list[Row]]

ROWS = 2000
"""Rows of a sweep that a page draws at most."""

PLANS = 8
"""Prepared plans that are kept."""

KEPT = 20_000
"""Answers of a plan that are kept: without a record, each is a solve."""

MEMORY = 4 * 2**30
"""Bytes of address space that a sheet may use."""

QUICK = "check", "value", "frame", "warm"
SLOW = "solve", "typeset", "motion", "rail", "swap", "sweep", "sensitivity", "why"
"""Requests of a page during typing or dragging, and those that may take longer."""


class Bench:
    """One sheet at a time: ``load`` it, or ask a question that brings a ``sheet``.

    Values are in the units of the rules. ``python``: Python files that a sheet names may run.
    """

    def __init__(self, python: bool = False) -> None:
        self.python = python
        self.model: Model | None = None
        self.sheet: Json | None = None
        self.plans: dict[str, tuple[Plan, Callable[[tuple[float]], Answers]]] = {}
        self.last: tuple[str, Result] | None = None

    def answer(self, question: Json) -> Json:
        """The reply to one message; mistakes in the sheet or its inputs are diagnoses."""
        try:
            if question["do"] not in ("load", *QUICK, *SLOW):
                raise LookupError("no such question")
            if question.get("sheet") not in (None, self.sheet):
                self.load(question["sheet"])
            reply: Json = getattr(self, question["do"])(question)
            return reply
        except RuleSheetError as wrong:
            return {"wrong": [complaint(diagnosis) for diagnosis in wrong.diagnoses]}
        except MemoryError:
            return {"failed": "this sheet needs more memory than a page may take"}
        except RecursionError:
            return {"failed": "this sheet is nested too deeply"}
        except (ValueError, TypeError, LookupError) as wrong:
            return {"failed": str(wrong)}

    # --- the sheet ---

    def load(self, question: Json) -> Json:
        described = self.take(self._read(question))
        self.sheet = {key: question.get(key) for key in ("text", "name", "base", "within")}
        return described

    def take(self, model: Model) -> Json:
        """Use this model from now on."""
        self.model, self.last = model, None
        self.plans.clear()
        return described(model)

    def check(self, question: Json) -> Json:
        """Check whether a text is a sheet, without other effects."""
        model = self._read(question)
        warnings = [complaint(one) for one in (*model.notes, *check_units(model))]
        return {"rules": len(model.equations), "warnings": warnings}

    def typeset(self, question: Json) -> Json:
        return {"rules": typeset(self._model())}

    def value(self, question: Json) -> Json:
        """The value of a text, in the unit of the rules: ``pi/6``, ``3 kW``, ``'open``."""
        text, variable = str(question["text"]), self._model().variables[str(question["name"])]
        value, _ = parse_input(text, variable=variable)
        if variable.display_unit and value_and_unit(text) is None and not isinstance(value, str):
            (value,) = converted([value], variable.display_unit, variable)
        return {"value": value}

    def _read(self, question: Json) -> Model:
        text, name, base = question["text"], question["name"], question["base"]
        return loads(text, name, base, within=question.get("within"), allow_python=self.python)

    def _model(self) -> Model:
        if self.model is None:
            raise LookupError("there is no sheet")
        return self.model

    # --- answers ---

    def _result(self, question: Json) -> Result:
        """The result for the inputs of a question; the last one is kept."""
        key = json.dumps([question.get("inputs"), question.get("guesses")], sort_keys=True)
        if self.last is None or self.last[0] != key:
            known = self._model().variables
            inputs = {n: v for n, v in _values(question, "inputs").items() if n in known}
            guesses = {n: v for n, v in _guesses(question).items() if n in known}
            limit = question.get("timeout")
            self.last = key, solve(self._model(), inputs, guesses=guesses, timeout=limit)
        return self.last[1]

    def solve(self, question: Json) -> Json:
        return answered(self._result(question))

    def why(self, question: Json) -> Json:
        derivation = why(self._result(question), str(question["name"]))
        return {**derived(derivation), "text": why_text(derivation)}

    def sensitivity(self, question: Json) -> Json:
        result = self._result(question)
        if not result.solutions:
            return {"outputs": [], "inputs": [], "slopes": []}
        table = result.sensitivity(answer=_answer(question, result))
        slopes = []
        for output in table.outputs:
            slopes.append([_number(table[output, given]) for given in table.inputs])
        return {"outputs": list(table.outputs), "inputs": list(table.inputs), "slopes": slopes}

    def swap(self, question: Json) -> Json:
        """The inputs to clear if an output becomes an input, the most likely ones first."""
        result, name = self._result(question), str(question["name"])
        if not result.solutions or name in result.undetermined:
            return {"choices": []}
        number = _answer(question, result)
        table = result.sensitivity([name], answer=number)
        drivers = {handle.driver for handle in handles(result, number)}
        slopes = ((given, table[name, given]) for given in table.inputs)
        share = {given: abs(by * float(result.inputs[given])) for given, by in slopes if by}
        return {"choices": sorted(share, key=lambda n: (n not in drivers, -share[n]))}

    def sweep(self, question: Json) -> Json:
        """Columns over a range of one input, all in display units; null if there is no answer."""
        name, model = str(question["name"]), self._model()
        start, stop, step = (float(question[key]) for key in ("start", "stop", "step"))
        at = np.arange(start, stop + 1e-9 * step, step) if step else np.empty(0)
        if not 0 < len(at) <= ROWS:
            raise ValueError(f"a page draws 1 to {ROWS} rows, and these are {len(at)}")
        given = {n: v for n, v in _values(question, "inputs").items() if n != name}
        posted = {n: given.get(n, v.value) for n, v in model.variables.items() if v.posted}
        wanted = [n for n, value in posted.items() if n != name and value is None]
        variable = model.variables[name]
        shown = variable.display_unit
        rows = converted(at.tolist(), shown, variable) if shown else at
        table = sweep(model, {name: rows}, want=wanted, given=given, guesses=_guesses(question))
        found = shown_columns(table, model)
        columns = {}
        for n, column in found.items():
            columns[n] = [None if isinstance(v, str) else _number(v) for v in column.tolist()]
        columns[name], solved = at.tolist(), int(table.solved.sum())
        return {"name": name, "columns": columns, "solved": solved, "rows": len(at)}

    # --- dragging ---

    def motion(self, question: Json) -> Json:
        result = self._result(question)
        return {"handles": [one._asdict() for one in handles(result, _answer(question, result))]}

    def rail(self, question: Json) -> Json:
        """The curve of the points of one driver, and the extents of the figures."""
        result, model = self._result(question), self._model()
        number = _answer(question, result)
        group = [one for one in handles(result, number) if one.driver == question["driver"]]
        with suppress(TimeIsUp), time_limit(question.get("timeout")):
            return rail(model, result.inputs, result.solutions[number], group) if group else {}
        return {}

    def frame(self, question: Json) -> Json:
        """All values and figures for a value of the dragged variable, on the branch of ``near``."""
        name, value = str(question["name"]), float(question["value"])
        plan, outcome = self._dragged(question, name)
        status, answers = outcome((value,))
        if status is not Status.SOLVED:
            return {"status": str(status), "value": value}
        values = nearest(plan, value, answers, question.get("near") or {})
        drawn = geometry(plan.model, values)
        return {"status": "solved", "value": value, "values": finite(values), "figures": drawn}

    def warm(self, question: Json) -> Json:
        """Prepare frames at such values, so that the first of them is fast."""
        name = str(question["name"])
        (_, outcome), whole = self._dragged(question, name), turn(self._model(), name)
        for value in (*question["values"], *(whole * k / 4 for k in range(-2, 3))):
            outcome((float(value),))
        return {}

    def _dragged(self, question: Json, name: str) -> tuple[Plan, Callable[[tuple[float]], Answers]]:
        """The plan with the dragged variable as its input, and its answer at a value."""
        model = self._model()
        given = {n: v for n, v in _values(question, "inputs").items() if n != name}
        key = json.dumps([name, given], sort_keys=True)
        if key not in self.plans:
            inputs = {n: given.get(n, v.value) for n, v in model.variables.items()}
            posted = [n for n, v in model.variables.items() if v.posted]
            names = dict.fromkeys((*(posted or model.variables), *needed(model)))
            want = [n for n in names if n != name and inputs[n] is None]
            plan = prepare(model, [name], want=want, given=given)
            self.plans = dict([*self.plans.items()][1 - PLANS :])
            self.plans[key] = plan, lru_cache(KEPT)(plan.outcome)
        return self.plans[key]


def _values(question: Json, key: str) -> dict[str, Value | None]:
    given: Mapping[str, Any] = question.get(key) or {}
    return {n: float(v) if isinstance(v, int | float) else v for n, v in given.items()}


def _guesses(question: Json) -> dict[str, float]:
    return {n: float(v) for n, v in (question.get("guesses") or {}).items() if v is not None}


def _answer(question: Json, result: Result) -> int:
    return min(max(int(question.get("answer") or 0), 0), len(result.solutions) - 1)


def _number(value: float | None) -> float | None:
    return value if value is not None and isfinite(value) else None


def main() -> None:
    """Answer until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the server, with which this ends
    replies, sys.stdout = sys.stdout, sys.stderr
    with suppress(ImportError):  # no such limit on this system
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    waiting: SimpleQueue[str] = SimpleQueue()

    def listen() -> None:
        for line in sys.stdin:
            waiting.put(line)
        os._exit(0)

    threading.Thread(target=listen, daemon=True).start()
    bench = Bench()
    reply: Json = {"ready": True}
    while True:
        replies.write(json.dumps(reply, allow_nan=False, separators=(",", ":")) + "\n")
        replies.flush()
        reply = bench.answer(json.loads(waiting.get()))


if __name__ == "__main__":
    main()
