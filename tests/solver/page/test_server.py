"""The page's server: what it answers, and what it refuses."""

from __future__ import annotations

import logging
import math
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("starlette")
pytest.importorskip("httpx2")

from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect

import rulesheets
import solver
from rulesheets.files import shipped_model
from rulesheets.format import format_sheet
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source
from solver.__main__ import main
from solver.page.server import LARGEST, application

TOKEN = "token-of-the-test"
TALK = "ws://127.0.0.1:8000/talk"
ORIGIN = {"origin": "http://127.0.0.1:8000"}
CRANK = "shipped:offset_slider_crank"

LENS = (
    "variables\n  f = 50 [mm]\n  u = 200 [mm]\n  v [mm]\n  m\nrules\n  1/f = 1/u + 1/v\n  m = "
    "-v/u\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    tmp_path = tmp_path_factory.mktemp("outside")
    inside = tmp_path / "sheets"
    inside.mkdir()
    (inside / "lens.tk").write_text(LENS)
    (inside / "link.tk").symlink_to(tmp_path / "secret.tk")
    (inside / "linked").symlink_to(tmp_path)
    (tmp_path / "secret.tk").write_text("function f(x; y)\nrules\n  y = 4711*x\n")
    (tmp_path / "other.txt").write_text("4711")
    return inside


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[TestClient]:
    app = application(
        folder, TOKEN, first="lens.tk", hosts=frozenset({"127.0.0.1", "localhost"}), timeout=30.0
    )
    with TestClient(app, base_url="http://127.0.0.1:8000") as client:
        client.get(f"/?token={TOKEN}")
        yield client


@pytest.fixture(scope="module")
def tab(client: TestClient) -> Iterator[WebSocketTestSession]:
    with client.websocket_connect(TALK, headers=ORIGIN) as tab:
        yield tab


def ask(tab: WebSocketTestSession, do: str, **more: object) -> dict[str, Any]:
    tab.send_json({"id": 1, "do": do, **more})
    reply = tab.receive_json()
    assert reply.pop("id") == 1
    return dict(reply)


# --- answers ----------------------------------------------------------------------


def test_the_token_becomes_a_cookie_and_leaves_the_address(client: TestClient) -> None:
    answer = client.get(f"/?token={TOKEN}", follow_redirects=False)
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie and "samesite=strict" in cookie
    page = client.get("/")
    assert (
        page.status_code == 200 and "script-src 'self'" in page.headers["content-security-policy"]
    )


def test_a_sheet_is_opened_and_solved_as_in_python(tab: WebSocketTestSession) -> None:
    opened = ask(tab, "open", sheet=CRANK)
    assert [one["name"] for one in opened["variables"]][:3] == ["branch", "AO", "AB"]
    reply = ask(tab, "solve", inputs={"xB": 9.79, "thetaAO": None}, guesses={"thetaAO": -20})
    result = solver.solve(rulesheets.load("offset_slider_crank"), {"xB": 9.79, "thetaAO": None})
    assert {answer["thetaAO"] for answer in reply["solutions"]} == {
        one["thetaAO"] for one in result.solutions
    }
    assert reply["solutions"][0]["thetaAO"] < 0
    drawn = reply["figures"][0][0]
    assert len(drawn["places"]) == len(opened["figures"][0]["places"])


def test_frames_stay_on_the_branch_that_they_are_asked_for(tab: WebSocketTestSession) -> None:
    ask(tab, "open", sheet=CRANK)
    given = {"thetaAO": None}
    low = ask(tab, "frame", name="xB", value=9.5, inputs=given, near={"thetaAO": -35.0})["values"]
    high = ask(tab, "frame", name="xB", value=9.5, inputs=given, near={"thetaAO": 60.0})["values"]
    assert low["thetaAO"] < 0 < high["thetaAO"]
    beyond = ask(tab, "frame", name="xB", value=11.2, inputs=given, near={"thetaAO": 15.0})
    assert beyond["status"] == "infeasible" and "values" not in beyond


def test_the_slider_and_the_crank_are_handles_with_a_common_rail(tab: WebSocketTestSession) -> None:
    ask(tab, "open", sheet=CRANK)
    reply = ask(tab, "motion")
    assert {one["point"]: one["variable"] for one in reply["handles"]} == {
        "A": "thetaAO",
        "B": "xB",
    }
    low, high = ask(tab, "rail", driver="thetaAO")["rail"]["limits"]["xB"]
    assert high == pytest.approx((11**2 - 2**2) ** 0.5, rel=1e-14)
    assert low == pytest.approx((5**2 - 2**2) ** 0.5, rel=1e-14)


def test_an_output_names_the_inputs_that_may_be_taken_back_for_it(
    tab: WebSocketTestSession,
) -> None:
    ask(tab, "open", sheet=CRANK)
    assert ask(tab, "swap", name="xB")["choices"][0] == "thetaAO"
    ask(tab, "open", sheet="lens.tk")
    assert set(ask(tab, "swap", name="m")["choices"]) == {"f", "u"}


PUMP = (
    "variables\n  Q = 0.01 [m^3/s]\n  P [W -> kW]\n  T = 300 [K -> degC]\n  T2 [K -> degC]\n"
    "rules\n  P = 196200*Q\n  T2 = T + 10\n"
)


def test_values_are_read_and_shown_in_the_units_that_the_sheet_shows(
    tab: WebSocketTestSession, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "pump.tk").write_text(PUMP)
    known = {one["name"]: one for one in ask(tab, "open", sheet="pump.tk")["variables"]}
    solved = ask(tab, "solve", inputs={})["solutions"][0]
    main(["solve", str(folder / "pump.tk")])
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if "[" not in line]
    for name, unit in (("P", "kW"), ("T2", "degC")):
        factor, shift = known[name]["scale"]
        row = next(row for row in rows if name in row)
        assert known[name]["unit"] == unit and unit in row
        assert solved[name] * factor + shift == pytest.approx(
            float(row[row.index(name) + 1]), rel=1e-9
        )
    assert ask(tab, "value", name="P", text="5") == {"value": 5000.0}
    assert ask(tab, "value", name="P", text="1 hp")["value"] == pytest.approx(745.6998715822702)
    assert ask(tab, "value", name="T", text="0") == {"value": 273.15}
    assert ask(tab, "value", name="Q", text="pi/6")["value"] == pytest.approx(math.pi / 6)
    assert ask(tab, "value", name="P", text="3 kg")["wrong"][0]["code"] == "E461"
    swept = ask(tab, "sweep", name="T", start=0, stop=20, step=10, inputs={})["columns"]
    assert swept["T"] == [0, 10, 20] and swept["T2"] == pytest.approx([10, 20, 30])
    assert swept["P"] == pytest.approx([1.962] * 3)


