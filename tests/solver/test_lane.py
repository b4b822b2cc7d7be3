"""A worker that is asked one question after the other."""

from __future__ import annotations

import asyncio
from typing import Any

from solver.lane import Lane, Workers

RIGHT, WRONG = "variables\n x = 1\nrules\n y = x\n", "rules\n y = = 1\n"


def check(text: str) -> dict[str, Any]:
    return {"do": "check", "text": text, "name": "a", "base": "", "within": None}


def test_the_answer_to_a_question_that_was_dropped_is_taken_for_no_other() -> None:
    """An editor drops the check of a text that has been typed on."""

    async def replies() -> tuple[dict[str, Any], dict[str, Any]]:
        workers = Workers()
        lane = Lane(workers, 60.0)
        first = await lane.ask(check(RIGHT))
        dropped = asyncio.ensure_future(lane.ask(check(WRONG)))
        await asyncio.sleep(0)
        dropped.cancel()
        await asyncio.gather(dropped, return_exceptions=True)
        second = await lane.ask(check(RIGHT))
        await lane.stop()
        await workers.close()
        return first, second

    first, second = asyncio.run(replies())
    assert first == second and "wrong" not in second
