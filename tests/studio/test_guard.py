"""Strangers are turned away: each thing that the guard looks at, alone."""

from __future__ import annotations

import json
import os
import time

import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from subskin.errors import InvalidValueError
from subskin.studio.opening import bound
from subskin.studio.server import Keys, kept_secret


def cookie(running, value=None):
    return {"cookie": f"{running.keys.name}={value or running.keys.cookie}"}


def test_the_token_is_changed_for_a_strict_cookie_once(running):
    answer = running.get(f"/?token={running.keys.token}")
    given = answer.headers["set-cookie"]
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    assert given.startswith(f"{running.keys.name}={running.keys.cookie};")
    assert "HttpOnly" in given
    assert "SameSite=Strict" in given
    assert str(running.keys.port) in running.keys.name
    assert running.keys.token not in given
    assert running.get("/", **cookie(running)).status_code == 200


@pytest.mark.parametrize(
    "path",
    ["/", "/static/app.js", "/?token=", "/?token=wrong", "/?token=a&token=b", "/static/app.js?token=", "/socket"],
)
def test_without_token_or_cookie_nothing_is_said(running, path):
    answer = running.get(path)
    assert answer.status_code == 403
    assert "script" not in answer.text


def test_the_token_opens_the_page_alone(running):
    assert running.get(f"/static/app.js?token={running.keys.token}").status_code == 403
    assert httpx.post(f"{running.url}/?token={running.keys.token}", verify=False).status_code == 403


@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"},
        {"host": "evil.example:{port}"},
        {"host": "127.0.0.1"},
        {"host": "127.0.0.1:1"},
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "https://127.0.0.1:{port}"},
        {"cookie": "{name}=wrong"},
        {"cookie": "subskin_studio_1={cookie}"},
    ],
)
def test_foreign_hosts_origins_and_cookies_are_refused(running, headers):
    facts = {"port": running.keys.port, "name": running.keys.name, "cookie": running.keys.cookie}
    given = cookie(running) | {name: value.format(**facts) for name, value in headers.items()}
    assert running.get("/", **given).status_code == 403
    upgrade = {"connection": "Upgrade", "upgrade": "websocket", "sec-websocket-version": "13"}
    socket = {"origin": running.url, **upgrade, "sec-websocket-key": "AAAAAAAAAAAAAAAAAAAAAA==", **given}
    assert running.get("/socket", **socket).status_code == 403


def test_a_token_with_a_foreign_host_is_refused(running):
    assert running.get(f"/?token={running.keys.token}", host="evil.example").status_code == 403


def test_a_socket_without_origin_and_a_post_without_origin_are_refused(running):
    with pytest.raises(InvalidStatus, match="403"):
        running.connect(origin=None)
    assert (
        httpx.post(f"{running.url}/picture.svg", headers=cookie(running), content=b"{}", verify=False).status_code
        == 403
    )


def test_the_page_may_load_nothing_from_elsewhere(running):
    answer = running.get("/", **cookie(running))
    policy = dict(part.strip().split(" ", 1) for part in answer.headers["content-security-policy"].split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == policy["style-src"] == "'self'"
    assert policy["frame-ancestors"] == "'none'"
    assert "unsafe" not in answer.headers["content-security-policy"]
    assert set(policy["connect-src"].split()) <= {"'self'", *(f"ws://{host}" for host in running.keys.hosts)}
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_only_parts_of_the_page_are_served(running):
    for path in ("/static/../studio.py", "/static/%2e%2e/guard.py", "/static/nothing.js", "/picture.svg"):
        assert running.get(path, **cookie(running)).status_code in (404, 405)


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("x" * 300_000, 1009),
        ("no json", 1003),
        ("[]", 1003),
        ("{}", 1003),
        ('{"id": 1, "view": "finger", "do": "look", "state": NaN}', 1003),
        ('{"id": 1, "view": "finger", "do": "look", "state": 1e999}', 1003),
        ('{"id": -1, "view": "finger", "do": "look"}', 1003),
        ('{"id": true, "view": "finger", "do": "look"}', 1003),
        ('{"id": 1, "view": "finger", "do": "look", "state": ' + 60_000 * "[" + 60_000 * "]" + "}", 1003),
        (json.dumps({"id": 1, "view": "a", "do": "b", "state": list(range(5000))}), 1003),
        (b"\x00\x01", 1003),
    ],
    ids=lambda value: str(value)[:30],
)
def test_messages_of_no_page_of_ours_end_the_connection_and_not_the_server(running, asked, message, code):
    with running.connect() as socket:
        socket.send(message)
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv(10)
        assert closed.value.rcvd.code == code
    with running.connect() as socket:
        assert asked(socket, "memo", "look", state={"figure": "2"})[0]["state"]["figure"] == "2"


@pytest.mark.parametrize(
    "state",
    [
        {},
        {"text": 7},
        {"text": "[skin"},
        {"text": "", "seed": -1},
        {"text": "x", "extra": 1},
        {"text": "x", "touch": {"family": "line", "force": 1e300, "angle": 0, "position": [0], "half_width": 1}},
    ],
)
def test_a_state_that_cannot_be_is_said_in_words(running, asked, state):
    with running.connect() as socket:
        assert asked(socket, "finger", "look", state=state)[0]["error"]
        assert asked(socket, "nowhere", "look")[0]["error"]


def test_of_many_moves_the_latest_is_answered(running, asked):
    with running.connect() as socket:
        text = asked(socket, "finger", "begin")[0]["begin"]["text"]
        touch = {"family": "hertz", "force": 40.0, "angle": 0.1, "half_width": 5e-4}
        for k in range(2000):
            state = {"text": text, "touch": {**touch, "position": [1e-6 * k]}}
            socket.send(json.dumps({"id": k, "view": "finger", "do": "look", "state": state}))
        answers, last = 0, -1
        while last != 1999:
            last = asked.heard(socket)[0]["id"]
            answers += 1
        assert answers < 400
        with pytest.raises(TimeoutError):
            socket.recv(0.3)


def test_who_sends_without_end_is_let_go(running):
    def send_on(socket):
        for k in range(20_000):
            socket.send(json.dumps({"id": k, "view": "page", "do": "drawn"}))
        socket.recv(10)

    with running.connect() as socket, pytest.raises(ConnectionClosed) as closed:
        send_on(socket)
    assert closed.value.rcvd.code == 1008


def test_the_secret_is_kept_for_the_user_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path))
    first = kept_secret()
    file = tmp_path / "subskin" / "studio.key"
    assert kept_secret() == first
    assert Keys(8771, first).token == Keys(8771, kept_secret()).token != Keys(8772, first).token
    if os.name == "posix":
        assert file.stat().st_mode & 0o077 == 0
        file.chmod(0o644)  # others may have read it
        assert kept_secret() != first


def test_the_port_is_of_this_machine_alone():
    with bound(0) as one:
        host, port = one.getsockname()
        assert host == "127.0.0.1"
        one.listen()
        with pytest.raises(InvalidValueError, match="another program has it"):
            bound(port)


def test_a_page_that_goes_in_the_middle_does_no_harm(running, asked):
    for _ in range(3):
        with running.connect() as socket:
            socket.send(json.dumps({"id": 1, "view": "finger", "do": "begin"}))
    time.sleep(0.05)
    with running.connect() as one, running.connect() as other:
        for socket in (one, other):
            assert "[skin]" in asked(socket, "finger", "begin")[0]["begin"]["text"]
