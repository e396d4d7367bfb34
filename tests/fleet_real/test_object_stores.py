"""Stores of S3 that refuse: the sentence names the setting, and no secret; what can work works."""

from __future__ import annotations

import os
import re
import socket
import ssl
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from botocore.exceptions import ClientError

from fleet_rig import BEGAN, DAY, add_here, ask, counts, make
from mikas.errors import FleetError
from mikas.fleet.ledger import begin
from mikas.fleet.object_stores import SENTENCES, reason_of_store
from mikas.fleet.places import recordings_in
from mikas.fleet.stores import store
from s3_rig import KEY, SECRET, TOKEN, FakeS3, Refusal, Request, serving, settings

s3fs = pytest.importorskip("s3fs")
MOST = 1 << 20
SET = "s3://cars/set"
SETTING = re.compile(
    r"AWS_[A-Z_]+|HTTPS?_PROXY|addressing_style = \w+|s3:ListBucket|s3://BUCKET|console|clock|quota|repeat"
)


def given(monkeypatch, **variables: str | None) -> None:
    """Let the environment have these of a store, and no others."""
    for name in list(os.environ):
        if name.startswith("AWS_") or name.lower().endswith("_proxy"):
            monkeypatch.delenv(name)
    for name, value in variables.items():
        if value is not None:
            monkeypatch.setenv(name, value)
    s3fs.S3FileSystem.clear_instance_cache()


@pytest.fixture
def server(monkeypatch):
    with serving(FakeS3()) as fake:
        given(monkeypatch, **settings(fake.url))
        yield fake
    s3fs.S3FileSystem.clear_instance_cache()


def read() -> object:
    return store(SET).read("a/b.txt", MOST)


def write() -> object:
    return store(SET).write("a/b.txt", b"data")


def names() -> object:
    return store(SET).names("a")


def recordings() -> object:
    return list(recordings_in("s3://cars/raw"))


def failure(do: Callable[[], object]) -> str:
    """Return what the user reads, in both languages; it has no secret."""
    with pytest.raises(FleetError) as failed:
        do()
    en, ru = failed.value.text
    for text in (en, ru):
        assert not [it for it in (KEY, SECRET, TOKEN) if it in text], text
    assert re.search("[а-я]{4}", ru)
    assert SETTING.search(en), en
    assert set(re.findall(r"AWS_[A-Z_]+", en)) == set(re.findall(r"AWS_[A-Z_]+", ru))
    return en


REFUSED = [
    (403, "AccessDenied", "s3:ListBucket"),
    (403, "SignatureDoesNotMatch", "AWS_SECRET_ACCESS_KEY"),
    (403, "InvalidAccessKeyId", "AWS_ACCESS_KEY_ID"),
    (400, "ExpiredToken", "AWS_SESSION_TOKEN"),
    (403, "RequestTimeTooSkewed", "clock of this computer"),
    (400, "AuthorizationHeaderMalformed", "AWS_DEFAULT_REGION"),
    (400, "IllegalLocationConstraintException", "AWS_DEFAULT_REGION"),
    (403, "SecondLevelDomainForbidden", "addressing_style = virtual"),
    (403, "QuotaExceeded", "quota"),
    (503, "ServiceUnavailable", "AWS_MAX_ATTEMPTS"),
]


@pytest.mark.parametrize(("status", "code", "setting"), REFUSED, ids=str)
def test_what_a_store_refuses_is_named_with_the_setting(server, status, code, setting) -> None:
    words = f"The key {KEY} ({TOKEN}) is refused"
    server.rule = lambda _: Refusal(status, code, words)
    for do in (read, write, names, recordings):
        said = failure(do)
        assert setting in said
        assert f"the store answered {code}" in said


def test_a_store_that_stays_too_busy_is_named(server) -> None:
    server.rule = lambda _: Refusal(503, "SlowDown")
    assert "AWS_MAX_ATTEMPTS" in failure(write)


def test_an_address_that_is_no_store_is_named(server) -> None:
    server.rule = lambda _: Refusal(200, None)
    assert "API's address, not the console's" in failure(names)
    server.rule = lambda _: Refusal(301, "PermanentRedirect")
    assert "AWS_DEFAULT_REGION" in failure(write)


def test_a_missing_bucket_is_no_missing_file(server) -> None:
    for do in (lambda: store("s3://other/set").read("x", MOST), lambda: ask("s3://other", "FROM x"),
               lambda: list(recordings_in("s3://other/raw")),
               lambda: store("s3://other/set").write("x", b"data")):  # fmt: skip
        assert "no such bucket" in failure(do)
    assert store(SET).read("x", MOST) is None


def test_a_key_that_may_get_and_not_list_can_still_read(server) -> None:
    write()
    server.rule = lambda it: None if it.key else Refusal(403, "AccessDenied")
    assert read() == b"data"
    assert "s3:ListBucket" in failure(names)


