"""Why a port of the browser does not open, in words; the rest is tested in a browser."""

from __future__ import annotations

from types import SimpleNamespace as Its

import pytest

from mikas.browser import web_serial
from mikas.errors import NoConnection, PortFailed

GRANTED = Its(vid=0x0403, pid=0x6001, nth=1)


@pytest.mark.parametrize(
    ("refused", "error", "words"),
    [
        ("NetworkError", PortFailed, ("another tab", "другой вкладке")),
        ("NetworkError", PortFailed, ("gives no reason", "не сообщил причину")),
        ("InvalidStateError", PortFailed, ("Reload the page", "Обновите страницу")),
        ("TimeoutError", PortFailed, ("unplug it and plug it in again", "отключите адаптер")),
        ("UnknownError", PortFailed, ("the browser's words", "the browser's words")),
    ],
)
def test_a_refusal_says_what_to_do(monkeypatch, refused, error, words):
    opened = Its(refused=refused, message="the browser's words")
    serial = Its(ports=lambda: Its(promise=[GRANTED]), open=lambda *_: Its(promise=opened))
    monkeypatch.setattr(web_serial, "_chosen", lambda _, ports: ports[0])  # no URL of a desktop
    monkeypatch.setattr(web_serial, "_host", lambda: (serial, lambda promise: promise))
    with pytest.raises(NoConnection) as raised:
        web_serial.open_web_serial("webserial:0403:6001", {})
    assert type(raised.value) is error
    assert words[0] in raised.value.text.en
    assert words[1] in raised.value.text.ru