def test_a_page_runs_no_code_of_a_sheet(tab: WebSocketTestSession, folder: Path) -> None:
    (folder / "curve.py").write_text(f"open({str(folder / 'ran')!r}, 'w')\n")
    (folder / "code.tk").write_text('use python "curve.py"\nrules\n  y = f(2)\n')
    (wrong,) = ask(tab, "open", sheet="code.tk")["wrong"]
    assert wrong["code"] == "E313" and "a page runs no code" in wrong["notes"][0]
    assert not (folder / "ran").exists()


def test_an_answer_that_no_record_settles_is_kept_for_the_next_frame(
    tab: WebSocketTestSession,
) -> None:
    """At a quarter turn a coordinate is exactly 0, which no record settles."""
    ask(tab, "open", sheet=CRANK)
    ask(tab, "warm", name="thetaAO", values=[-30.0, 40.0, 110.0, 170.0], inputs={})
    for angle in (-180, -90, 0, 90, 180):
        reply = ask(tab, "frame", name="thetaAO", value=angle, inputs={}, near={})
        expected = solver.solve(rulesheets.load("offset_slider_crank"), {"thetaAO": float(angle)})
        assert reply["values"]["xB"] == pytest.approx(expected["xB"], rel=1e-14)


def test_why_ends_in_the_formula_of_the_number(tab: WebSocketTestSession) -> None:
    ask(tab, "open", sheet=CRANK)
    lines = ask(tab, "why", name="xB")["lines"]
    assert len(lines) == 4 and "sqrt" in lines[-1]["tex"]


def test_a_sweep_has_a_row_for_every_step(tab: WebSocketTestSession) -> None:
    ask(tab, "open", sheet=CRANK)
    reply = ask(tab, "sweep", name="thetaAO", start=0, stop=360, step=5)
    assert reply["rows"] == 73 and reply["columns"]["thetaAO"][-1] == 360.0
    assert (
        "these are 36001"
        in ask(tab, "sweep", name="thetaAO", start=0, stop=360, step=0.01)["failed"]
    )


