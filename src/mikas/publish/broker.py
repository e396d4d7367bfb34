"""The broker: its address, the credentials, TLS. The password is in no text and no `repr`."""

from __future__ import annotations

import codecs
import os
import ssl
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final
from urllib.parse import unquote, urlsplit

from mikas import files
from mikas.cleaning import clean_line
from mikas.errors import (
    UsageError,
    unusable_file,
    usage_error,
)
from mikas.i18n import Text

USER: Final = "MIKAS_MQTT_USER"
PASSWORD: Final = "MIKAS_MQTT_PASSWORD"
_PORTS: Final = {"mqtt": 1883, "mqtts": 8883}
_LONGEST: Final = 65535  # bytes of a text: MQTT's own limit
_SIGNS: Final = Text(
    "signs like / # ? [ ] in a password are written as %2F %23 %3F %5B %5D",
    "знаки / # ? [ ] в пароле пишутся как %2F %23 %3F %5B %5D",
)
_ENCODINGS: Final = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""By the mark with which Windows' programs begin a text."""


@dataclass(frozen=True, slots=True)
class Broker:
    """The address, and who we are there. `tls`: the context of an encrypted connection."""

    host: str
    port: int
    encrypted: bool = False
    user: str | None = None
    password: str | None = field(default=None, repr=False)
    tls: ssl.SSLContext | None = field(default=None, repr=False, compare=False)

    @property
    def url(self) -> str:
        """The address for people, without the credentials."""
        scheme = "mqtts" if self.encrypted else "mqtt"
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{scheme}://{host}:{self.port}"


def parse_address(text: str) -> Broker:
    """Return the broker of `mqtt://[USER[:PASSWORD]@]HOST[:PORT]`. Raises `UsageError`."""
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError:
        raise _wrong(
            f"the port is a number up to 65535; {_SIGNS.en}", f"порт — число до 65535; {_SIGNS.ru}"
        ) from None
    if parts.scheme not in _PORTS:
        raise _wrong(
            "the address begins with mqtt://, or with mqtts:// for TLS",
            "адрес начинается с mqtt://, а с TLS — с mqtts://",
        )
    if not parts.hostname or port == 0 or clean_line(parts.netloc) != parts.netloc:
        raise _wrong("the host is missing", "нет имени компьютера")
    if parts.path.strip("/") or parts.query or parts.fragment:
        raise _wrong(
            f"nothing follows the host and the port; {_SIGNS.en}",
            f"после имени и порта ничего нет; {_SIGNS.ru}",
        )
    user, password = (unquote(it or "") or None for it in (parts.username, parts.password))
    port = port or _PORTS[parts.scheme]
    return Broker(parts.hostname, port, parts.scheme == "mqtts", user, password)


def _wrong(en: str, ru: str) -> UsageError:
    return UsageError(
        problem=Text(f"Invalid address of the broker: {en}", f"Неверный адрес брокера: {ru}"),
        advice=Text(
            "It looks like mqtt://192.168.1.10 or mqtts://broker.example:8883.",
            "Адрес пишется так: mqtt://192.168.1.10 или mqtts://broker.example:8883.",
        ),
    )


def with_credentials(
    broker: Broker,
    *,
    user: str | None = None,
    password_file: Path | None = None,
    environment: Mapping[str, str] = os.environ,
) -> Broker:
    """Return the broker with the credentials: options, then the address, then the environment.

    Raises `UsageError` for a file without a password, for a password without a user, and for texts
    that MQTT does not carry.
    """
    password = None if password_file is None else _password_of(password_file)
    named = user or broker.user or environment.get(USER) or None
    secret = password or broker.password or environment.get(PASSWORD) or None
    if secret is not None and named is None:
        raise usage_error(
            f"there is a password, and no user name: --user NAME, or {USER}",
            f"есть пароль, но нет имени: --user NAME или {USER}",
        )
    check_text(named, Text("the user name", "имя"))
    check_text(secret, Text("the password", "пароль"))
    return replace(broker, user=named, password=secret)


def check_text(text: str | None, title: Text) -> None:
    """Raise `UsageError`, without the text, if it is none that MQTT carries."""
    try:
        fits = text is None or len(text.encode()) <= _LONGEST
    except UnicodeEncodeError:
        fits = False
    if not fits:
        raise usage_error(
            f"{title.en} is no text of up to {_LONGEST} bytes (UTF-8)",
            f"{title.ru}: это не текст до {_LONGEST} байт (UTF-8)",
        )


def _password_of(file: Path) -> str:
    """Return the first line of `file`."""
    try:
        content = files.read_regular(file, 2 * _LONGEST, follow=True)
        encoding = next(
            (it for mark, it in _ENCODINGS.items() if content.startswith(mark)), "utf-8"
        )
        first, *_ = content.decode(encoding).splitlines() or [""]
    except UnicodeDecodeError:
        raise usage_error(
            f"{file}: this is no text in UTF-8", f"{file}: это не текст в UTF-8"
        ) from None  # the error has the bytes
    except OSError as error:
        raise unusable_file(file, error) from error
    if not first:
        raise usage_error(
            f"{file}: the first line is empty; the password belongs there",
            f"{file}: первая строка пуста, а в ней должен быть пароль",
        )
    return first


def with_tls(
    broker: Broker, *, ca: Path | None = None, cert: Path | None = None, key: Path | None = None
) -> Broker:
    """Return the broker with its TLS context: the system's authorities, or those in `ca`.

    `cert` and `key`: our own certificate. Raises `UsageError` for a file that does not fit.
    """
    if not broker.encrypted:
        if (ca, cert, key) != (None, None, None):
            raise usage_error(
                "--tls-ca, --tls-cert and --tls-key belong to an address with mqtts://",
                "--tls-ca, --tls-cert и --tls-key относятся к адресу с mqtts://",
            )
        return broker
    if (cert is None) != (key is None):
        raise usage_error(
            "--tls-cert and --tls-key belong together; name both files",
            "--tls-cert и --tls-key нужны вместе; укажите оба файла",
        )
    with _reading(ca, f"{ca} holds no certificate (PEM)", f"в {ca} нет сертификата (PEM)"):
        context = ssl.create_default_context(cafile=ca)
    if cert is not None and key is not None:
        with _reading(
            cert,
            f"{cert} and {key} are no certificate and its unlocked private key (PEM)",
            f"{cert} и {key} — не сертификат и незащищённый паролем ключ к нему (PEM)",
        ):
            context.load_cert_chain(cert, key, password="")
    return replace(broker, tls=context)


@contextmanager
def _reading(file: Path | None, en: str, ru: str) -> Iterator[None]:
    """Raise `UsageError` for a file that can't be read, or by `en` and `ru` for a wrong one."""
    try:
        yield
    except ssl.SSLError as error:
        raise usage_error(en, ru) from error
    except OSError as error:
        assert file is not None
        raise unusable_file(file, error) from error
