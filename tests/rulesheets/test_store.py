"""The store gives back what was saved under a key, whole and its own, or nothing."""

from __future__ import annotations

import errno
import multiprocessing
import os
from pathlib import Path
from typing import Any

import pytest

from rulesheets import store

KEY, OTHER = b"key", b"other key"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "store"
    monkeypatch.setenv("BACKSOLVE_CACHE", str(place))
    return place


def entry(folder: Path) -> Path:
    (found,) = folder.iterdir()
    return found


def test_an_entry_comes_back(folder: Path) -> None:
    assert store.load("thing", KEY) is None
    store.save("thing", KEY, b"said")
    assert store.load("thing", KEY) == b"said"
    assert store.load("thing", OTHER) is None
    assert store.load("other", KEY) is None
    store.save("thing", KEY, b"")
    assert store.load("thing", KEY) == b""
    assert store.usage() == (1, entry(folder).stat().st_size)
    assert store.clear() == 1
    assert store.load("thing", KEY) is None


def test_entries_are_the_users_alone(folder: Path) -> None:
    store.save("thing", KEY, b"said")
    assert folder.stat().st_mode & 0o777 == 0o700
    assert entry(folder).stat().st_mode & 0o777 == 0o600


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="a question of POSIX systems")
def test_what_others_can_write_is_not_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.save("thing", KEY, b"said")
    entry(folder).chmod(0o620)
    assert store.load("thing", KEY) is None
    entry(folder).chmod(0o600)
    assert store.load("thing", KEY) == b"said"
    folder.chmod(0o777)
    assert store.load("thing", KEY) is None
    store.save("thing", OTHER, b"said")
    assert len(list(folder.iterdir())) == 1
    folder.chmod(0o700)
    real = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: real + 1)
    assert store.load("thing", KEY) is None


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="a question of POSIX systems")
def test_a_link_is_not_followed(folder: Path, tmp_path: Path) -> None:
    store.save("thing", KEY, b"said")
    name = entry(folder)
    name.rename(tmp_path / "elsewhere")
    name.symlink_to(tmp_path / "elsewhere")
    assert store.load("thing", KEY) is None


def test_any_damage_is_noticed(folder: Path) -> None:
    store.save("thing", KEY, b"said and done")
    whole = entry(folder).read_bytes()
    for place in range(len(whole)):
        entry(folder).write_bytes(whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :])
        assert store.load("thing", KEY) is None
        entry(folder).write_bytes(whole[:place])
        assert store.load("thing", KEY) is None
    entry(folder).write_bytes(whole + b"\0")
    assert store.load("thing", KEY) is None
    store.save("thing", KEY, b"said and done")
    assert store.load("thing", KEY) == b"said and done"


def test_an_entry_under_another_name_is_not_taken_for_it(folder: Path) -> None:
    store.save("thing", KEY, b"said")
    there = entry(folder)
    store.save("thing", OTHER, b"more")
    (other,) = set(folder.iterdir()) - {there}
    other.write_bytes(there.read_bytes())
    assert store.load("thing", OTHER) is None


def test_without_a_folder_nothing_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BACKSOLVE_CACHE", "")
    store.save("thing", KEY, b"said")
    assert store.load("thing", KEY) is None
    assert store.folder() is None
    assert store.usage() == (0, 0)


@pytest.mark.parametrize("failure", [errno.EROFS, errno.EACCES, errno.ENOSPC])
def test_a_folder_that_cannot_be_written_does_no_harm(
    folder: Path, failure: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.save("thing", KEY, b"said")
    opened = os.open

    def refusing(path: Any, flags: int, *more: Any, **named: Any) -> int:
        if flags & os.O_CREAT:
            raise OSError(failure, os.strerror(failure))
        return opened(path, flags, *more, **named)

    monkeypatch.setattr(os, "open", refusing)
    store.save("thing", OTHER, b"more")
    assert store.load("thing", OTHER) is None
    assert store.load("thing", KEY) == b"said"


def test_a_folder_below_a_file_does_no_harm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("BACKSOLVE_CACHE", str(tmp_path / "file" / "store"))
    store.save("thing", KEY, b"said")
    assert store.load("thing", KEY) is None
    assert store.usage() == (0, 0)


def test_a_full_store_is_emptied(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "LOOKING", 1)
    store.save("thing", KEY, b"said")
    monkeypatch.setattr(store, "MAX_BYTES", 8 * store.usage()[1])
    for number in range(8):
        assert store.usage()[0] == 1 + number
        store.save("thing", bytes([number]), b"said")
    store.save("thing", OTHER, b"said")
    assert store.usage()[0] == 1
    assert store.load("thing", OTHER) == b"said"
    store.save("thing", b"large", bytes(store.MAX_BYTES))
    assert store.load("thing", b"large") is None


def test_writers_at_the_same_time_leave_a_whole_entry(folder: Path) -> None:
    context = multiprocessing.get_context("spawn")
    writers = [context.Process(target=_write, args=(number,)) for number in range(2)]
    for writer in writers:
        writer.start()
    seen = set()
    while any(writer.is_alive() for writer in writers):
        found = store.load("thing", KEY)
        assert found is None or found in {bytes([n]) * 100_000 for n in range(3)}
        seen.add(found)
    for writer in writers:
        writer.join()
        assert writer.exitcode == 0
    assert store.load("thing", KEY) is not None
    assert len(list(folder.iterdir())) == 1


def _write(number: int) -> None:
    for _ in range(50):
        store.save("thing", KEY, bytes([number]) * 100_000)


@pytest.mark.parametrize(
    ("platform", "environment", "expected"),
    [
        ("linux", {}, "/home/me/.cache/backsolve"),
        ("linux", {"XDG_CACHE_HOME": "/caches"}, "/caches/backsolve"),
        ("linux", {"XDG_CACHE_HOME": "not/absolute"}, "/home/me/.cache/backsolve"),
        ("darwin", {}, "/home/me/Library/Caches/backsolve"),
        ("win32", {"LOCALAPPDATA": "/local"}, "/local/backsolve/Cache"),
        ("linux", {"BACKSOLVE_CACHE": "/own", "XDG_CACHE_HOME": "/caches"}, "/own"),
        ("linux", {"HOME": "nowhere"}, None),
    ],
)
def test_the_folder_is_where_the_system_keeps_such(
    platform: str,
    environment: dict[str, str],
    expected: str | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("BACKSOLVE_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in {"HOME": "/home/me", **environment}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.platform", platform)
    assert store.folder() == expected