def test_a_wrong_text_is_told_with_its_line_and_the_old_sheet_stays(
    tab: WebSocketTestSession,
) -> None:
    ask(tab, "open", sheet="lens.tk")
    assert ask(tab, "edit", text="x = = 2")["wrong"][0]["code"] == "E104"
    assert ask(tab, "check", text="x = = 2")["wrong"][0]["places"][0]["line"] == 1
    assert ask(tab, "solve")["solutions"][0]["m"] == pytest.approx(-1 / 3)


def test_a_sheet_is_saved_unless_its_file_has_changed(
    tab: WebSocketTestSession, folder: Path
) -> None:
    opened = ask(tab, "open", sheet="lens.tk")
    longer = LENS + "  p = 1/f\n"
    saved = ask(tab, "save", text=longer, seen=opened["seen"])
    assert (folder / "lens.tk").read_text() == longer
    (folder / "lens.tk").write_text(LENS)
    assert "changed on disk" in ask(tab, "save", text=longer, seen=saved["seen"])["failed"]
    assert (folder / "lens.tk").read_text() == LENS


def test_a_sheet_begins_on_the_page(tmp_path: Path) -> None:
    """The one that the command names; the first Save makes its file."""
    hosts = frozenset({"127.0.0.1"})
    app = application(tmp_path, TOKEN, first="new.tk", hosts=hosts, timeout=30.0)
    with TestClient(app, base_url="http://127.0.0.1:8000") as client:
        client.get(f"/?token={TOKEN}")
        with client.websocket_connect(TALK, headers=ORIGIN) as tab:
            assert ask(tab, "sheets")["sheets"][0] == {"key": "new.tk", "name": "new.tk"}
            assert "no sheet" in ask(tab, "open", sheet="other.tk")["failed"]
            opened = ask(tab, "open", sheet="new.tk")
            assert ask(tab, "solve")["solutions"] == [{"a": 3.0, "b": 4.0, "c": 5.0}]
            assert not (tmp_path / "new.tk").exists()
            assert format_sheet(parse(Source("new.tk", opened["text"]))) == opened["text"]
            saved = ask(tab, "save", text=opened["text"], seen=opened["seen"])
            assert (tmp_path / "new.tk").read_text() == opened["text"]
            assert "changed" in ask(tab, "save", text="a = 1", seen="")["failed"]
            assert ask(tab, "open", sheet="new.tk")["seen"] == saved["seen"]


def test_a_shipped_sheet_is_not_written(tab: WebSocketTestSession) -> None:
    before = Path(shipped_model("ohms_law")).read_text()
    opened = ask(tab, "open", sheet="shipped:ohms_law")
    assert "failed" in ask(tab, "save", text="V = I", seen=opened["seen"])
    assert Path(shipped_model("ohms_law")).read_text() == before


def test_the_state_of_a_tab_is_there_for_the_next(client: TestClient) -> None:
    state = {"doc": {"inputs": {"f": 60}}}
    with client.websocket_connect(TALK, headers=ORIGIN) as tab:
        ask(tab, "open", sheet="lens.tk")
        ask(tab, "keep", state=state)
    with client.websocket_connect(TALK, headers=ORIGIN) as tab:
        assert ask(tab, "open", sheet="lens.tk")["kept"] == state


# --- what is refused ----------------------------------------------------------------


@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"},
        {"host": "127.0.0.1.evil.example:8000"},
        {"origin": "http://evil.example"},
        {"origin": "http://127.0.0.1:9999"},
        {"origin": "null"},
    ],
)
def test_strangers_get_nothing(client: TestClient, headers: dict[str, str]) -> None:
    assert client.get("/", headers=headers).status_code == 403
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect(TALK, headers={**ORIGIN, **headers}) as tab,
    ):
        tab.receive_text()


def test_a_websocket_says_where_it_comes_from(client: TestClient) -> None:
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(TALK) as tab:
        tab.receive_text()


