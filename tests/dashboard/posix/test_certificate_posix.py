"""The modes of the certificate's file."""

from __future__ import annotations

import os
from datetime import UTC, datetime

from cryptography.hazmat.primitives.serialization import load_pem_private_key

from mikas.dashboard.security.certificate import own_certificate

NOW = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)
HOSTS = ("192.168.0.7", "garage")


def test_its_key_is_for_its_owner_only_and_one_that_others_could_read_is_replaced(tmp_path):
    file = tmp_path / "state" / "dashboard.pem"
    before = os.umask(0)
    try:
        made = own_certificate(file, HOSTS, NOW)
    finally:
        os.umask(before)
    assert file.stat().st_mode & 0o777 == 0o600
    assert [it.name for it in file.parent.iterdir()] == ["dashboard.pem"]
    file.chmod(0o640)
    key = load_pem_private_key(file.read_bytes(), None)
    again = own_certificate(file, HOSTS, NOW)
    assert again.fingerprint != made.fingerprint
    assert load_pem_private_key(file.read_bytes(), None).public_key() != key.public_key()
    assert file.stat().st_mode & 0o777 == 0o600
