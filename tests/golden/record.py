"""What a question is answered, as it is kept: status, answers with their error bars, completeness,
codes."""

from __future__ import annotations

import json
import math
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import solver
from rulesheets import RuleSheetError

from .questions import Question

HERE = Path(__file__).parent
ANSWERS = 6
"""So many answers of a list are kept; its length is kept in any case."""

Entry = dict[str, Any]


class Late(Exception):
    """A question took longer than its limit."""


def _late(*_: object) -> None:
    raise Late


def answered(question: Question, limit: int) -> Entry:
    """``values``: a row for every answer; ``bars``: the estimated errors of the first."""
    signal.signal(signal.SIGPROF, _late)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        return entry(question.asked())
    except Late:
        return {"status": "late"}
    except RuleSheetError as refused:
        return {"status": "refused", "codes": sorted({d.code for d in refused.diagnoses})}
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def entry(result: solver.Result) -> Entry:
    names = [name for name in result.wanted if name not in result.inputs]
    kept: Entry = {"status": str(result.status), "answers": len(result.solutions)}
    if codes := sorted({diagnosis.code for diagnosis in result.diagnoses}):
        kept["codes"] = codes
    if result.complete:
        kept["complete"] = True
    if result.undetermined:
        kept["undetermined"] = sorted(result.undetermined)
    if result.solutions and str(result.status) in ("solved", "singular"):
        kept["names"] = names
        kept["values"] = [
            [answer.get(name) for name in names] for answer in result.solutions[:ANSWERS]
        ]
        kept["bars"] = [_bar(result.solutions[0], name) for name in names]
    return kept


def _bar(answer: solver.Solution, name: str) -> float | None:
    """None where nothing bounds the error."""
    error = answer.error.get(name, 0.0)
    return float(f"{error:.1e}") if math.isfinite(error) else None


def file_of(source: str) -> Path:
    return HERE / f"{source}.json"


def write(source: str, entries: dict[str, Entry]) -> None:
    """A question a line, so that changes can be read."""
    dense = {name: json.dumps(entry, separators=(",", ":")) for name, entry in entries.items()}
    lines = [f"{json.dumps(name)}: {entry}" for name, entry in dense.items()]
    file_of(source).write_text("{\n" + ",\n".join(lines) + "\n}\n")


def kept() -> Iterator[tuple[str, Entry]]:
    for file in sorted(HERE.glob("*.json")):
        for name, entry in json.loads(file.read_text()).items():
            yield f"{file.stem}/{name}", entry
