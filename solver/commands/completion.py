"""``backsolve completion``: what a shell needs to complete commands, options, sheets and values."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from shlex import quote

from rulesheets.loading import shipped_models

SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="the shell to complete in")
    parser.epilog = (
        'bash: eval "$(backsolve completion bash)" in ~/.bashrc; zsh: the same, after compinit; '
        "fish: backsolve completion fish > ~/.config/fish/completions/backsolve.fish"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the script of a shell."""
    write = {"bash": _bash, "zsh": _zsh, "fish": _fish}[arguments.shell]
    print("\n".join(write(list(_commands()))))
    return 0


@dataclass(frozen=True)
class Option:
    """``values`` are its choices; ``takes`` tells whether a value follows."""

    names: tuple[str, ...]
    about: str
    takes: bool
    values: tuple[str, ...]


@dataclass(frozen=True)
class Command:
    """``words`` are what can stand without an option; ``sheet``: that can be a rule sheet."""

    name: str
    about: str
    options: tuple[Option, ...]
    words: tuple[str, ...]
    sheet: bool


def _commands() -> Iterator[Command]:
    """Every command, from the module that it is in and from what that adds to a parser."""
    package = import_module("solver.commands")
    for found in iter_modules(package.__path__):
        module = import_module(f"solver.commands.{found.name}")
        if hasattr(module, "run") and hasattr(module, "add_arguments"):
            parser = argparse.ArgumentParser(add_help=False)
            module.add_arguments(parser)
            about = str(module.__doc__).partition(": ")[2].partition("\n")[0].rstrip(".")
            yield _command(found.name, about, parser._actions)


def _command(name: str, about: str, actions: list[argparse.Action]) -> Command:
    options = tuple(
        Option(tuple(one.option_strings), one.help or "", one.nargs != 0, tuple(map(str, one.choices or ())))
        for one in actions
        if one.option_strings
    )
    plain = [one for one in actions if not one.option_strings]
    words = tuple(str(choice) for one in plain for choice in one.choices or ())
    return Command(name, about, options, words, any(one.metavar == "SHEET" for one in plain))


def _bash(commands: list[Command]) -> Iterator[str]:
    yield "_backsolve() {"
    yield "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words options"
    yield '  _of() { COMPREPLY+=($(compgen -W "$1" -- "$word")); }'
    yield "  COMPREPLY=()"
    names = " ".join(command.name for command in commands)
    yield f'  [ "$COMP_CWORD" -gt 1 ] || {{ _of "{names}"; return; }}'
    yield '  case "${COMP_WORDS[1]} $before" in'
    for command in commands:
        for option in filter(lambda one: one.values, command.options):
            places = "|".join(f'"{command.name} {name}"' for name in option.names)
            yield f'    {places}) _of "{" ".join(option.values)}"; return;;'
    yield "  esac"
    yield "  case ${COMP_WORDS[1]} in"
    for command in commands:
        options = " ".join(name for option in command.options for name in option.names)
        yield f'    {command.name}) options="{options}" words="{" ".join(_free(command))}";;'
    yield "  esac"
    yield '  case $word in -*) _of "$options";; *) _of "$words"; COMPREPLY+=($(compgen -f -- "$word"));; esac'
    yield "}"
    yield "complete -o filenames -F _backsolve backsolve"


def _free(command: Command) -> tuple[str, ...]:
    """What can stand without an option, beside files."""
    return (*command.words, *(shipped_models() if command.sheet else ()))


def _zsh(commands: list[Command]) -> Iterator[str]:
    yield "#compdef backsolve"
    yield "_backsolve() {"
    told = " ".join(quote(f"{command.name}:{command.about}") for command in commands)
    yield f"  local -a commands=({told})"
    yield "  if (( CURRENT == 2 )); then _describe command commands; return; fi"
    yield "  local command=$words[2]; shift words; (( CURRENT-- ))"
    yield "  case $command in"
    for command in commands:
        specs = [_zsh_option(name, option) for option in command.options for name in option.names]
        words = _free(command)
        rest = f"*:word:{{ compadd {' '.join(words)}; _files }}" if words else "*:file:_files"
        yield f"    {command.name}) _arguments {' '.join(map(quote, (*specs, rest)))};;"
    yield "  esac"
    yield "}"
    yield "compdef _backsolve backsolve"


def _zsh_option(name: str, option: Option) -> str:
    about = option.about.replace("[", "(").replace("]", ")").replace(":", r"\:")
    value = f":value:({' '.join(option.values)})" if option.values else ":value:_files" * option.takes
    return f"*{name}[{about}]{value}"


def _fish(commands: list[Command]) -> Iterator[str]:
    for command in commands:
        yield f"complete -c backsolve -n __fish_use_subcommand -f -a {command.name} -d {quote(command.about)}"
    for command in commands:
        start = f"complete -c backsolve -n '__fish_seen_subcommand_from {command.name}'"
        words = _free(command)
        if words:
            yield f"{start} -a {quote(' '.join(words))}"
        for option in command.options:
            names = " ".join(
                f"-{'l' if name[:2] == '--' else 's'} {name.lstrip('-')}" for name in option.names
            )
            values = f" -a {quote(' '.join(option.values))}" if option.values else ""
            yield f"{start} {names}{' -r' * option.takes}{values} -d {quote(option.about)}"
