"""The primary answers of a sweep, piece by piece: a branch goes on from one piece to the next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solver.files.columns import Array, stacked
from solver.plan import first_answers
from solver.sweeps.work import Rows, Solved, Work
from solver.trace.rows import Answers


class Branches:
    """Replaces the answers that the rule put first by those that continue the branch of the row before.

    A row begins anew where ``line`` rows are full: where an outer input of a grid changes.
    """

    def __init__(self, work: Work, line: int) -> None:
        self.work, self.line = work, line
        self._done = 0
        self._before: Rows | None = None

    def __call__(self, piece: Solved) -> Solved:
        assert piece.rows is not None
        last = piece.rows.last()
        if piece.several:
            before = self._before
            rows = piece.rows if before is None else _together(before, piece.rows)
            extra = len(rows.codes) - len(piece.rows.codes)
            at = self._done - extra
            answers = rows.answers
            work = self.work
            first = first_answers(work.model, work.want, rows.inputs, answers, (self.line, at, extra))
            own = first[extra:] - int(answers.counts[:extra].sum())
            solved = work.solved(piece.rows, np.where(piece.rows.answers.counts > 0, own, -1))
            piece = replace(solved, several=piece.several)
            last = _in_front(rows, first).last()
        self._before, self._done = last, self._done + sum(piece.counts)
        return piece


def _together(one: Rows, other: Rows) -> Rows:
    inputs = tuple(stacked(pair) for pair in zip(one.inputs, other.inputs, strict=True))
    values = [stacked(pair) for pair in zip(one.answers.values, other.answers.values, strict=True)]
    counts = np.concatenate([one.answers.counts, other.answers.counts])
    return Rows(inputs, np.concatenate([one.codes, other.codes]), Answers(counts, values))


def _in_front(rows: Rows, first: Array) -> Rows:
    """The rows with their primary answers before their others."""
    counts = rows.answers.counts
    places = np.arange(counts.sum())
    later = np.ones(len(places), dtype=bool)
    later[first[first >= 0]] = False
    order = np.lexsort((later, np.repeat(np.arange(len(counts)), counts)))
    return replace(rows, answers=Answers(counts, [values[order] for values in rows.answers.values]))
