"""Ask the golden questions again and report what differs, by kind.

    python -m tests.golden.compare [--source NAME] [--every N] [--from K] [--limit SECONDS]

Status, number of answers, completeness and codes are compared exactly; values to four units of the
last place and four of the error bars that were recorded, which are the conditioning of the question
times its rounding.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections import Counter
from collections.abc import Iterator
from typing import Any

from .questions import SOURCES, Question
from .record import Entry, answered, kept

ULPS = 4


def differences(before: Entry, now: Entry) -> Iterator[tuple[str, str]]:
    """Kinds of differences, and what they are."""
    if before["status"] != now["status"]:
        yield "status", f"{before['status']} -> {now['status']}"
        return
    for kind in ("answers", "codes", "undetermined", "names"):
        if before.get(kind) != now.get(kind):
            yield kind, f"{before.get(kind)} -> {now.get(kind)}"
    if before.get("complete") != now.get("complete"):
        change = "lost" if before.get("complete") else "gained"
        yield f"complete {change}", f"{now['answers']} answers"
    if before.get("names") == now.get("names") and before.get("answers") == now.get("answers"):
        yield from _values(before, now)


def _values(before: Entry, now: Entry) -> Iterator[tuple[str, str]]:
    rows, others = before.get("values", []), now.get("values", [])
    if all(_agree(row, other, before) for row, other in zip(rows, others, strict=True)):
        return
    if all(any(_agree(row, other, before) for other in others) for row in rows):
        yield "order", f"first {dict(zip(now['names'], others[0], strict=True))}"
        return
    for row, other in zip(rows, others, strict=True):
        for name, was, value, bar in zip(before["names"], row, other, before["bars"], strict=True):
            if not _equal(was, value, bar):
                yield "values", f"{name}: {was} -> {value}, bar {bar}"
                return


def _agree(row: list[Any], other: list[Any], before: Entry) -> bool:
    return all(_equal(*pair) for pair in zip(row, other, before["bars"], strict=True))


def _equal(was: Any, value: Any, bar: float | None) -> bool:
    if bar is None or not isinstance(was, float) or not isinstance(value, float):
        return bar is None or bool(was == value)
    return abs(was - value) <= ULPS * (math.ulp(was) + bar)


def compared(asked: list[Question], limit: int) -> Iterator[tuple[str, str, str]]:
    """(kind, question, detail) for every difference from what is kept."""
    golden = dict(kept())
    for question in asked:
        if question.id not in golden:
            yield "new", question.id, "not recorded"
            continue
        for kind, detail in differences(golden[question.id], answered(question, limit)):
            yield kind, question.id, detail


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Ask the golden questions again and report what differs."
    )
    parser.add_argument("--source", choices=SOURCES)
    parser.add_argument("--every", type=int, default=1, metavar="N", help="each N-th question only")
    parser.add_argument(
        "--from", type=int, default=0, metavar="K", dest="first", help="the first of them"
    )
    parser.add_argument("--limit", type=int, default=60, metavar="SECONDS", help="of the processor")
    options = parser.parse_args()
    sources = [options.source] if options.source else SOURCES
    asked = [question for source in sources for question in SOURCES[source]()][
        options.first :: options.every
    ]
    counts: Counter[str] = Counter()
    for kind, name, detail in compared(asked, options.limit):
        counts[kind] += 1
        print(f"{kind:<16}{name}: {detail}", flush=True)
    print(f"{len(asked)} questions, {dict(counts) or 'no difference'}")
    sys.exit(bool(counts))


if __name__ == "__main__":
    main()
