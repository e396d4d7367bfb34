"""Webhooks: on this computer only, resolved once; a failure is said once and stops nothing."""

from __future__ import annotations

import http.server
import json
import queue
import socket
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.conditions.addresses import check_webhook
from mikas.conditions.webhooks import WAITING, LoopbackTarget, Webhooks, post, resolved
from mikas.errors import UsageError
from mikas.i18n import Text

pytestmark = pytest.mark.realtime

PATIENCE = 30


class Receiver:
    """A program on this computer that gets webhooks."""

    def __init__(self, status=200, location=None):
        self.got = queue.Queue()
        got = self.got

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                got.put((self.path, self.headers["Host"], json.loads(body)))
                self.send_response(status)
                if location:
                    self.send_header("Location", location)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.server = http.server.HTTPServer(("127.0.0.1", 0), Handler)
        self.port = self.server.server_address[1]
        self._thread = threading.Thread(target=self.server.serve_forever, args=(0.05,))
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self._thread.join()
        self.server.server_close()


@pytest.mark.parametrize(
    "url",
    ["https://localhost/", "http://", "http:///x", "http://localhost:0/", "http://localhost:99999/",
     "http://me:secret@localhost/", "http://8.8.8.8/", "http://0.0.0.0/", "http://[::]/",
     "http://192.168.1.1/", "http://[::ffff:8.8.8.8]/", "ftp://localhost/", "localhost:80",
     "http://localhost/#x", "http://localhost/a b", "http://localhost/\n", "http://пример/", "",
     "http://[::1/", f"http://localhost/{'x' * 500}"],
)  # fmt: skip
def test_what_is_no_address_on_this_computer_is_refused(url):
    with pytest.raises(UsageError) as caught:
        check_webhook(url)
    assert caught.value.text.ru != caught.value.text.en


@pytest.mark.parametrize(
    "url", ["http://localhost/", "http://127.0.0.1:1880/a?b=c", "http://[::1]:8080", "http://127.9.9.9/"]
)  # fmt: skip
def test_what_is_one_is_taken(url):
    assert check_webhook(url).scheme == "http"


def test_a_name_that_is_not_this_computer_alone_is_refused():
    for found in (["10.0.0.1"], ["127.0.0.1", "10.0.0.1"], ["::1", "2001:db8::1"], []):
        with pytest.raises(UsageError, match="not this computer"):
            resolved("http://garage/", lambda host, port, found=found: found)


def test_a_name_is_asked_once_and_its_address_kept():
    asked = []

    def addresses(host, port):
        asked.append((host, port))
        return ["127.0.0.1"]

    target = resolved("http://node-red:1880/hot?x=1", addresses)
    assert target == LoopbackTarget(
        "http://node-red:1880/hot?x=1", ("127.0.0.1",), 1880, "node-red:1880", "/hot?x=1"
    )
    assert asked == [("node-red", 1880)]


def test_a_name_that_is_not_found_says_so():
    def unknown(host, port):
        raise socket.gaierror(-2, "Name or service not known")

    with pytest.raises(UsageError, match="garage is not found"):
        resolved("http://garage/", unknown)


def test_it_is_posted_as_json_in_order():
    with Receiver() as receiver:
        url, failures = f"http://localhost:{receiver.port}/hot", []
        hooks = Webhooks([url], failures.append)
        for at in range(3):
            hooks.send(url, json.dumps({"n": at}).encode())
        got = [receiver.got.get(timeout=PATIENCE) for _ in range(3)]
        hooks.close()
    assert got == [("/hot", f"localhost:{receiver.port}", {"n": at}) for at in range(3)]
    assert failures == []


def test_a_program_at_one_address_of_the_name_is_found():
    """localhost is ::1 first on most computers, where a program at 127.0.0.1 is not."""
    with Receiver() as receiver:
        url = f"http://localhost:{receiver.port}/hot"
        target = resolved(url, lambda host, port: ["::1", "127.0.0.1", "127.0.0.1"])
        assert target.addresses == ("::1", "127.0.0.1")
        assert post(target, b"{}") is None
        assert receiver.got.get(timeout=PATIENCE) == ("/hot", f"localhost:{receiver.port}", {})
        assert receiver.got.empty()


def test_a_redirect_is_not_followed():
    with Receiver() as there, Receiver(307, f"http://127.0.0.1:{there.port}/moved") as receiver:
        target = resolved(f"http://127.0.0.1:{receiver.port}/")
        assert "307" in post(target, b"{}").en
        assert there.got.empty()


def test_a_failure_that_lasts_is_said_once_and_again_after_a_success():
    said = queue.Queue()
    with Receiver(500) as receiver:
        url = f"http://127.0.0.1:{receiver.port}/"
        hooks = Webhooks([url], said.put)
        for _ in range(3):
            hooks.send(url, b"{}")
        for _ in range(3):
            receiver.got.get(timeout=PATIENCE)
        assert "500" in said.get(timeout=PATIENCE).en
        hooks.close()
    assert said.empty()


def test_nobody_there_is_a_sentence_that_says_what_to_do():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        target = resolved(f"http://127.0.0.1:{free.getsockname()[1]}/")
        failure = post(target, b"{}")
    assert "Is the program that gets it running?" in failure.en
    assert "Запущена ли программа" in failure.ru


def test_another_program_than_a_web_server_is_a_failure():
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()

        def answer():
            connection, _ = server.accept()
            with connection:
                connection.recv(1)
                connection.sendall(b"SSH-2.0-OpenSSH\r\n" * 9000)

        thread = threading.Thread(target=answer)
        thread.start()
        failure = post(resolved(f"http://127.0.0.1:{server.getsockname()[1]}/"), b"{}")
        thread.join(PATIENCE)
    assert failure is not None


def test_a_slow_program_gets_no_more_than_so_many(monkeypatch):
    hold, failures = threading.Event(), []

    def wait(target, body):
        hold.wait(PATIENCE)

    monkeypatch.setattr("mikas.conditions.webhooks.post", wait)
    hooks = Webhooks(["http://127.0.0.1:9/"], failures.append)
    for _ in range(WAITING + 5):
        hooks.send("http://127.0.0.1:9/", b"{}")
    assert ["too slow" in it.en for it in failures] == [True]
    hold.set()
    hooks.close()


@pytest.mark.parametrize("answer", [None, Text("no answer", "нет ответа")])
def test_a_slow_program_is_said_once_though_some_requests_are_done(monkeypatch, answer):
    """Else each one that is done or fails, and the next one without room, would be said in turn."""
    ready, failures = threading.Semaphore(0), []
    done = threading.Semaphore(0)

    def wait(target, body):
        done.release()
        assert ready.acquire(timeout=PATIENCE)
        return answer

    monkeypatch.setattr("mikas.conditions.webhooks.post", wait)
    hooks = Webhooks(["http://127.0.0.1:9/"], failures.append)
    for _ in range(5):
        for _ in range(WAITING + 2):  # one of them is being sent
            hooks.send("http://127.0.0.1:9/", b"{}")
        assert done.acquire(timeout=PATIENCE)
        ready.release()
    assert done.acquire(timeout=PATIENCE)
    assert len(failures) == (1 if answer is None else 2)
    for _ in range(10 * WAITING):
        ready.release()
    hooks.close()


@given(st.text(max_size=60))
def test_no_text_breaks_the_check(text):
    for url in (text, f"http://{text}", f"http://localhost{text}"):
        try:
            parts = check_webhook(url)
        except UsageError:
            continue
        assert parts.scheme == "http"
