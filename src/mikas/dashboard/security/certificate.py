"""The certificate with which the dashboard is served in the network (TLS): its own, or the user's.

Its own one is self-signed (P-256), for the names and addresses of this computer. It is kept with
its key in one file that only its owner can read, so that a browser which has accepted it once does
so at the next start, too. A new one is made before it expires, when this computer has an address
that is not in it (the earlier ones stay), and when others could have read the key; the key is new
in the last case only.
"""

from __future__ import annotations

import errno
import hashlib
import ipaddress
import os
import ssl
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

from mikas import unkept
from mikas.errors import (
    MikasError,
    UnfitFile,
    UsageError,
    reason_of,
)
from mikas.files import read_regular
from mikas.i18n import Text
from mikas.saving import save

if TYPE_CHECKING:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric import ec

VALID: Final = timedelta(days=397)  # the longest that browsers accept
_RENEWED: Final = timedelta(days=30)  # before the end
_CLOCKS: Final = timedelta(days=1)  # by which a phone's clock may be late
_MOST_NAMES: Final = 24
_LARGEST: Final = 1 << 16  # bytes of a file

PLAIN_ADVICE: Final = Text(
    "Give your own with --tls-cert and --tls-key, or serve without encryption with --no-tls.",
    "Укажите свой ключами --tls-cert и --tls-key или откажитесь от шифрования ключом --no-tls.",
)
_UNKEPT: Final = Text(
    "The certificate can't be kept, so the next start makes another one ({place}: {why}).",
    "Сертификат не сохранить, при следующем запуске будет новый ({place}: {why}).",
)


@dataclass(frozen=True, slots=True)
class Certificate:
    """`context`: with the certificate and its key. `names`: the hosts that it is for."""

    context: ssl.SSLContext
    fingerprint: str
    """SHA-256, upper-case hex in pairs with colons, as browsers show it."""
    names: tuple[str, ...]
    is_own: bool
    """Made by mikas."""

    def hosts(self, here: Sequence[str]) -> tuple[str, ...]:
        """Return the names by which this computer is reached, the one for the link first.

        `here`: its own ones. Those of a user's certificate come first: browsers trust them.
        """
        named = () if self.is_own else [name for name in self.names if not {"*", ":"} & {*name}]
        return tuple(dict.fromkeys((*named, *here)))


def own_certificate(file: Path, hosts: Sequence[str], now: datetime) -> Certificate:
    """Return the certificate kept in `file`, or a new one. Raises `UsageError`.

    `hosts`: this computer's addresses and names in the network. `now`: with a time zone.
    """
    _require_library()
    kept, key, is_private = _kept(file)
    wanted = _usable(hosts)[:_MOST_NAMES]
    names = _names(kept) if kept else ()
    is_valid = kept and kept.not_valid_before_utc <= now <= kept.not_valid_after_utc - _RENEWED
    if not (is_valid and is_private and set(wanted) <= set(names)):
        names = tuple(dict.fromkeys((*wanted, *names)))[:_MOST_NAMES]
        text = _made(names, now, key if is_private else None)
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            save(file, text, private=True)
        except OSError as error:
            certificate = _for_this_run(file, text, reason_of(error))
            unkept.say_once(_UNKEPT, file, error)
            return certificate
    return _loaded(file, file, is_own=True)


def _for_this_run(file: Path, text: str, why: Text) -> Certificate:
    """Return the certificate in `text`, which could not be kept in `file`. Raises `UsageError`."""
    try:
        with TemporaryDirectory(prefix="mikas-") as folder:  # OpenSSL reads files only
            passing = Path(folder, file.name)
            save(passing, text, private=True)
            return _loaded(passing, passing, is_own=True)
    except MikasError:
        raise
    except OSError as error:
        failed = UsageError(
            problem=Text(
                f"The certificate for --lan can't be written to {file}: {why.en}",
                f"Сертификат для --lan не удаётся записать в {file}: {why.ru}",
            ),
            advice=PLAIN_ADVICE,
        )
        raise failed.caused_by(error, file) from error


def given_certificate(file: Path, key: Path) -> Certificate:
    """Return the user's certificate, both files in PEM. Raises `UsageError`."""
    _require_library()
    return _loaded(file, key, is_own=False)


def _require_library() -> None:
    try:
        import cryptography  # noqa: F401  (looked for only)
    except ImportError as error:
        raise UsageError(
            problem=Text(
                "The dashboard is encrypted in the network, which needs the package cryptography; "
                "it is not installed",
                "В сети панель шифруется, для этого нужен пакет cryptography; он не установлен",
            ),
            advice=Text(
                "Install it: pip install cryptography. Without encryption: --no-tls.",
                "Установите его: pip install cryptography. Без шифрования: --no-tls.",
            ),
        ) from error


