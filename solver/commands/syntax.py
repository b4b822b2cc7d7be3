"""What a command takes on its line, told once; plain lines are read here, all others by ``argparse``.

``argparse`` costs more than a solve when it is imported, and more again when it reads. Its own calls
declare the options (``add_argument``, ``add_mutually_exclusive_group``); they are written down, and a
line that is nothing but known words in their full form is read from that. Help, mistakes and rarer
forms are left to a parser of ``argparse`` that is told the same.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import ArgumentParser
    from collections.abc import Iterator, Sequence
    from typing import Any

_KNOWN = frozenset({"action", "default", "dest", "help", "metavar", "nargs", "required", "const"})


class Argument:
    """One ``add_argument``; ``group`` tells which others exclude it."""

    def __init__(self, flags: tuple[str, ...], said: dict[str, Any], group: object) -> None:
        self.flags, self.said, self.group = flags, said, group
        long = next((flag for flag in flags if flag.startswith("--")), flags[0])
        self.dest: str = said.get("dest") or long.lstrip("-").replace("-", "_")
        self.action: str = said.get("action", "store")

    @property
    def positional(self) -> bool:
        return not self.flags[0].startswith("-")

    @property
    def plain(self) -> bool:
        """Whether words for it can be read here."""
        counts = (None, "?") if self.positional else (None,)
        simple = self.action in ("store", "append", "store_true") and _KNOWN.issuperset(self.said)
        return simple and self.said.get("nargs") in counts

    @property
    def default(self) -> Any:
        return self.said.get("default", False if self.action == "store_true" else None)


class Group:
    """Arguments that exclude each other."""

    def __init__(self, syntax: Syntax) -> None:
        self._syntax = syntax

    def add_argument(self, *flags: str, **said: Any) -> None:
        self._syntax.arguments.append(Argument(flags, said, self))


class Syntax:
    """The arguments of one command, in the order in which they are declared."""

    def __init__(self) -> None:
        self.arguments: list[Argument] = []

    def add_argument(self, *flags: str, **said: Any) -> None:
        self.arguments.append(Argument(flags, said, None))

    def add_mutually_exclusive_group(self) -> Group:
        return Group(self)

    def declare(self, parser: ArgumentParser) -> None:
        """Tell a parser of ``argparse`` the same."""
        groups: dict[object, Any] = {None: parser}
        for argument in self.arguments:
            if argument.group not in groups:
                groups[argument.group] = parser.add_mutually_exclusive_group()
            groups[argument.group].add_argument(*argument.flags, **argument.said)

    def read(self, words: Sequence[str]) -> SimpleNamespace | None:
        """What a plain line says, as ``argparse`` would; None for every other line."""
        values = {argument.dest: argument.default for argument in self.arguments}
        options = {flag: argument for argument in self.arguments for flag in argument.flags}
        loose: list[str] = []
        groups: dict[object, Argument] = {}
        rest = iter(words)
        for word in rest:
            if not word.startswith("-"):
                loose.append(word)
                continue
            flag, equals, text = word.partition("=")
            option = options.get(flag)
            if option is None or not option.plain or (equals and len(flag) == 2):
                return None
            if option.group is not None and groups.setdefault(option.group, option) is not option:
                return None
            if not _take(option, text if equals else None, rest, values):
                return None
        if any(a.said.get("required") and values[a.dest] == a.default for a in self.arguments):
            return None
        return SimpleNamespace(**values) if self._place(loose, values) else None

    def _place(self, words: list[str], values: dict[str, Any]) -> bool:
        """Give positional arguments their words; False where that is not plain."""
        positional = [argument for argument in self.arguments if argument.positional]
        needed = sum(argument.said.get("nargs") is None for argument in positional)
        if not all(a.plain for a in positional) or not needed <= len(words) <= len(positional):
            return False
        if any(a.said.get("nargs") is None for a in positional[needed:]):
            return False
        values.update((argument.dest, word) for argument, word in zip(positional, words, strict=False))
        return True


def _take(option: Argument, text: str | None, rest: Iterator[str], values: dict[str, Any]) -> bool:
    """Read the value of an option; False where that is not plain."""
    if option.action == "store_true":
        values[option.dest] = True
        return text is None
    if text is None:
        text = next(rest, "-")
        if text.startswith("-"):
            return False
    values[option.dest] = [*(values[option.dest] or ()), text] if option.action == "append" else text
    return True