def refuses_checksums(code: str, words: str, request: Request) -> Refusal | None:
    headers = request.headers
    asks = "x-amz-sdk-checksum-algorithm" in headers or "x-amz-trailer" in headers
    asks |= "TRAILER" in headers.get("x-amz-content-sha256", "")
    return Refusal(501 if code == "NotImplemented" else 400, code, words) if asks else None


CHECKSUMS = [
    ("NotImplemented", "A header you provided implies functionality that is not implemented"),
    ("XAmzContentSHA256Mismatch", "The provided header does not match what was computed"),
    ("InvalidArgument", "Unsupported header 'x-amz-sdk-checksum-algorithm'"),
    ("InvalidRequest", "Value for x-amz-content-sha256 header is invalid"),
    ("SignatureDoesNotMatch", "The request signature we calculated does not match"),
]


@pytest.mark.parametrize(("code", "words"), CHECKSUMS, ids=lambda it: it.partition(" ")[0])
def test_a_store_that_knows_no_newer_checksums_works(server, code, words, monkeypatch, tmp_path):
    server.rule = partial(refuses_checksums, code, words)
    write()
    part = tmp_path / "part"
    part.write_bytes(b"more" * 5000)
    store(SET).put("a/c.txt", part)
    assert read() == b"data"
    assert store(SET).contents("a", ".txt", MOST).files["c.txt"] == b"more" * 5000
    monkeypatch.setenv("AWS_REQUEST_CHECKSUM_CALCULATION", "when_supported")
    s3fs.S3FileSystem.clear_instance_cache()
    assert "AWS_REQUEST_CHECKSUM_CALCULATION=when_required" in failure(write)


def of_region(wanted: str, more: str, request: Request) -> Refusal | None:
    is_right = f"/{wanted}/s3/" in request.headers.get("authorization", "")
    return None if is_right else Refusal(400, "AuthorizationHeaderMalformed", more=more)


def test_the_region_is_taken_from_the_answer_or_the_environment(server, monkeypatch) -> None:
    server.rule = partial(of_region, "ru-1", "<Region>ru-1</Region>")
    write()
    server.rule = partial(of_region, "ru-2", "")
    assert "AWS_DEFAULT_REGION" in failure(write)
    for name in ("AWS_DEFAULT_REGION", "AWS_REGION"):
        given(monkeypatch, **settings(server.url), **{name: "ru-2"})
        write()


def test_a_bucket_stands_in_the_path_or_in_the_hosts_name_as_the_user_says(
    server, monkeypatch, tmp_path
) -> None:
    write()
    assert {(it.host, it.bucket) for it in server.requests} == {(server.url[7:], "cars")}
    config = tmp_path / "config"
    config.write_text("[default]\ns3 =\n    addressing_style = virtual\n")
    port = server.server_address[1]
    ours = settings(f"http://store.invalid:{port}") | {"AWS_CONFIG_FILE": str(config)}
    given(monkeypatch, **ours)
    assert "addressing_style = path" in failure(write)
    given(monkeypatch, **ours, http_proxy=server.url)  # which finds the host
    server.wants_virtual_host = True
    write()
    assert server.requests[-1].host == f"cars.store.invalid:{port}"


def certified(folder: Path) -> Path:
    """Make a certificate that no authority has signed, for `localhost`."""
    file = folder / "store.pem"
    made = [sys.executable, "-c", _CERTIFICATE, str(file)]
    subprocess.run(made, check=True)
    return file


_CERTIFICATE = """
import sys
from datetime import datetime, timedelta
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
key = ec.generate_private_key(ec.SECP256R1())
name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "localhost")])
builder = x509.CertificateBuilder().subject_name(name).issuer_name(name)
builder = builder.public_key(key.public_key()).serial_number(1)
builder = builder.not_valid_before(datetime(2020, 1, 1)).not_valid_after(datetime(2090, 1, 1))
names = x509.SubjectAlternativeName([x509.DNSName("localhost")])
made = builder.add_extension(names, critical=False).sign(key, hashes.SHA256())
private = key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8,
                            serialization.NoEncryption())
open(sys.argv[1], "wb").write(private + made.public_bytes(serialization.Encoding.PEM))
"""


def test_a_certificate_without_an_authority_needs_its_file(server, monkeypatch, tmp_path) -> None:
    file = certified(tmp_path)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(file)
    server.socket = context.wrap_socket(server.socket, server_side=True)
    url = server.url.replace("http://127.0.0.1", "https://localhost")
    given(monkeypatch, **settings(url))
    assert "AWS_CA_BUNDLE" in failure(write)
    given(monkeypatch, **settings(url), AWS_CA_BUNDLE=str(tmp_path / "nothing.pem"))
    assert "no file of certificates" in failure(write)
    given(monkeypatch, **settings(url), AWS_CA_BUNDLE=str(file))
    write()
    given(monkeypatch, **settings(server.url))
    assert "https:// in AWS_ENDPOINT_URL" in failure(write)


