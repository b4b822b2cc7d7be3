"""The language server: diagnostics, hover, completion, definitions, renaming and formatting.

Texts are checked and solved in separate processes: the editor never waits for a solve.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path
from pygls.workspace import TextDocument

from rulesheets.diagnosis import RuleSheetError
from rulesheets.files import parsed, read_source
from rulesheets.format import format_sheet
from rulesheets.functions import TABLE
from rulesheets.inputs import readable
from rulesheets.syntax import Source
from solver.editor import HEADS, KEYWORDS, MARKS, NAME, RESERVED, Names, Symbol, Word, symbol
from solver.lane import Json, Lane, Workers

TYPING = 0.15
"""Seconds without a change after which a text is checked."""

SEVERITIES = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "note": lsp.DiagnosticSeverity.Information,
}


@dataclass(frozen=True)
class Answer:
    """A text that was solved, as the workers take it, with what they say of it."""

    sheet: Json
    reply: Json

    @property
    def text(self) -> str:
        return str(self.sheet["text"])

    @cached_property
    def values(self) -> Json:
        """The values of the first solution, or those that are known without one."""
        found: Json = (self.reply.get("solutions") or [self.reply.get("partial", {})])[0]
        return found

    @cached_property
    def rows(self) -> dict[str, Json]:
        return {one["name"]: one for one in self.reply["variables"]}

    def told(self, name: str) -> str:
        """The value of a variable, in its display unit if it has one."""
        value, row = self.values[name], self.rows.get(name, {"unit": "", "scale": (1.0, 0.0)})
        if not isinstance(value, str):
            factor, shift = row["scale"]
            value = value * factor + shift
        return f"{readable(value)} {row['unit']}".rstrip()


class Server(LanguageServer):
    """A server for one editor. ``answers`` has the last result of each solved document."""

    def __init__(self, timeout: float) -> None:
        super().__init__("backsolve", version("backsolve"))
        workers = Workers()
        self.quick, self.slow = Lane(workers, timeout), Lane(workers, timeout)
        self.workers = workers
        self.waiting: dict[str, asyncio.Task[None]] = {}
        self.answers: dict[str, Answer] = {}

    def document(self, uri: str) -> TextDocument:
        return self.workspace.get_text_document(uri)

    # --- checks and solves ---

    def changed(self, uri: str, *, solve: bool = False) -> None:
        """Check a document soon, and solve it if requested; a waiting check of it is dropped."""
        if before := self.waiting.pop(uri, None):
            before.cancel()
        self.waiting[uri] = asyncio.ensure_future(self._look(uri, solve))

    async def _look(self, uri: str, solve: bool) -> None:
        await asyncio.sleep(0 if solve else TYPING)
        document = self.document(uri)
        reply = await self.check(document, document.source)
        found = [*reply.get("wrong", ()), *reply.get("warnings", ())]
        if solve and "wrong" not in reply:
            answer = await self.solved(document)
            told = answer.get("diagnoses", ())  # warnings of units, which the check has told, too
            found += (one for one in told if not one["code"].startswith("W"))
        names, shown = Names(document.source), []
        for one in found:
            lines = [one["message"], *(f"help: {note}" for note in one["notes"])]
            where = stretch(document, *_place(document, names, one))
            about = SEVERITIES[one["severity"]], one["code"], None, "backsolve"
            shown.append(lsp.Diagnostic(where, "\n".join(lines), *about))
        params = lsp.PublishDiagnosticsParams(uri, shown, version=document.version)
        self.text_document_publish_diagnostics(params)

    async def check(self, document: TextDocument, text: str) -> Json:
        return await self.quick.ask({**_sheet(document, text), "do": "check"})

    async def solved(self, document: TextDocument) -> Json:
        """The result for the document in its present state, kept for hovers and values."""
        self.answers.pop(document.uri, None)
        sheet = _sheet(document, document.source)
        reply = await self.slow.ask({**sheet, "do": "load"})
        if "variables" in reply:
            answer = await self.slow.ask({"do": "solve", "sheet": sheet})
            if "status" in answer:
                self.answers[document.uri] = Answer(sheet, {**reply, **answer})
                shows = self.client_capabilities.workspace
                if shows and shows.inlay_hint and shows.inlay_hint.refresh_support:
                    self.workspace_inlay_hint_refresh(None)
                return answer
        return {}


def _sheet(document: TextDocument, text: str) -> Json:
    path = document.path or ""
    folder = os.path.dirname(path)
    return {"text": text, "name": path or document.uri, "base": folder, "within": None}


def _place(document: TextDocument, names: Names, told: Json) -> tuple[int, int]:
    """Where a diagnosis stands: at its first place in the document, else at the first variable that
    it is about; in the first line what is about another file."""
    name = document.path or document.uri
    for place in told["places"]:
        if place["file"] == name:
            return place["start"], place["end"]
    words = (names.definition(Symbol(one, "")) for one in told["variables"] if not told["places"])
    return next(((word.start, word.end) for word in words if word), (0, 0))


def stretch(document: TextDocument, start: int, end: int) -> lsp.Range:
    """A range of the text in the units of the editor."""
    source = Source("", document.source)

    def position(offset: int) -> lsp.Position:
        line, column = source.place(min(offset, len(source.text)))
        before = source.line(line)[: column - 1]
        return lsp.Position(line - 1, document.position_codec.client_num_units(before))

    return lsp.Range(position(start), position(end))


# --- what is asked about a place ---


def asked(server: Server, params: Any) -> tuple[TextDocument, Names, int, Word | None]:
    """The document, its names, the offset of the position in a request, and the word there."""
    document = server.document(params.text_document.uri)
    names, offset = Names(document.source), document.offset_at_position(params.position)
    return document, names, offset, names.at(offset)


def beside(document: TextDocument, word: Word) -> Path:
    """The file that a quoted path of a document refers to."""
    return Path(document.path or ".").parent / word.text.strip('"')


def used_files(document: TextDocument, names: Names) -> Iterator[Path]:
    """The existing files that a document names in ``use``."""
    paths = (beside(document, word) for word in names.words if word.kind == "path")
    return filter(Path.is_file, paths)


def defined(server: Server, params: lsp.DefinitionParams) -> lsp.Location | None:
    """Where a symbol is declared, here or in a file that is used; for a path, its file."""
    document, names, _, word = asked(server, params)
    if word and word.kind == "path":
        start = lsp.Position(0, 0)
        return lsp.Location(_uri(beside(document, word)), lsp.Range(start, start))
    if word is None or (named := symbol(word)) is None:
        return None
    function, dot, local = named.name.partition(".")
    texts = [(document, names)]
    for path in used_files(document, names):
        text = read_source(path).text
        texts.append((TextDocument(_uri(path), text), Names(text)))
    wanted = Symbol(local, function.partition("#")[0].lower()) if dot else named
    for other, known in texts if dot or named.function else texts[:1]:
        if word := known.definition(wanted):
            return lsp.Location(other.uri, stretch(other, word.start, word.end))
    return None


def _uri(path: Path) -> str:
    return str(from_fs_path(str(path.resolve())))


async def hover(server: Server, params: lsp.HoverParams) -> lsp.Hover | None:
    document, _, _, word = asked(server, params)
    if word is None or not (said := await explained(server, document, word)):
        return None
    content = lsp.MarkupContent(lsp.MarkupKind.Markdown, said)
    return lsp.Hover(content, stretch(document, word.start, word.end))


async def explained(server: Server, document: TextDocument, word: Word) -> str:
    """The hover text of a word, as Markdown."""
    if word.kind in ("builtin", "constant"):
        entry = TABLE[word.text.lower()]
        example = f"\n\nExample: `{entry.example}`" if entry.example else ""
        return f"`{entry.usage}`: {entry.meaning}{example}"
    named = symbol(word)
    if named is None or named.function or named.scope:
        return ""
    if (answer := server.answers.get(document.uri)) is None:
        return ""
    lines = [answer.rows.get(named.name, {}).get("comment", "")]
    if named.name in answer.values:
        given, many = named.name in answer.reply["inputs"], len(answer.reply["solutions"])
        about = [
            "input" if given else f"first of {many} answers" if many > 1 else "",
            "as last saved" if document.source != answer.text else "",
        ]
        said = f" ({', '.join(filter(None, about))})" if any(about) else ""
        lines.append(f"`{named.name} = {answer.told(named.name)}`{said}")
        if not given:
            asked = {"do": "why", "name": named.name, "sheet": answer.sheet}
            told = await server.slow.ask(asked)
            lines += [f"```text\n{told['text']}\n```"] if told.get("text") else []
    return "\n\n".join(filter(None, lines))


def values(server: Server, params: lsp.InlayHintParams) -> Iterator[lsp.InlayHint]:
    """The value of each computed variable beside its row, or at the end of the line of a rule where
    it appears first; none for a text that has changed since."""
    document = server.document(params.text_document.uri)
    answer, names = server.answers.get(document.uri), Names(document.source)
    if answer is None or answer.text != document.source:
        return
    for name in answer.values:
        if name not in answer.reply["inputs"] and (word := names.definition(Symbol(name, ""))):
            in_row, told = word.section == "variables", answer.told(name)
            end = word.end if in_row else f"{answer.text}\n".index("\n", word.end)
            place = stretch(document, end, end).start
            yield lsp.InlayHint(place, f" = {told}" if in_row else f"  {name} = {told}")


def completions(server: Server, params: lsp.CompletionParams) -> Iterator[lsp.CompletionItem]:
    """Names of the scope, functions and keywords; symbols after ``'``."""
    document, names, offset, word = asked(server, params)
    kinds = lsp.CompletionItemKind
    if word and word.kind in ("comment", "unit", "path"):
        return
    if word and (word.kind == "symbol" or word.text == "'"):
        for said in sorted({one.text[1:] for one in names.words if one.kind == "symbol"}):
            yield lsp.CompletionItem(said, kind=kinds.EnumMember)
        return
    before = [one for one in names.words if one.start < offset]
    scope = before[-1].scope if before else ""
    typed = word.text if word and word.end == offset and word.kind == "name" else ""
    for name in names.known(scope) + (names.known("") if scope else []):
        if name != typed:
            yield lsp.CompletionItem(name, kind=kinds.Variable)
    for name, entry in TABLE.items():
        usage, meaning, kind = entry.usage, entry.meaning, kinds.Function
        yield lsp.CompletionItem(name, kind=kind, detail=usage, documentation=meaning)
    others = (Names(read_source(path).text).functions() for path in used_files(document, names))
    for name in dict.fromkeys((*names.functions(), *(name for some in others for name in some))):
        yield lsp.CompletionItem(name, kind=kinds.Module, detail="rule function")
    for name in (*KEYWORDS, *HEADS, *(MARKS if before and before[-1].section == "figure" else ())):
        yield lsp.CompletionItem(name, kind=kinds.Keyword)


