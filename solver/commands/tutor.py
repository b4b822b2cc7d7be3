"""``backsolve tutor``: five minutes with a first sheet, in the terminal."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace

BOX = """\
" An open box, folded from a square sheet
variables
  a = 30  [cm]    " side of the sheet
  h = 3   [cm]    " height of the box
  V       [cm^3]  " volume

rules
  V = h*(a - 2*h)^2
"""


@dataclass(frozen=True)
class Lesson:
    """A few sentences and the command that they lead to; ``adds`` is a line that joins the sheet first."""

    says: str
    command: str
    adds: str = ""


LESSONS = (
    Lesson(
        "A sheet is a text file of variables and rules. box.tk says what is known of an open box:\n\n"
        + "".join(f"    {line}\n" for line in BOX.splitlines())
        + "\na and h have values, so they are inputs. V has none, so it is solved for.",
        "backsolve solve box.tk",
    ),
    Lesson(
        "Inputs stand on the left, outputs on the right.\n"
        "A rule is no assignment. Give a volume instead of the side of the sheet:",
        "backsolve solve box.tk --clear a --set V=1200 --guess a=30",
    ),
    Lesson(
        "The equation is quadratic in a, and the guess decided which answer comes first.\n"
        "In h it is cubic. Ask for every height that gives 1500 cm^3:",
        "backsolve solve box.tk --clear h --set V=1500 --all",
    ),
    Lesson(
        "Nobody cuts 19 cm from both ends of 30 cm. The sheet now has one line more, 2*h < a.\n"
        "An inequality determines nothing, but answers that break it are dropped:",
        "backsolve solve box.tk --clear h --set V=1500 --all",
        adds="  2*h < a\n",
    ),
    Lesson(
        "If there is no answer, the message says why, and what would help:",
        "backsolve solve box.tk --clear h --set V=2500",
    ),
    Lesson("Where does a number come from?", "backsolve why box.tk V"),
    Lesson(
        "And how does the volume change with the height?", "backsolve sweep box.tk --over h=1:10:1 --want V"
    ),
)

FAREWELL = """\
That is all there is to begin with. From here:

    backsolve models                     sheets to try
    backsolve open offset_slider_crank   a linkage to drag in the browser
    backsolve COMMAND --help             the options of a command
"""


def add_arguments(parser: ArgumentParser) -> None:
    parser.epilog = "Nothing is written but a sheet in a temporary folder."


def run(arguments: Namespace) -> int:
    """Go through the lessons; the reader types each command, or presses Enter to have it run."""
    print("Five minutes with Backsolve. Type the command or press Enter to run it; q ends.\n")
    with tempfile.TemporaryDirectory() as folder:
        sheet = Path(folder) / "box.tk"
        sheet.write_text(BOX, encoding="utf-8")
        for number, lesson in enumerate(LESSONS, 1):
            with sheet.open("a", encoding="utf-8") as file:
                file.write(lesson.adds)
            print(f"--- {number} of {len(LESSONS)} ---\n\n{lesson.says}\n\n    {lesson.command}\n")
            if not _tried(lesson, folder):
                return 0
    print(FAREWELL, end="")
    return 0


def _tried(lesson: Lesson, folder: str) -> bool:
    """Run what is typed until it is the command of the lesson; False for who wants to leave."""
    while True:
        try:
            typed = input("$ ").strip()
        except EOFError:
            return False
        if typed in ("q", "quit", "exit"):
            return False
        _run(typed or lesson.command, folder)
        if not typed or typed.split() == lesson.command.split():
            return True
        print("Go on trying, or press Enter for the command above.\n")


def _run(line: str, folder: str) -> None:
    """Run a ``backsolve`` command in the folder, and nothing else."""
    try:
        program, *words = shlex.split(line)
    except ValueError:
        program, words = "", []
    if program != "backsolve":
        print("Here, every command begins with backsolve.\n")
        return
    paths = os.pathsep.join(filter(None, (str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH"))))
    sys.stdout.flush()
    subprocess.run(
        [sys.executable, "-m", "solver", *words], cwd=folder, env={**os.environ, "PYTHONPATH": paths}
    )
    print()
