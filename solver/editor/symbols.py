"""What the words of a sheet mean: where a name is declared and where else it stands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from solver.editor.words import Word, words


@dataclass(frozen=True)
class Symbol:
    """A name in its scope, or a rule function: ``function`` tells which. Functions are named in any case."""

    name: str
    scope: str
    function: bool = False


@dataclass(frozen=True)
class Names:
    """The names of one text."""

    text: str

    @cached_property
    def words(self) -> list[Word]:
        return words(self.text)

    def at(self, offset: int) -> Word | None:
        """The word at a place; of two that meet there, the one that names something."""
        near = [word for word in self.words if word.start <= offset <= word.end]
        return next((word for word in near if symbol(word)), near[-1] if near else None)

    @cached_property
    def places(self) -> dict[Symbol, list[Word]]:
        """Every symbol with the words that name it, in order."""
        found: dict[Symbol, list[Word]] = {}
        for word in self._naming():
            if named := symbol(word):
                found.setdefault(named, []).append(word)
        return found

    def definition(self, named: Symbol) -> Word | None:
        """The row, head or ``parameters`` line that declares a name, else where it first stands."""
        stands = self.places.get(named, [])
        section = "function" if named.function or named.scope else "variables"
        declared = (word for word in stands if word.section == section)
        if named.function:
            return next(declared, None)
        return next(declared, stands[0] if stands else None)

    def known(self, scope: str) -> list[str]:
        """The names that can be written in a scope: its own and those of the sheet that it shares."""
        return sorted({one.name for one in self.places if one.scope == scope and not one.function})

    def functions(self) -> list[str]:
        return [word.text for word in self.words if word.kind == "function" and word.section == "function"]

    def _naming(self) -> Iterator[Word]:
        """Words, and in ``given('x)`` the variable that is meant by the symbol."""
        given = False
        for word in self.words:
            if word.kind == "symbol" and given:
                name = word.text[1:]
                yield Word("name", word.start + 1, word.end, name, word.scope, word.section)
            yield word
            given = (word.text == "(" and given) or word.text.lower() == "given"


def symbol(word: Word) -> Symbol | None:
    """What a word names; None for one that names nothing of the sheet's own."""
    if word.kind == "function":
        return Symbol(word.text.lower(), "", function=True)
    return Symbol(word.text, word.scope) if word.kind == "name" else None
