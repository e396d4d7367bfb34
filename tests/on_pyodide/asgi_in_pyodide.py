"""`mikas.browser.asgi`: what the page is told when requests and WebSockets go well, or do not."""

from __future__ import annotations

import asyncio
import threading
from queue import SimpleQueue

import httpx
import pytest
from fastapi import FastAPI, Request, WebSocket
from fastapi.responses import Response, StreamingResponse
from websockets.exceptions import ConnectionClosed

from dashboard.page_rig import PageEnd, Socket, Transport, running

LONG = 60


@pytest.fixture
def seen():
    """What the routes report."""
    return SimpleQueue()


@pytest.fixture
def app(seen):
    app = FastAPI()

    @app.api_route("/echo", methods=["GET", "PUT", "POST"])
    async def echo(request: Request):
        return {
            "method": request.method,
            "path": request.url.path,
            "query": request.query_params.multi_items(),
            "headers": request.headers.items(),
            "client": request.client.host,
            "body": (await request.body()).hex(),
        }

    @app.get("/ends/{path:path}")
    def of_path(path: str):
        return {"path": path}

    @app.get("/empty")
    def empty():
        return Response(status_code=204, headers={"X-Some": "é"})

    @app.get("/bug")
    async def bug():
        raise ValueError("the bug of this test")

    @app.get("/half")
    async def half():
        async def parts():
            yield b"begin"
            raise ValueError("the bug of this test")

        return StreamingResponse(parts())

    @app.get("/parts")
    async def parts(count: int):
        async def each():
            try:
                for number in range(count):
                    yield bytes([number % 256]) * 10
                if not count:
                    yield b"first"
                    await asyncio.Event().wait()
            finally:
                seen.put("ended")

        return StreamingResponse(each())

    @app.get("/held")
    async def held(request: Request):
        seen.put("asked")
        while not await request.is_disconnected():
            await asyncio.sleep(0)
        seen.put("gone")

    @app.websocket("/talk")
    async def talk(socket: WebSocket, how: str):
        if how == "refused":
            return await socket.close(1008)
        if how == "denied":
            return await socket.send_denial_response(Response("no", 403))
        await socket.accept()
        if how == "bug":
            raise ValueError("the bug of this test")
        if how == "ended":
            return await socket.close(4001, "enough")
        async for text in socket.iter_text():
            if how == "bytes":
                await socket.send_bytes(text.upper().encode())
            else:
                await socket.send_text(text.upper())
        seen.put("left")
        return None

    return app


@pytest.fixture
def end():
    return PageEnd()


@pytest.fixture
def server(app, end):
    with running(app, end) as server:
        yield server


@pytest.fixture
def client(server, end):
    with httpx.Client(base_url="http://localhost", transport=Transport(server, end)) as client:
        client.timeout = LONG
        yield client


def test_a_request_comes_as_the_page_sent_it(client):
    body = bytes(range(256)) * 300
    answer = client.put(
        "/echo?a=1&a=%D0%B6&b=",
        content=body,
        headers=[("X-Two", "a"), ("X-Two", "b")],
    ).json()
    assert (answer["method"], answer["path"], answer["client"]) == ("PUT", "/echo", "127.0.0.1")
    assert answer["query"] == [["a", "1"], ["a", "ж"], ["b", ""]]
    assert bytes.fromhex(answer["body"]) == body
    headers = [tuple(each) for each in answer["headers"]]
    assert ("host", "localhost") in headers
    assert ("content-length", str(len(body))) in headers
    assert [value for name, value in headers if name == "x-two"] == ["a", "b"]


def test_a_request_without_a_body_has_an_empty_one(client):
    answer = client.get("/echo").json()
    assert answer["body"] == ""
    assert "content-length" not in dict(answer["headers"])
    assert client.post("/echo").json()["method"] == "POST"


def test_a_path_is_decoded_once(client):
    assert client.get("/ends/a%2Fb%2525%20%D0%B6.csv").json() == {"path": "a/b%25 ж.csv"}
    assert client.get("/nowhere").status_code == 404
    assert client.put("/empty").status_code == 405


