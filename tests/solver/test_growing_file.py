"""Files that grow past the memory of the system or through it: the same bytes, and every failure told."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rulesheets.diagnosis import RuleSheetError
from solver.files import growing
from solver.files.growing import GrowingFile
from solver.files.replacing import Replacement

BATCH = 2**14
Patch = pytest.MonkeyPatch


def opened(path: Path) -> GrowingFile:
    return GrowingFile(os.open(path, os.O_WRONLY | os.O_CREAT))


@pytest.fixture(autouse=True)
def small(monkeypatch: Patch) -> None:
    monkeypatch.setattr(growing, "BATCH", BATCH)
    monkeypatch.setattr(growing, "SHORT", 2 * BATCH)


@settings(max_examples=30, deadline=None)
@given(sizes=st.lists(st.integers(0, 3 * BATCH), max_size=12), share=st.sampled_from([0.0, 0.02, 1e9]))
def test_the_bytes_of_a_file_come_in_order(
    tmp_path_factory: pytest.TempPathFactory, sizes: list[int], share: float
) -> None:
    """Whichever way each batch takes: with a share of 1e9 the ways take turns."""
    path = tmp_path_factory.mktemp("files") / "file"
    parts = [bytes([place % 251]) * size for place, size in enumerate(sizes)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(growing, "TRIALS", share)
        file = opened(path)
        for part in parts:
            file.write(part)
        file.close()
    assert path.read_bytes() == b"".join(parts)


def ways_taken(monkeypatch: Patch, seconds: dict[int, float], batches: int, path: Path) -> list[int]:
    """The flags of the batches of a file whose ways take so long each."""
    clock, taken = [0.0], list[int]()
    plain = growing._write

    def write(handle: int, data: memoryview, way: int = 0) -> memoryview:
        clock[0] += seconds[way]
        taken.append(way)
        return plain(handle, data)

    monkeypatch.setattr(growing, "_divert", lambda handle, flag: None)
    monkeypatch.setattr(growing, "_write", write)
    monkeypatch.setattr(growing, "perf_counter", lambda: clock[0])
    file = opened(path)
    for _ in range(batches):
        file.write(b"x" * BATCH)
    file.close()
    return taken


def test_the_quicker_way_is_taken_and_the_other_rarely_tried_again(
    tmp_path: Path, monkeypatch: Patch
) -> None:
    monkeypatch.setattr(growing, "DIRECT", 8)
    for quick, slow in ((0, 8), (8, 0)):
        taken = ways_taken(monkeypatch, {quick: 1.0, slow: 3.0}, 1000, tmp_path / "file")
        assert taken[:3] == [0, 0, 8], "a short file stays in memory"
        tried = taken[3:].count(slow)
        assert tried >= 1 and 3.0 * tried <= growing.TRIALS * 1000


def test_a_system_without_a_way_past_its_memory(tmp_path: Path, monkeypatch: Patch) -> None:
    monkeypatch.setattr(growing, "DIRECT", 0)
    assert set(ways_taken(monkeypatch, {0: 1.0}, 10, tmp_path / "file")) == {0}
    assert (tmp_path / "file").read_bytes() == b"x" * 10 * BATCH


def test_a_file_system_that_refuses_the_way_gets_every_byte(tmp_path: Path, monkeypatch: Patch) -> None:
    """Part of a batch may be written before the refusal."""
    monkeypatch.setattr(growing, "DIRECT", 8)
    state = {"flag": 0, "refused": 0}
    monkeypatch.setattr(growing, "_divert", lambda handle, flag: state.update(flag=flag))
    plain = os.write

    def write(handle: int, data: memoryview) -> int:
        if state["flag"] and len(data) < BATCH:
            state["refused"] += 1
            raise OSError(errno.EINVAL, "no")
        return plain(handle, data[: BATCH // 4])

    monkeypatch.setattr(growing.os, "write", write)
    file = opened(tmp_path / "file")
    parts = [bytes([number]) * BATCH for number in range(8)]
    for part in parts:
        file.write(part)
    file.close()
    assert (tmp_path / "file").read_bytes() == b"".join(parts)
    assert state["refused"] == 1


def test_a_file_system_that_refuses_the_way_beforehand_gets_every_byte(
    tmp_path: Path, monkeypatch: Patch
) -> None:
    """Some refuse the flag itself, before a byte is written past memory."""
    fcntl = pytest.importorskip("fcntl")
    if not growing.DIRECT:
        pytest.skip("this system has no such flag")
    plain, refused = fcntl.fcntl, []

    def control(handle: int, command: int, argument: int = 0) -> int:
        if command == fcntl.F_SETFL and argument & growing.DIRECT:
            refused.append(argument)
            raise OSError(errno.EINVAL, "Invalid argument")
        return int(plain(handle, command, argument))

    monkeypatch.setattr(fcntl, "fcntl", control)
    file = opened(tmp_path / "file")
    parts = [bytes([number]) * BATCH for number in range(8)]
    for part in parts:
        file.write(part)
    file.close()
    assert (tmp_path / "file").read_bytes() == b"".join(parts)
    assert len(refused) == 1


@pytest.mark.parametrize("flag", [0, 8])
def test_a_full_disk_is_told_and_leaves_nothing(tmp_path: Path, monkeypatch: Patch, flag: int) -> None:
    monkeypatch.setattr(growing, "DIRECT", flag)
    monkeypatch.setattr(growing, "_divert", lambda handle, flag: None)
    path = tmp_path / "table"
    path.write_bytes(b"old")

    def full(handle: int, data: memoryview) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(RuleSheetError, match="No space left"), Replacement(str(path)) as file:
        file.write(b"x" * 100)
        monkeypatch.setattr(growing.os, "write", full)
        file.write(b"x" * BATCH)
    assert [found.read_bytes() for found in tmp_path.iterdir()] == [b"old"]


def test_the_last_bytes_may_find_the_disk_full(tmp_path: Path, monkeypatch: Patch) -> None:
    def full(handle: int, data: memoryview) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(growing.os, "write", full)
    with pytest.raises(RuleSheetError, match="No space left"), Replacement(str(tmp_path / "t")) as file:
        file.write(b"x" * 100)
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_at_the_last_bytes_leaves_nothing(tmp_path: Path, monkeypatch: Patch) -> None:
    path = tmp_path / "table"
    path.write_bytes(b"old")

    def interrupted(handle: int, data: memoryview) -> int:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), Replacement(str(path)) as file:
        file.write(b"x" * 100)
        monkeypatch.setattr(growing.os, "write", interrupted)
    assert [found.read_bytes() for found in tmp_path.iterdir()] == [b"old"]


def test_a_mode_that_cannot_be_kept_is_told_and_leaves_nothing(tmp_path: Path, monkeypatch: Patch) -> None:
    path = tmp_path / "table"
    path.write_bytes(b"old")

    def refused(target: str, mode: int) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr("solver.files.replacing.os.chmod", refused)
    with pytest.raises(RuleSheetError, match="not permitted"):
        Replacement(str(path))
    assert [found.read_bytes() for found in tmp_path.iterdir()] == [b"old"]


def test_a_folder_that_is_removed_meanwhile_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(RuleSheetError, match="No such file"), Replacement(str(folder / "table")) as file:
        file.write(b"x" * 100)
        for found in folder.iterdir():
            found.unlink()
        folder.rmdir()