def _loaded(file: Path, key: Path, *, is_own: bool) -> Certificate:
    from cryptography.hazmat.primitives.serialization import Encoding

    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        data, secret = (read_regular(each, _LARGEST, follow=True) for each in (file, key))
        certificate = _pair(data, secret)
        context.load_cert_chain(file, key, password="")
    except OSError as error:  # of OpenSSL's, too
        why = _reason(error)
        failed = UsageError(
            problem=Text(
                f"The certificate {file} with the key {key} can't be used: {why.en}",
                f"Сертификат {file} с ключом {key} использовать нельзя: {why.ru}",
            ),
            advice=Text(
                "Both are PEM files, the key without a password; without --tls-cert and --tls-key "
                "mikas makes a certificate itself.",
                "Нужны файлы PEM, закрытый ключ — без пароля; без --tls-cert и --tls-key "
                "сертификат сделает mikas.",
            ),
        )
        raise failed.caused_by(error, file) from error
    digest = hashlib.sha256(certificate.public_bytes(Encoding.DER)).digest()
    return Certificate(context, digest.hex(":").upper(), _names(certificate), is_own)


def _pair(data: bytes, secret: bytes) -> x509.Certificate:
    """Return the certificate in `data`. Raises `UnfitFile`, also if `secret` is not its key."""
    from cryptography import x509
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        certificate = x509.load_pem_x509_certificate(data)
        public = certificate.public_key()
    except (ValueError, UnsupportedAlgorithm) as error:
        raise _unfit(
            "the file holds no certificate in PEM", "в файле нет сертификата PEM"
        ) from error
    try:
        key = load_pem_private_key(secret, None)
    except TypeError as error:
        raise _unfit("the key has a password", "ключ защищён паролем") from error
    except (ValueError, UnsupportedAlgorithm) as error:
        raise _unfit(
            "the file of the key holds none in PEM", "в файле ключа его нет (PEM)"
        ) from error
    if key.public_key() != public:
        raise _unfit("the key is of another certificate", "ключ от другого сертификата")
    return certificate


def _unfit(en: str, ru: str) -> UnfitFile:
    return UnfitFile(errno.EINVAL, Text(en, ru))


def _reason(error: OSError) -> Text:
    if isinstance(error, ssl.SSLError):
        words = (error.reason or str(error)).replace("_", " ").lower()
        return Text(words, words)
    return reason_of(error)


def _kept(
    file: Path,
) -> tuple[x509.Certificate | None, ec.EllipticCurvePrivateKey | None, bool]:
    """Return the certificate in `file` and its key; and whether others can't read them.

    None: one of them is missing, or the key is of another kind.
    """
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        data = read_regular(file, _LARGEST)
        is_private = os.name == "nt" or not file.lstat().st_mode & 0o077
        certificate = _pair(data, data)
    except OSError:
        return None, None, False
    key = load_pem_private_key(data, None)
    return certificate, key if isinstance(key, ec.EllipticCurvePrivateKey) else None, is_private


def _usable(hosts: Iterable[str]) -> tuple[str, ...]:
    """Return the hosts that can be in a certificate, in their order: addresses, names in ASCII."""
    found = []
    for host in hosts:
        with suppress(ValueError):
            found.append(str(ipaddress.ip_address(host)))
            continue
        with suppress(UnicodeError):
            found.append(host.encode("idna").decode().lower())
    return tuple(dict.fromkeys(filter(None, found)))


def _names(certificate: x509.Certificate) -> tuple[str, ...]:
    from cryptography import x509

    try:
        found = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (x509.ExtensionNotFound, ValueError):
        return ()
    names = [name.value for name in found if isinstance(name, x509.DNSName)]
    addresses = [str(name.value) for name in found if isinstance(name, x509.IPAddress)]
    return (*addresses, *names)


def _made(
    names: Iterable[str], now: datetime, key: ec.EllipticCurvePrivateKey | None = None
) -> str:
    """Return a new certificate and its key as PEM; None: the key is new, too."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

    key = key or ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "mikas dashboard")])
    alternatives = x509.SubjectAlternativeName([_general(each) for each in names])
    now = now.astimezone(UTC).replace(microsecond=0)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - _CLOCKS)
        .not_valid_after(now - _CLOCKS + VALID)
        .add_extension(alternatives, critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    return (secret + certificate.public_bytes(Encoding.PEM)).decode()


def _general(name: str) -> x509.GeneralName:
    from cryptography import x509

    with suppress(ValueError):
        return x509.IPAddress(ipaddress.ip_address(name))
    return x509.DNSName(name)