def test_an_answer_may_be_empty(client):
    answer = client.get("/empty")
    assert (answer.status_code, answer.content, answer.headers["x-some"]) == (204, b"", "é")


def test_an_answer_comes_in_parts(client, seen):
    answer = client.get("/parts?count=500").content
    assert answer == b"".join(bytes([number % 256]) * 10 for number in range(500))
    assert seen.get() == "ended"


def test_many_are_answered_at_once(client):
    answers = {}

    def ask(number):
        answers[number] = client.post("/echo", content=bytes([number])).json()["body"]

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(30)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == {number: f"{number:02x}" for number in range(30)}


def test_an_aborted_answer_ends_while_it_waits(client, seen):
    with client.stream("GET", "/parts?count=0") as answer:
        assert next(answer.iter_raw()) == b"first"
        assert seen.empty()
    assert seen.get(timeout=LONG) == "ended"


def test_a_request_is_aborted_before_its_answer(server, end, seen):
    number, answers = end.begin()
    request = {"kind": "request", "method": "GET", "path": "/held", "headers": [], "body": None}
    server.receive_message({**request, "id": number})
    assert seen.get(timeout=LONG) == "asked"
    server.receive_message({"kind": "abort", "id": number})
    assert seen.get(timeout=LONG) == "gone"
    assert answers.get(timeout=LONG)[0] in ("head", "failed")  # which nobody wants any more


def test_what_comes_for_something_that_is_over_is_ignored(server, client):
    for kind in ("abort", "send", "close"):
        server.receive_message({"kind": kind, "id": 10_000, "data": "x", "code": 1000})
    assert client.get("/empty").status_code == 204


def test_a_bug_in_a_route_is_told_and_ends_nothing_else(client):
    answer = client.get("/bug")
    assert answer.status_code == 500
    assert client.get("/empty").status_code == 204


def test_a_bug_amid_an_answer_fails_it(client):
    with client.stream("GET", "/half") as answer:
        parts = answer.iter_raw()
        assert next(parts) == b"begin"
        with pytest.raises(httpx.RemoteProtocolError, match="the bug of this test"):
            next(parts)
    assert client.get("/empty").status_code == 204


def talk(server, end, how):
    return Socket(server, end, f"/talk?how={how}")


@pytest.mark.parametrize("how", ["text", "bytes"])
def test_a_talk_answers_each_message_and_notices_its_end(server, end, seen, how):
    with talk(server, end, how) as socket:
        for text in ("a", "ж" * 100_000, "\U0001f697"):
            socket.send(text)
            assert socket.recv(LONG) == text.upper()
        with pytest.raises(TimeoutError):
            socket.recv(0.001)
    assert seen.get(timeout=LONG) == "left"


def test_an_empty_message_is_a_message(server, end):
    with talk(server, end, "text") as socket:
        socket.send("")
        assert socket.recv(LONG) == ""


def test_many_talk_at_once(server, end):
    sockets = [talk(server, end, "text") for _ in range(20)]
    for number, socket in enumerate(sockets):
        socket.send(f"a{number}")
    for number, socket in enumerate(sockets):
        assert socket.recv(LONG) == f"A{number}"
        socket.close()


@pytest.mark.parametrize("how", ["refused", "denied"])
def test_a_talk_is_refused(server, end, how):
    with pytest.raises(ConnectionClosed) as refused:
        talk(server, end, how)
    assert refused.value.rcvd.code == 1008


def test_the_application_may_end_a_talk(server, end):
    with talk(server, end, "ended") as socket, pytest.raises(ConnectionClosed) as ended:
        socket.recv(LONG)
    assert (ended.value.rcvd.code, ended.value.rcvd.reason) == (4001, "enough")


def test_a_bug_ends_a_talk(server, end, client):
    with talk(server, end, "bug") as socket, pytest.raises(ConnectionClosed) as ended:
        socket.recv(LONG)
    assert ended.value.rcvd.code == 1011
    assert "the bug of this test" in ended.value.rcvd.reason
    assert client.get("/empty").status_code == 204
