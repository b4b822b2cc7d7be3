"""The other end of ``workers``: a process that solves pieces of one sweep until its input ends.

Work and pieces come on standard input, solved pieces or exceptions go to what was standard output,
all of them pickled. What anything prints goes to standard error.
"""

from __future__ import annotations

import os
import pickle
import sys


def serve() -> None:
    """Solve pieces until there are no more."""
    from solver.sweeps.work import Solver, unpacked

    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    questions = sys.stdin.buffer
    solve = Solver(unpacked(pickle.load(questions)))
    while True:
        try:
            columns = pickle.load(questions)
        except EOFError:
            return
        try:
            answer: object = solve(columns)
        except Exception as failure:
            answer = failure
        pickle.dump(answer, answers, protocol=5)
        answers.flush()
