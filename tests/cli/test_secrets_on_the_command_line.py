"""No command says a part of a password or of a signature in an address."""

from __future__ import annotations

import json

import pytest


@pytest.mark.parametrize(
    "arguments",
    [
        ("fleet", "sql", "{place}", "SELECT 1"),
        ("fleet", "report", "{place}"),
        ("fleet", "add", "{place}", "--to", "set"),
        ("fleet", "add", ".", "--to", "{place}"),
        ("fleet", "add", ".", "--to", "set", "--executor", "{place}"),
        ("info", "--port", "{place}"),
        ("log", "--port", "{place}", "-o", "x.pcapng"),
        ("doctor", "--port", "{place}"),
        ("publish", "{place}", "--port", "sim:"),
    ],
)
@pytest.mark.parametrize(
    "place",
    [
        "ftp://me:zq0000001/zq0000002@127.0.0.1:9/x",
        "ftp://me:zq0000001@zq0000002@127.0.0.1:9/x",
        "http://127.0.0.1:9/x.pcapng?X-Amz-Signature=zq0000001#zq0000002",
        "socket://me:zq0000001#zq0000002@127.0.0.1:9",
        "mqtt://me:zq0000001%zq0000002@127.0.0.1:9",
    ],
)
def test_a_command_says_no_part_of_it(mikas, arguments, place) -> None:
    for more in ((), ("--json",), ("-v",), ("--lang", "ru")):
        ran = mikas(*(it.format(place=place) for it in arguments), *more)
        assert ran.status
        assert "zq000" not in ran.out + ran.err
        if "--json" in more and ran.out:
            json.loads(ran.out.splitlines()[-1])
