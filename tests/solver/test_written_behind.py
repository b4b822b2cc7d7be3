"""Bytes that a thread of its own writes: in order, all of them, and a failure is told."""

from __future__ import annotations

import threading
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rulesheets.diagnosis import RuleSheetError, error
from solver.files import behind, parquet
from solver.files.behind import WriteBehind
from solver.files.columns import Columns
from solver.files.replacing import Replacement
from solver.files.tables import table_file


@settings(max_examples=30)
@given(st.lists(st.binary(max_size=60), max_size=30), st.integers(1, 100))
def test_bytes_come_in_order(
    tmp_path_factory: pytest.TempPathFactory, parts: list[bytes], batch: int
) -> None:
    path = tmp_path_factory.mktemp("files") / "file"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(behind, "BATCH", batch)
        with Replacement(str(path)) as file:
            writer = WriteBehind(file)
            for part in parts:
                writer.write(part)
            writer.finish()
    assert path.read_bytes() == b"".join(parts)


def test_a_failure_is_raised_and_the_thread_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(Replacement):
        def write(self, data: bytes) -> None:
            raise RuleSheetError(error("E416", "no space"))

    monkeypatch.setattr(behind, "BATCH", 1)
    file = Full(str(tmp_path / "file"))
    writer = WriteBehind(file)
    with pytest.raises(RuleSheetError, match="no space"):
        for _ in range(2 * behind.AHEAD + 3):  # more than may wait: the writer never blocks for good
            writer.write(b"x")
        writer.finish()
    writer.end()
    file.discard()
    assert not [thread for thread in threading.enumerate() if thread.name == "writing"]
    assert list(tmp_path.iterdir()) == []


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(1, 5000), max_size=8), st.booleans())
def test_a_parquet_file_does_not_tell_in_which_pieces_its_rows_came(
    tmp_path_factory: pytest.TempPathFactory, cuts: list[int], gaps: bool
) -> None:
    reader = pytest.importorskip("pyarrow.parquet")
    count, folder = 5000, tmp_path_factory.mktemp("files")
    places = np.arange(count)
    x = np.sqrt(places + 0.5)
    if gaps:
        x[1000:1100] = np.nan
    values = {"x": x, "outer": places // 1000 + 0.5, "answer": (places % 3).astype(np.int32)}
    values["kind"] = np.array([("open", "crossed", None)[k % 3] for k in places], dtype=object)
    table = Columns(values, (places % 7 == 0).astype(np.int8), ("solved", "partial"))
    written = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parquet, "ROW_GROUP", 1024)
        for number, ends in enumerate(([count], sorted({*cuts, count}))):
            path = folder / f"{number}.parquet"
            file = table_file(str(path), tuple(values), {"kind"})
            for first, last in pairwise([0, *ends]):
                file.add(table.rows(first, last))
            file.close()
            written.append(path.read_bytes())
    assert written[0] == written[1]
    footer = reader.ParquetFile(folder / "0.parquet").metadata
    assert [footer.row_group(k).num_rows for k in range(footer.num_row_groups)] == [1024] * 4 + [904]
    found = reader.read_table(folder / "0.parquet").to_pydict()
    assert found["x"] == [None if number != number else number for number in x.tolist()]
    assert found["kind"] == values["kind"].tolist()
    assert found["outer"] == values["outer"].tolist() and found["answer"] == values["answer"].tolist()
    assert found["status"] == [table.words[code] for code in table.status]
