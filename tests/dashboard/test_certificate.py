"""The certificate for the network: made, kept, renewed; the user's own. On a clock that stands."""

from __future__ import annotations

import os
import ssl
from datetime import UTC, datetime, timedelta
from hashlib import sha256

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    PrivateFormat,
    load_pem_private_key,
)

from mikas.dashboard.security import certificate as module
from mikas.dashboard.security.certificate import VALID, given_certificate, own_certificate
from mikas.errors import UsageError

NOW = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)
HOSTS = ("192.168.0.7", "garage", "garage.local")


@pytest.fixture
def file(tmp_path):
    return tmp_path / "state" / "dashboard.pem"


def test_it_names_this_computer_and_lasts_as_long_as_browsers_accept(file):
    made = own_certificate(file, (*HOSTS, "Гараж", "a" * 64), NOW)
    assert made.names == ("192.168.0.7", "garage", "garage.local", "xn--80aaho2c")
    found = x509.load_pem_x509_certificate(file.read_bytes())
    assert found.not_valid_before_utc < NOW < found.not_valid_after_utc
    assert found.not_valid_after_utc - found.not_valid_before_utc == VALID <= timedelta(days=398)
    assert isinstance(found.public_key(), ec.EllipticCurvePublicKey)
    assert found.public_key().curve.name == "secp256r1"
    assert found.extensions.get_extension_for_class(x509.BasicConstraints).value.ca is False
    der = ssl.PEM_cert_to_DER_cert(found.public_bytes(Encoding.PEM).decode())
    assert made.fingerprint == sha256(der).digest().hex(":").upper()


def test_it_is_kept_until_a_month_before_its_end(file):
    made = own_certificate(file, HOSTS, NOW)
    for days in (0, 1, 300, 365):
        kept = own_certificate(file, HOSTS[::-1], NOW + timedelta(days=days))
        assert kept.fingerprint == made.fingerprint, days
    renewed = own_certificate(file, HOSTS, NOW + timedelta(days=367))
    assert renewed.fingerprint != made.fingerprint
    for now in (NOW, NOW + timedelta(days=3000)):  # a clock that was wrong; long unused
        assert own_certificate(file, HOSTS, now).fingerprint != renewed.fingerprint


def test_a_new_address_is_added_and_the_earlier_ones_stay(file, monkeypatch):
    home = own_certificate(file, HOSTS, NOW)
    garage = own_certificate(file, ("10.0.0.5", *HOSTS[1:]), NOW)
    assert garage.fingerprint != home.fingerprint
    assert set(garage.names) == {"10.0.0.5", *HOSTS}
    assert own_certificate(file, HOSTS, NOW).fingerprint == garage.fingerprint  # at home again
    monkeypatch.setattr(module, "_MOST_NAMES", 5)
    for number in range(3):
        last = own_certificate(file, (f"10.1.0.{number}",), NOW)
    assert [name for name in last.names if name.startswith("10.1.")] == [
        "10.1.0.2", "10.1.0.1", "10.1.0.0",
    ]  # fmt: skip
    assert len(last.names) == 5


def key_of(file):
    return file.read_bytes().partition(b"-----BEGIN CERT")[0]


def test_the_key_stays_until_others_could_have_read_it(file):
    own_certificate(file, HOSTS, NOW)
    key = key_of(file)
    own_certificate(file, ("10.0.0.5", *HOSTS), NOW)
    assert key_of(file) == key
    own_certificate(file, HOSTS, NOW + timedelta(days=367))
    assert key_of(file) == key
    if os.name == "posix":
        file.chmod(0o644)
        own_certificate(file, HOSTS, NOW)
        assert key_of(file) != key


def test_whatever_lies_in_its_place_is_replaced(file, tmp_path):
    made = own_certificate(file, HOSTS, NOW)
    pem = file.read_bytes()
    other = tmp_path / "other.pem"
    own_certificate(other, HOSTS, NOW)
    key, certificate = pem.split(b"-----BEGIN CERT")
    mixed = other.read_bytes().split(b"-----BEGIN CERT")[0] + b"-----BEGIN CERT" + certificate
    for damaged in (b"", b"\xff" * 100, pem[:-200], key, mixed, pem + b" " * (1 << 16)):
        file.write_bytes(damaged)
        file.chmod(0o600)
        again = own_certificate(file, HOSTS, NOW)
        assert again.names == HOSTS
        assert again.fingerprint != made.fingerprint


def test_one_that_can_not_be_kept_serves_all_the_same(tmp_path, monkeypatch, said):
    """The dashboard did not start with --lan."""
    (tmp_path / "state").touch()
    place = tmp_path / "state" / "dashboard.pem"
    made = own_certificate(place, HOSTS, NOW)
    assert made.names == HOSTS
    (sentence,) = said
    assert f"can't be kept, so the next start makes another one ({place}: " in sentence.en
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "absent"))
    with pytest.raises(UsageError, match="--no-tls"):
        own_certificate(place, HOSTS, NOW)


def test_without_the_library_the_command_that_installs_it_is_named(file, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "cryptography", None)
    with pytest.raises(UsageError, match="pip install cryptography") as failure:
        own_certificate(file, HOSTS, NOW)
    assert "--no-tls" in failure.value.advice.ru


def test_the_certificate_of_the_user_gives_its_names_or_says_why_not(file, tmp_path):
    own_certificate(file, ("mikas.example", "*.example", "::1", "10.0.0.5"), NOW)
    given = given_certificate(file, file)
    assert given.hosts(("192.168.0.7", "garage")) == (
        "10.0.0.5", "mikas.example", "192.168.0.7", "garage",
    )  # fmt: skip
    other, locked = tmp_path / "other.pem", tmp_path / "locked.pem"
    own_certificate(other, HOSTS, NOW)
    secret = load_pem_private_key(other.read_bytes(), None)
    locked.write_bytes(
        secret.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, BestAvailableEncryption(b"x"))
    )
    (tmp_path / "text").write_text("no certificate")
    for certificate, key, why in (
        (file, other, "another certificate"),
        (other, locked, "password"),
        (tmp_path / "text", other, "no certificate in PEM"),
        (file, tmp_path / "text", "none in PEM"),
        (tmp_path, other, "folder"),
    ):
        with pytest.raises(UsageError, match=f"can't be used: .*{why}") as failure:
            given_certificate(certificate, key)
        assert "PEM" in failure.value.advice.ru
