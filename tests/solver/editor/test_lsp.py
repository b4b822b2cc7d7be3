"""The language server, driven over its standard streams by pygls' own client."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pygls")

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pygls.lsp.client import LanguageClient
from pygls.uris import from_fs_path

AREA = """\
use "square.tk"
variables
  α = 3 [cm]    " a side 𝛼
  V   [cm^3]    " the volume
rules
  call square(α; A)
  V = A*α
"""
SQUARE = 'function square(x; y)\n  y = x^2 " the area\n'


class Editor(LanguageClient):
    """A client that opens one sheet at a time and keeps what it is told of it."""

    def __init__(self) -> None:
        super().__init__("test", "1")

        @self.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: lsp.PublishDiagnosticsParams) -> None:
            if params.uri == self.uri:
                self.told.put_nowait(list(params.diagnostics))

    async def start(self) -> None:
        await self.start_io(sys.executable, "-m", "solver", "lsp", "--stdio")
        await self.initialize_async(
            lsp.InitializeParams(capabilities=lsp.ClientCapabilities(), process_id=None)
        )
        self.initialized(lsp.InitializedParams())

    async def end(self) -> None:
        await self.shutdown_async(None)
        self.exit(None)
        await self.stop()

    async def open(self, path: Path, text: str) -> list[lsp.Diagnostic]:
        self.uri, self.version = str(from_fs_path(str(path))), 0
        self.document = lsp.TextDocumentIdentifier(self.uri)
        self.told: asyncio.Queue[list[lsp.Diagnostic]] = asyncio.Queue()
        item = lsp.TextDocumentItem(self.uri, "tk", 0, text)
        self.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        return await self.diagnostics()

    async def change(self, text: str) -> list[lsp.Diagnostic]:
        self.version += 1
        which = lsp.VersionedTextDocumentIdentifier(self.version, self.uri)
        whole = lsp.TextDocumentContentChangeWholeDocument(text)
        self.text_document_did_change(lsp.DidChangeTextDocumentParams(which, [whole]))
        return await self.diagnostics()

    async def diagnostics(self) -> list[lsp.Diagnostic]:
        return await asyncio.wait_for(self.told.get(), 60)

    async def hover(self, line: int, character: int) -> str:
        place = lsp.Position(line, character)
        found = await self.text_document_hover_async(lsp.HoverParams(self.document, place))
        return str(found.contents.value) if found else ""  # type: ignore[union-attr]

    async def values(self) -> list[tuple[int, int, str]]:
        whole = lsp.Range(lsp.Position(0, 0), lsp.Position(99, 0))
        params = lsp.InlayHintParams(self.document, whole)
        hints = await self.text_document_inlay_hint_async(params) or []
        return sorted((one.position.line, one.position.character, str(one.label)) for one in hints)

    async def complete(self, line: int, character: int) -> list[str]:
        place = lsp.Position(line, character)
        items = await self.text_document_completion_async(
            lsp.CompletionParams(self.document, place)
        )
        return [item.label for item in items]  # type: ignore[union-attr]

    async def definition(self, line: int, character: int) -> Any:
        place = lsp.Position(line, character)
        return await self.text_document_definition_async(lsp.DefinitionParams(self.document, place))

    async def rename(self, line: int, character: int, name: str) -> list[lsp.TextEdit]:
        place = lsp.Position(line, character)
        edit = await self.text_document_rename_async(lsp.RenameParams(self.document, place, name))
        return list(edit.changes[self.uri])  # type: ignore[union-attr,index]


Steps = Callable[[Editor, list[lsp.Diagnostic]], Awaitable[Any]]
Edited = Callable[[str, Steps], Any]


@pytest.fixture(scope="module")
def running() -> Iterator[tuple[asyncio.Runner, Editor]]:
    """An editor beside its server, for all tests: starting one takes a second."""
    with asyncio.Runner() as runner:
        editor = Editor()
        runner.run(editor.start())
        yield runner, editor
        runner.run(editor.end())


@pytest.fixture
def edited(tmp_path: Path, running: tuple[asyncio.Runner, Editor]) -> Edited:
    """What steps find in a sheet of a folder that is opened with a text."""
    (tmp_path / "square.tk").write_text(SQUARE)
    runner, editor = running

    def edited(text: str, steps: Steps) -> Any:
        (tmp_path / "sheet.tk").write_text(text)

        async def session() -> Any:
            found = await steps(editor, await editor.open(tmp_path / "sheet.tk", text))
            editor.text_document_did_close(lsp.DidCloseTextDocumentParams(editor.document))
            return found

        return runner.run(session())

    return edited


def test_a_mistake_is_told_while_it_is_typed_and_goes_when_it_is_healed(edited: Edited) -> None:
    async def steps(editor: Editor, first: list[lsp.Diagnostic]) -> Any:
        wrong, healed = (
            await editor.change(AREA.replace("A*α", "A = = α")),
            await editor.change(AREA),
        )
        # nothing is solved while it is typed: the rules contradict each other only once they are
        # saved
        apart = await editor.change("x = 2\nx + y = 3\ny = 7\n")
        editor.text_document_did_save(lsp.DidSaveTextDocumentParams(editor.document))
        return first, wrong, healed, apart, await editor.diagnostics()

    first, wrong, healed, apart, saved = edited(AREA, steps)
    assert (first, healed, apart) == ([], [], [])
    assert [one.range.start.line for one in wrong] == [6]
    assert str(wrong[0].code).startswith("E1")
    assert {one.code for one in saved} == {"S520"}


def test_a_warning_of_units_is_told_once(edited: Edited) -> None:
    async def steps(editor: Editor, first: list[lsp.Diagnostic]) -> Any:
        editor.text_document_did_save(lsp.DidSaveTextDocumentParams(editor.document))
        return first, await editor.diagnostics()

    text = "variables\n  P = 5 [kW]\n  T [N-m]\n  w = 10 [rad/s]\nrules\n  P = T*w\n"
    assert [[one.code for one in told] for told in edited(text, steps)] == [["W601"]] * 2


def test_values_stand_beside_their_rows_until_the_text_changes(edited: Edited) -> None:
    text = "variables\n  r = 2 [m]\n  x [m -> mm]\n  T [degC -> K]\nrules\n"
    text += "  x^2 = r^2\n  T = 20\n  y = x + 1"

    async def steps(editor: Editor, first: list[lsp.Diagnostic]) -> None:
        assert await editor.values() == [
            (2, 3, " = 2000 mm"),
            (3, 3, " = 293.15 K"),
            (7, 11, "  y = 3"),
        ]
        assert "`x = 2000 mm` (first of 2 answers)" in await editor.hover(2, 2)
        await editor.change(text.replace("2 [m]", "3 [m]"))
        assert await editor.values() == []
        assert "`r = 2 m` (input, as last saved)" in await editor.hover(1, 2)

    edited(text, steps)


def test_a_missing_input_is_told_at_its_row(edited: Edited) -> None:
    async def steps(editor: Editor, first: list[lsp.Diagnostic]) -> Any:
        return [(one.code, one.range.start.line, one.range.start.character) for one in first]

    text = "variables\n  a = 2\n  b\n  c\nrules\n  c = a*b\n"
    assert edited(text, steps) == [("S510", 2, 2)]


def test_hover_completion_definition_and_format(edited: Edited) -> None:
    async def steps(editor: Editor, first: list[lsp.Diagnostic]) -> None:
        volume = await editor.hover(6, 2)
        assert "the volume" in volume and "`V = 27 cm^3`" in volume and "V = A*α" in volume
        assert "`α = 3 cm` (input)" in await editor.hover(2, 2)
        assert await editor.hover(0, 0) == ""

        side, function, file = [
            await editor.definition(*place) for place in ((6, 8), (5, 9), (0, 6))
        ]
        assert (side.range.start.line, side.range.start.character) == (2, 2)
        assert function.uri.endswith("square.tk") and function.range.start.character == 9
        assert file.uri == function.uri
        with pytest.raises(JsonRpcException, match="another file"):
            await editor.rename(5, 9, "cube")

        await editor.change(AREA + "  s = 'open\n  t = '\n")
        assert {"α", "V", "A", "sqrt", "square", "if"} <= set(await editor.complete(6, 6))
        assert await editor.complete(8, 7) == ["open"]

        await editor.change("y=sqrt(x)\nx=4")
        assert "square root" in await editor.hover(0, 3)
        options = lsp.FormattingOptions(tab_size=2, insert_spaces=True)
        params = lsp.DocumentFormattingParams(editor.document, options)
        (edit,) = await editor.text_document_formatting_async(params)  # type: ignore[misc]
        assert edit.new_text == "rules\n  y = sqrt(x)\n  x = 4\n"
        assert (edit.range.end.line, edit.range.end.character) == (1, 3)

    edited(AREA, steps)


def test_renaming_changes_every_place_of_a_name_and_nothing_else(edited: Edited) -> None:
    text = '  call f(x; z)\n  x = 3 " x\nfunction f(x; y)\n  y = 2*x\n'

    async def steps(editor: Editor, first: list[lsp.Diagnostic]) -> Any:
        outer, inner = await editor.rename(0, 9, "width"), await editor.rename(3, 8, "p")
        for name, said in (("z", "already a z"), ("2x", "not a name"), ("then", "not a name")):
            with pytest.raises(JsonRpcException, match=said):
                await editor.rename(0, 9, name)
        starts = [[one.range.start for one in edit] for edit in (outer, inner)]
        return [[(start.line, start.character) for start in some] for some in starts]

    assert edited(text, steps) == [[(0, 9), (1, 2)], [(2, 11), (3, 8)]]