def test_what_fails_before_an_answer_is_named_with_the_setting(
    server, monkeypatch, tmp_path
) -> None:
    with socket.socket() as closed:  # bound, and does not listen
        closed.bind(("127.0.0.1", 0))
        nothing = f"http://127.0.0.1:{closed.getsockname()[1]}"
        bad = tmp_path / "config"
        bad.write_text("no section\n")
        for setting, changed in (
            ("http:// in AWS_ENDPOINT_URL", {"AWS_ENDPOINT_URL": f"https{server.url[4:]}"}),
            ("host is not known: correct AWS_ENDPOINT_URL",
             {"AWS_ENDPOINT_URL": "http://nothing.invalid"}),
            ("host and port in AWS_ENDPOINT_URL", {"AWS_ENDPOINT_URL": nothing}),
            ("write https://HOST", {"AWS_ENDPOINT_URL": "127.0.0.1:9000"}),
            ("HTTP_PROXY", {"http_proxy": nothing, "AWS_ENDPOINT_URL": "http://store.invalid"}),
            ("set AWS_ACCESS_KEY_ID",
             {"AWS_ACCESS_KEY_ID": None, "AWS_SECRET_ACCESS_KEY": None}),
            ("set AWS_ACCESS_KEY_ID", {"AWS_SECRET_ACCESS_KEY": None}),
            ("AWS_PROFILE", {"AWS_PROFILE": "nothing"}),
            ("AWS_PROFILE", {"AWS_CONFIG_FILE": str(bad)}),
            ("AWS_DEFAULT_REGION", {"AWS_DEFAULT_REGION": "no region!"}),
        ):  # fmt: skip
            given(monkeypatch, **{**settings(server.url), **changed})
            assert setting in failure(write), changed
    given(monkeypatch, **settings(server.url))
    assert "s3://BUCKET/FOLDER" in failure(lambda: store("s3://Ca rs/set").write("x", b"data"))


def test_a_proxy_that_refuses_is_named(server, monkeypatch) -> None:
    server.rule = lambda _: Refusal(407, None)
    for scheme in ("http", "https"):
        given(monkeypatch, **settings(f"{scheme}://store.invalid"),
              **{f"{scheme}_proxy": server.url})  # fmt: skip
        assert "NO_PROXY" in failure(write)


def test_words_of_a_store_show_no_key_of_a_file(server, monkeypatch, tmp_path) -> None:
    file = tmp_path / "credentials"
    file.write_text(
        f"[default]\naws_access_key_id = {KEY}\naws_secret_access_key = {SECRET}\n"
        f"aws_session_token = {TOKEN}\n"
    )
    ours = settings(server.url) | {"AWS_SHARED_CREDENTIALS_FILE": str(file)}
    given(monkeypatch, **ours | {"AWS_ACCESS_KEY_ID": None, "AWS_SECRET_ACCESS_KEY": None})
    server.rule = lambda _: Refusal(418, "Odd", f"repeat with {KEY} {SECRET} {TOKEN}")
    for do in (read, write, names, recordings):
        assert "(the store answered Odd)" in failure(do)


def test_each_row_of_the_table_is_said_in_both_languages() -> None:
    for code, sentence in SENTENCES.items():
        assert SETTING.search(sentence.en) or "store" in sentence.en, code
        assert re.search("[а-я]{4}", sentence.ru), code
        settings_of = [set(re.findall(r"[A-Z]{3,}_[A-Z_]+", text)) for text in sentence]
        assert settings_of[0] == settings_of[1], code
        if re.fullmatch("[A-Z][A-Za-z]+|[0-9]+", code):
            answer = {"Error": {"Code": code, "Message": "words"}}
            error = OSError("words")
            error.__cause__ = ClientError(answer, "PutObject")
            said = reason_of_store(error)
            assert said is not None
            assert said.en == f"{sentence.en} (the store answered {code})"


def test_a_store_that_lists_late_loses_nothing_that_was_written(server, tmp_path) -> None:
    """The entries of a run were forgotten when the ledger was read again."""
    server.listed = set()  # nothing new is listed
    for number in range(2):
        make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + number * DAY)
    assert counts(add_here(tmp_path / "in", to=SET)) == (2, 0, 0, 0)
    assert counts(add_here(tmp_path / "in", to=SET)) == (0, 0, 2, 0)
    server.listed = None
    assert ask(SET, "SELECT count(*), count(DISTINCT drive) FROM samples") == [(2 * 239, 2)]
    ledger, entries = begin(store(SET)), {}
    server.listed = set()
    for entry in list(ledger.entries.values()):
        ledger.commit(entry)
        entries[entry.key] = entry
        ledger.refresh()
        assert ledger.entries == entries
