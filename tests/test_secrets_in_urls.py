"""Names, passwords and signatures in addresses: no part of them comes to any text."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mikas.cleaning import public_port, public_url, without_secrets
from mikas.errors import BadPortUrl, FleetError, MikasError
from mikas.fleet.executors import runner_of
from mikas.fleet.places import file_system, shown
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.link.urls import open_link
from mikas.publish.broker import parse_address

SIGNS = "@/#?:%&;=+ ![]$"
WORDS = st.integers(0, 10**6).map("zq{:07}".format)
PASSWORDS = st.lists(st.tuples(WORDS, st.sampled_from(["", *SIGNS])), min_size=1, max_size=4)
PLACES = ("s3", "sftp", "ftp", "https", "webdav", "dask", "zip://in::ftp", "nothing")
PORTS = ("socket", "rfc2217", "sockt", "http", "own")


def words_of(pieces: list[tuple[str, str]]) -> list[str]:
    return [word for word, _ in pieces]


def texts_of(error: MikasError) -> str:
    given = [str(error), error.reason, error.advice, error.text, error.args, error.fields]
    return repr(given) + repr(getattr(error, "problem", "")) + repr(getattr(error, "place", ""))


@settings(max_examples=25)
@given(PASSWORDS, st.sampled_from(PLACES), WORDS)
def test_no_part_of_a_password_is_in_what_is_shown_of_a_place(pieces, scheme, signature) -> None:
    password = "".join(word + sign for word, sign in pieces)
    query = f"X-Amz-Credential={signature}%2F2026&X-Amz-Signature={signature}&n=1#{signature}"
    for place in (
        f"{scheme}://me:{password}@host/cars", f"{scheme}://me:{password}@host:21/cars?{query}",
        f"{scheme}://:{password}@host", f"{scheme}://host/in.pcapng?{query}",
        f"{scheme}://host:9/in.pcapng#{signature}",
    ):  # fmt: skip
        said = Text(f"no answer from {place}", f"нет ответа: {place[2:]}")
        for text in (public_url(place), shown(place), texts_of(FleetError(place, said))):
            assert not [word for word in (*words_of(pieces), signature) if word in text], text
        assert public_url(public_url(place)) == public_url(place)


@settings(max_examples=25)
@example([("zq0000000", "?"), ("zq0000000", "")], "socket", "zq0000001")
@example([("zq0000000", "?"), ("zq0000001", "&"), ("zq0000002", "+")], "socket", "zq0000003")
@given(PASSWORDS, st.sampled_from(PORTS), WORDS)
def test_no_part_of_a_password_is_in_what_is_said_of_a_port(pieces, scheme, token) -> None:
    password = "".join(word + sign for word, sign in pieces)
    for url in (
        f"{scheme}://me:{password}@host:9", f"{scheme}:me:{password}@host:9", f"me:{password}@h:9",
        f"{scheme}://host:9?api_token={token}&baud=9600",
    ):  # fmt: skip
        problem = Text(f"what is {url}", f"это что: {url[2:]}")
        error = BadPortUrl(url=url, problem=problem)
        try:
            open_link(url)
        except MikasError as raised:
            said = texts_of(raised)
        for text in (public_port(url), texts_of(error), said):
            assert not [word for word in (*words_of(pieces), token) if word in text], text


@settings(max_examples=25)
@given(PASSWORDS)
def test_no_part_of_a_password_is_said_of_a_store_an_executor_or_a_broker(pieces) -> None:
    password = "".join(word + sign for word, sign in pieces)
    for call, address in (
        (file_system, f"nothing://me:{password}@host/x"),
        (lambda it: runner_of(it, 1), f"desk://me:{password}@host"),
        (parse_address, f"http://me:{password}@host"),
        (parse_address, f"mqtt://me:{password}@host:0"),
    ):
        with pytest.raises(MikasError) as failed:
            call(address)
        assert not [word for word in words_of(pieces) if word in texts_of(failed.value)]


@pytest.mark.parametrize(
    "plain",
    [
        "s3://bucket/a@b", "s3://bucket/a:b@c.pcapng", "/srv/a:b@c?d#e", "C:\\cars\\a@b",
        "file:///srv/a:b@c?d#e", "local:///srv/a:b@c?d#e", "local://a:b@c",
        "memory://x/y", "rec@home", "sftp://host:22/cars",
    ],
)  # fmt: skip
def test_an_address_without_a_secret_stays_as_it_is(plain) -> None:
    assert public_url(plain) == plain


@pytest.mark.parametrize(
    "plain",
    [
        "/dev/ttyUSB0?baud=10400", "COM3", "socket://[::1]:4001?baud=9600", "sim:?seed=1&lost=0.1",
        "rfc2217://host:4001", "replay:C:/a@b.pcapng?speed=2", "replay:/srv/a:b@c.pcapng",
    ],
)  # fmt: skip
def test_a_port_without_a_secret_stays_as_it_is(plain) -> None:
    assert public_port(plain) == plain
    assert without_secrets(f"{plain} is gone", port=plain) == f"{plain} is gone"


def test_a_password_with_odd_signs_is_an_error_that_says_how_to_write_them() -> None:
    with pytest.raises(FleetError, match="%2F") as failed:
        file_system("ftp://me:zq1/zq2@host/x")
    assert str(failed.value).startswith("ftp://host/x: signs like")


def test_a_recording_has_no_token_of_its_port(tmp_path) -> None:
    from mikas.recording.capture.writer import CaptureWriter

    url = "own://me:zq0000001@host:9?token=zq0000002&baud=9600"
    with CaptureWriter(tmp_path / "drive.pcapng", url=url) as writer:
        writer.record(Direction.SENT, b"\x0a", 1.0)
    assert b"own://\xe2\x80\xa6@host:9?token=" in (data := (tmp_path / "drive.pcapng").read_bytes())
    assert b"zq000" not in data


def test_options_that_have_an_at_sign_are_no_password() -> None:
    """The error about a scenario's file named another one."""
    assert public_port("sim:?scenario=/me@home/x.toml") == "sim:?scenario=/me@home/x.toml"