async def renamed(server: Server, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    """The edit that renames a symbol in one document. Raises for one that other files share."""
    document, names, _, word = asked(server, params)
    named, new = symbol(word) if word else None, params.new_name
    if named is None or "." in named.name:
        some = "only variables, points and functions of this file"
        raise JsonRpcInvalidParams(f"{some} can be renamed")
    if not NAME.fullmatch(new) or new.lower() in RESERVED:
        raise JsonRpcInvalidParams(f"{new} is not a name")
    if Symbol(new.lower() if named.function else new, named.scope, named.function) in names.places:
        raise JsonRpcInvalidParams(f"there is already a {new}")
    if named.function and names.definition(named) is None:
        raise JsonRpcInvalidParams(f"{named.name} is defined in another file")
    places = names.places[named]
    edits = [lsp.TextEdit(stretch(document, place.start, place.end), new) for place in places]
    text = document.source
    before = await server.check(document, text)
    for place in reversed(places):
        text = text[: place.start] + new + text[place.end :]
    after = await server.check(document, text)
    if "wrong" in after and "wrong" not in before:
        raise JsonRpcInvalidParams(f"then this is wrong: {after['wrong'][0]['message']}")
    return lsp.WorkspaceEdit(changes={document.uri: edits})


def formatted(server: Server, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
    """The edit that puts a document in canonical form; none for a text that is not a sheet yet."""
    document = server.document(params.text_document.uri)
    text, path = document.source, document.path or None
    try:
        new = format_sheet(parsed(Source(path or document.uri, text), path))
    except RuleSheetError:
        return []
    return [] if new == text else [lsp.TextEdit(stretch(document, 0, len(text)), new)]


# --- the protocol ---


def closed(server: Server, params: lsp.DidCloseTextDocumentParams) -> None:
    uri = params.text_document.uri
    server.answers.pop(uri, None)
    if task := server.waiting.pop(uri, None):
        task.cancel()
    server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))


