"""Models kept on disk: a sheet that was parsed and checked once is read again without either.

An entry is found by the folder and the text of a sheet. It tells which files the sheet uses, in the
order in which they were opened, and holds only while each of them says what it said then.
The sides of an equation stay packed until they are looked at.
"""

from __future__ import annotations

import marshal
import os
from functools import partial

from rulesheets import store
from rulesheets.diagnosis import RuleSheetError
from rulesheets.model import Equation, Model, packed_equation, read_from
from rulesheets.packing import Packing, Unpackable, Unpacking
from rulesheets.reading import files_read, read_source
from rulesheets.source import Source

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from typing import Any

    from rulesheets.nodes import Expression
    from rulesheets.program import Program

KIND = "model"


def kept_model(name: str, source: Source, folder: str, file: str | None) -> Model | None:
    """The model of a sheet that was kept, under the ``name`` it has now; None where there is none.

    ``file`` is where the sheet stands, None for a text in no file; ``folder`` is what its uses start from.
    """
    data = store.load(KIND, _key(source, folder))
    if data is None:
        return None
    openings, digests, names, classes, fields, equations = marshal.loads(data)
    sources = _opened(source, folder, file, openings)
    if sources is None or list(map(_digest, sources)) != digests:
        return None
    unpacking = Unpacking(classes, sources, names)
    model = Model(
        name=name,
        files=files_read(file, sources[1:]),
        equations=tuple(_equations(equations, unpacking, names)),
        **unpacking.unpack(fields),
    )
    return read_from(model, store.digest(*digests))


def keep_model(model: Model, source: Source, folder: str, program: Program) -> Model:
    """Keep a model for :func:`kept_model`; the model, which knows the digest of all its texts then."""
    sources = [source, *program.texts]
    digests = list(map(_digest, sources))
    names = list(model.variables)
    packing = Packing(sources, names)
    fields = {name: getattr(model, name) for name in Model.__match_args__ if name not in _APART}
    try:
        packed = packing.pack(fields), [_packed(equation, packing) for equation in model.equations]
        places = [(opening.user, opening.path, opening.file) for opening in program.openings]
        data = marshal.dumps((places, digests, names, packing.classes, *packed))
    except (Unpackable, RecursionError, ValueError):
        return model  # nested more deeply than can be packed
    store.save(KIND, _key(source, folder), data)
    return read_from(model, store.digest(*digests))


_APART = ("name", "equations", "files")
"""Fields of a model that are not packed with the others."""


def _packed(equation: Equation, packing: Packing) -> tuple[Any, ...]:
    """An equation without its index; the sides as bytes, so that reading them can wait."""
    sides = marshal.dumps((packing.pack(equation.left), packing.pack(equation.right)))
    names = tuple(map(packing.number_of, equation.names))
    return packing.pack(equation.guard), packing.pack(equation.rule), equation.scope, names, sides


def _equations(packed: Sequence[Any], unpacking: Unpacking, names: Sequence[str]) -> Iterator[Equation]:
    for index, (guard, rule, scope, numbers, sides) in enumerate(packed):
        yield packed_equation(
            index=index,
            guard=unpacking.unpack(guard),
            rule=unpacking.unpack(rule),
            scope=scope,
            names=tuple([names[number] for number in numbers]),
            sides=partial(_sides, unpacking, sides),
        )


def _sides(unpacking: Unpacking, packed: bytes) -> tuple[Expression, Expression]:
    left, right = marshal.loads(packed)
    return unpacking.unpack(left), unpacking.unpack(right)


def _opened(
    source: Source, folder: str, file: str | None, openings: Iterable[tuple[int, str, int]]
) -> list[Source] | None:
    """The sources of a sheet and of its uses, opened as they were then; None where that comes out otherwise.

    An opening is the number of the file that uses, the path as written, and the number of the file used.
    """
    sources, folders = [source], [folder]
    numbers = {os.path.realpath(file) if file else source.name: 0}
    for user, path, number in openings:
        shown = os.path.normpath(os.path.join(folders[user], path))
        key = os.path.realpath(shown)
        if numbers.setdefault(key, len(sources)) != number:
            return None
        if number == len(sources):
            if not os.path.exists(shown):
                return None
            try:
                sources.append(read_source(shown))
            except RuleSheetError:
                return None
            folders.append(os.path.dirname(shown))
    return sources


def _key(source: Source, folder: str) -> bytes:
    return store.digest(os.path.abspath(folder).encode(errors="surrogatepass"), _digest(source))


def _digest(source: Source) -> bytes:
    return store.digest(source.text.encode(errors="surrogatepass"))