@pytest.mark.parametrize(
    "path", ["/", "/static/page.js", "/static/../lane.py", "/?token=wrong", "/?token="]
)
def test_without_the_token_there_is_nothing(
    client: TestClient, path: str, caplog: pytest.LogCaptureFixture
) -> None:
    stranger = TestClient(client.app, base_url="http://127.0.0.1:8000")
    with caplog.at_level(logging.WARNING, "backsolve.page"):
        assert stranger.get(path).status_code == 403
    assert "refused" in caplog.text and "token=" not in caplog.text


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_nothing_is_posted(client: TestClient, method: str) -> None:
    assert client.request(method, "/").status_code in (403, 405)


@pytest.mark.parametrize(
    "path", ["/static/../lane.py", "/static/%2e%2e/lane.py", "/static/..%2flane.py", "/docs"]
)
def test_only_the_files_of_the_page_are_served(client: TestClient, path: str) -> None:
    assert client.get(path).status_code == 404


@pytest.mark.parametrize(
    "sheet",
    [
        "../secret.tk",
        "sub/../../secret.tk",
        "/etc/passwd",
        "other.txt",
        "link.tk",
        "linked/secret.tk",
        "shipped:../../secret",
        "shipped:",
        "\0.tk",
        "",
    ],
)
def test_no_sheet_outside_the_folder_is_opened(tab: WebSocketTestSession, sheet: str) -> None:
    reply = ask(tab, "open", sheet=sheet)
    assert set(reply) == {"failed"} and "4711" not in reply["failed"]


def test_a_text_uses_no_file_outside_the_folder(tab: WebSocketTestSession) -> None:
    ask(tab, "open", sheet="lens.tk")
    for path in ("../secret.tk", "../other.txt", "/etc/passwd"):
        reply = ask(tab, "edit", text=f'use "{path}"\nrules\n  call f(1; z)\n')
        assert reply["wrong"] and "4711" not in str(reply) and "root:" not in str(reply)


def test_a_long_text_is_refused_and_the_page_lives(tab: WebSocketTestSession, folder: Path) -> None:
    ask(tab, "open", sheet="lens.tk")
    long = "x = 1\n" * (LARGEST // 6 + 1)
    assert "too long" in ask(tab, "edit", text=long)["failed"]
    assert "too long" in ask(tab, "save", text=long, seen="")["failed"]
    (folder / "long.tk").write_text(long)
    assert "too long" in ask(tab, "open", sheet="long.tk")["failed"]
    assert ask(tab, "open", sheet="lens.tk")["sheet"] == "lens.tk"


@pytest.mark.parametrize(
    "text", ["[]", "{}", '{"do": "open"}', '{"do": 3}', "nonsense", "null", '{"do": "frame"}']
)
def test_nonsense_is_answered(tab: WebSocketTestSession, text: str) -> None:
    ask(tab, "open", sheet="lens.tk")
    tab.send_text(text)
    assert "failed" in tab.receive_json()
    assert ask(tab, "solve")["status"] == "solved"


def test_endless_work_is_given_up_and_the_page_lives(folder: Path) -> None:
    """Thirty unknowns in one block of products, which no method gets through in this time."""
    names = [f"x{k}" for k in range(30)]
    rules = [
        f"  {a}*{b} + sin({c}) = {k}"
        for k, (a, b, c) in enumerate(
            zip(names, names[7:] + names[:7], names[3:] + names[:3], strict=True)
        )
    ]
    (folder / "endless.tk").write_text("rules\n" + "\n".join(rules) + "\n")
    app = application(folder, TOKEN, hosts=frozenset({"127.0.0.1"}), timeout=3.0)
    with TestClient(app, base_url="http://127.0.0.1:8000") as client:
        client.get(f"/?token={TOKEN}")
        with client.websocket_connect(TALK, headers=ORIGIN) as tab:
            ask(tab, "open", sheet="endless.tk")
            reply = ask(tab, "solve")
            assert reply.get("gave_up") == 3.0 or reply["status"] == "failed"
            ask(tab, "open", sheet="lens.tk")
            assert ask(tab, "solve")["status"] == "solved"


def test_the_folder_lists_its_sheets(
    client: TestClient, tab: WebSocketTestSession, folder: Path
) -> None:
    shutil.copy(folder / "lens.tk", folder / "another.tk")
    listed = [one["key"] for one in ask(tab, "sheets")["sheets"]]
    assert {"another.tk", "lens.tk", CRANK} <= {*listed} and listed[-1].startswith("shipped:")
