"""Commands about Backsolve: ``models``, ``codes``, ``cache``, ``completion``, ``tutor``."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tempfile
import tomllib
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from shlex import quote
from textwrap import indent
from typing import Any, TypeAlias

from rulesheets import store
from rulesheets.diagnosis import catalogue, refusal, suggestion
from rulesheets.files import find_sheet, shipped_models
from solver.commands import Command, declare
from solver.report import table


def _models(arguments: Namespace) -> int:
    """A line for each model: its name, and the comment on the first line of its sheet."""
    print(table((), ((name, title(find_sheet(name))) for name in shipped_models())))
    return 0


def title(path: str) -> str:
    """The comment on the first line of a sheet, empty where there is none."""
    with open(path, encoding="utf-8") as file:
        first = file.readline().strip()
    return first.lstrip('";').strip() if first[:1] in ('"', ";") else ""


def _codes(arguments: Namespace) -> int:
    """One code with its cause and its remedy, or a line for each."""
    if arguments.code is None:
        print(table((), ((code, entry.title) for code, entry in catalogue().items())))
        return 0
    code = arguments.code.strip("[]").upper()
    if code not in catalogue():
        notes = (*suggestion(code, catalogue()), "`backsolve codes` lists them")
        raise refusal("E426", f"no message has the code {arguments.code}", None, *notes)
    entry = catalogue()[code]
    print(f"{code}: {entry.title}\n\n{entry.cause}\n{entry.fix}")
    return 0


def _cache(arguments: Namespace) -> int:
    """Print the folder, number and size of the entries; ``--clear`` removes them first."""
    folder = store.folder()
    if folder is None:
        print("the cache is off: BACKSOLVE_CACHE is empty")
        return 0
    try:
        count, size = (store.clear(), 0) if arguments.clear else store.usage()
    except OSError as failure:
        print(f"error: {folder} cannot be cleared: {failure.strerror}", file=sys.stderr)
        return 2
    taken = f"{size / 2**20:.1f} MB" if size >= 2**20 else f"{size / 2**10:.1f} kB"
    entries = "1 entry" if count == 1 else f"{count or 'no'} entries"
    print(f"{folder}: {entries} removed" if arguments.clear else f"{folder}: {entries}, {taken}")
    if not arguments.clear and not store.trusted(folder):
        told = "it is not used: it belongs to somebody else, or others can write to it"
        print(told, file=sys.stderr)
    return 0


def _completion(arguments: Namespace) -> int:
    """Print the script of a shell: every command with its options and words."""
    commands = {}
    for name, (module, about) in sorted(arguments.commands.items()):
        parser = ArgumentParser(add_help=False)
        declare(parser, import_module(f"solver.{module}").COMMANDS[name].options)
        options = [one for one in parser._actions if one.option_strings]
        plain = [one for one in parser._actions if not one.option_strings]
        words = [str(choice) for one in plain for choice in one.choices or ()]
        if any(one.metavar == "SHEET" for one in plain):  # files are completed beside them
            words += shipped_models()
        commands[name] = about, options, " ".join(words)
    if arguments.shell == "zsh":
        print("autoload -U +X bashcompinit && bashcompinit")
    print("\n".join((_fish if arguments.shell == "fish" else _bash)(commands)))
    return 0


Completed: TypeAlias = Mapping[str, tuple[str, Sequence[Action], str]]
"""By command what it does, its options, and the words that can stand without one."""


def _bash(commands: Completed) -> Iterator[str]:
    yield "_backsolve() {"
    yield "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words options"
    yield '  _of() { COMPREPLY+=($(compgen -W "$1" -- "$word")); }'
    yield "  COMPREPLY=()"
    yield f'  [ "$COMP_CWORD" -gt 1 ] || {{ _of "{" ".join(commands)}"; return; }}'
    yield '  case "${COMP_WORDS[1]} $before" in'
    for command, (_, options, _) in commands.items():
        for option in filter(lambda one: one.choices, options):
            places = "|".join(f'"{command} {name}"' for name in option.option_strings)
            yield f'    {places}) _of "{_choices(option)}"; return;;'
    yield "  esac"
    yield "  case ${COMP_WORDS[1]} in"
    for command, (_, options, words) in commands.items():
        names = " ".join(name for option in options for name in option.option_strings)
        yield f'    {command}) options="{names}" words="{words}";;'
    yield "  esac"
    files = '_of "$words"; COMPREPLY+=($(compgen -f -- "$word"))'
    yield f'  case $word in -*) _of "$options";; *) {files};; esac'
    yield "}"
    yield "complete -o filenames -F _backsolve backsolve"


def _fish(commands: Completed) -> Iterator[str]:
    for command, (about, *_) in commands.items():
        yield f"complete -c backsolve -n __fish_use_subcommand -f -a {command} -d {quote(about)}"
    for command, (_, options, words) in commands.items():
        start = f"complete -c backsolve -n '__fish_seen_subcommand_from {command}'"
        if words:
            yield f"{start} -a {quote(words)}"
        for option in options:
            marks = {"--": "-l", "-": "-s"}  # of long and of short names
            apart = (name.partition(name.lstrip("-")) for name in option.option_strings)
            names = " ".join(f"{marks[dashes]} {name}" for dashes, name, _ in apart)
            values = f" -a {quote(_choices(option))}" if option.choices else ""
            takes = " -r" * (option.nargs != 0)
            yield f"{start} {names}{takes}{values} -d {quote(option.help or '')}"


def _choices(option: Action) -> str:
    return " ".join(map(str, option.choices or ()))


def tutor() -> dict[str, Any]:
    """The first ``sheet``, and lessons: what each ``says``, its ``command``, a line it ``adds``."""
    return tomllib.loads(Path(__file__).with_name("tutor.toml").read_text(encoding="utf-8"))


def _tutor(arguments: Namespace) -> int:
    """Run the lessons; the reader types each command, or presses Enter to run it."""
    print("Five minutes with Backsolve. Type the command or press Enter to run it; q ends.\n")
    told = tutor()
    sheet, lessons = told["sheet"], told["lessons"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "box.tk"
        file.write_text(sheet, encoding="utf-8")
        for number, lesson in enumerate(lessons, 1):
            with file.open("a", encoding="utf-8") as more:
                more.write(lesson.get("adds", ""))
            says = lesson["says"].replace("{sheet}", indent(sheet, "    ", bool))
            print(f"--- {number} of {len(lessons)} ---\n\n{says}\n\n    {lesson['command']}\n")
            if not _tried(lesson["command"], folder):
                return 0
    print(told["farewell"], end="")
    return 0


def _tried(command: str, folder: str) -> bool:
    """Run what is typed until it is the command of the lesson; False if the reader quits."""
    while True:
        try:
            typed = input("$ ").strip()
        except EOFError:
            return False
        if typed in ("q", "quit", "exit"):
            return False
        _run(typed or command, folder)
        if not typed or typed.split() == command.split():
            return True
        print("Go on trying, or press Enter for the command above.\n")


def _run(line: str, folder: str) -> None:
    """Run a ``backsolve`` command in the folder; other commands are refused."""
    try:
        program, *words = shlex.split(line)
    except ValueError:
        program, words = "", []
    if program != "backsolve":
        print("Here, every command begins with backsolve.\n")
        return
    paths = str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")
    ours = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    sys.stdout.flush()
    subprocess.run([sys.executable, "-m", "solver", *words], cwd=folder, env=ours)
    print()


CODE = "code [CODE]  such as E105 or S530; without it, all of them are listed\n"
CACHE = "--clear  remove every entry\n"
SHELL = "shell {bash,zsh,fish}  the shell to complete in\n"
SETUP = (
    'bash: eval "$(backsolve completion bash)" in ~/.bashrc; zsh: the same, after compinit; '
    "fish: backsolve completion fish > ~/.config/fish/completions/backsolve.fish"
)

COMMANDS = {
    "models": Command("", _models, keeps=False),
    "codes": Command(CODE, _codes, keeps=False),
    "cache": Command(CACHE, _cache, keeps=False),
    "completion": Command(SHELL, _completion, keeps=False, epilog=SETUP),
    "tutor": Command("", _tutor, keeps=False, epilog="It writes only to a temporary folder."),
}