def server(timeout: float) -> Server:
    """The server with all its handlers."""
    one = Server(timeout)

    async def saved(params: Any) -> None:
        one.changed(params.text_document.uri, solve=True)

    async def changed(params: lsp.DidChangeTextDocumentParams) -> None:
        one.changed(params.text_document.uri)

    async def shutdown(_: None) -> None:
        await asyncio.gather(one.quick.stop(), one.slow.stop(), one.workers.close())

    answers: dict[str, Callable[..., Any]] = {
        lsp.TEXT_DOCUMENT_DID_OPEN: saved,
        lsp.TEXT_DOCUMENT_DID_SAVE: saved,
        lsp.TEXT_DOCUMENT_DID_CHANGE: changed,
        lsp.TEXT_DOCUMENT_DID_CLOSE: partial(closed, one),
        lsp.TEXT_DOCUMENT_HOVER: partial(hover, one),
        lsp.TEXT_DOCUMENT_DEFINITION: partial(defined, one),
        lsp.TEXT_DOCUMENT_COMPLETION: lambda params: list(completions(one, params)),
        lsp.TEXT_DOCUMENT_INLAY_HINT: lambda params: list(values(one, params)),
        lsp.TEXT_DOCUMENT_RENAME: partial(renamed, one),
        lsp.TEXT_DOCUMENT_FORMATTING: partial(formatted, one),
        lsp.SHUTDOWN: shutdown,
    }
    options = {lsp.TEXT_DOCUMENT_COMPLETION: lsp.CompletionOptions(trigger_characters=["'"])}
    for feature, answer in answers.items():
        one.feature(feature, options.get(feature))(answer)
    return one
