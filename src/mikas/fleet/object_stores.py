"""What an object store (S3 and the like) answers when it refuses, and the setting that helps.

`SENTENCES` has a row for each code of a store, each bare status of HTTP, and each way in which its
client fails before there is an answer. Settings are named as the user writes them: variables of the
environment, or a line of ~/.aws/config. Of a store's own words the code is shown, and the message
only with a code that has no row: it may repeat a key. The client's libraries are not imported here.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from configparser import ConfigParser, Error
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final
from urllib.parse import urlsplit

from mikas.cleaning import clean_line
from mikas.i18n import Text

PROTOCOLS: Final = ("s3", "s3a")
_CHECKSUMS: Final = {
    "AWS_REQUEST_CHECKSUM_CALCULATION": "request_checksum_calculation",
    "AWS_RESPONSE_CHECKSUM_VALIDATION": "response_checksum_validation",
}
_FILES: Final = {
    "AWS_SHARED_CREDENTIALS_FILE": "~/.aws/credentials",
    "AWS_CONFIG_FILE": "~/.aws/config",
}
NO_BUCKET: Final = "NoSuchBucket"
_CHECKSUM: Final = "checksum"
_CODE: Final = re.compile(r"[A-Za-z0-9.]{1,60}")

_KEYS: Final = Text(
    "correct AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or ~/.aws/credentials (AWS_PROFILE names "
    "a section of it)",
    "исправьте AWS_ACCESS_KEY_ID и AWS_SECRET_ACCESS_KEY или ~/.aws/credentials (раздел в нём "
    "называет AWS_PROFILE)",
)
_EXPIRED: Final = Text(
    "the temporary key has expired: get a new one (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, "
    "AWS_SESSION_TOKEN), or remove an old AWS_SESSION_TOKEN",
    "срок временного ключа истёк: получите новый (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, "
    "AWS_SESSION_TOKEN) или уберите старый AWS_SESSION_TOKEN",
)
_REGION: Final = Text(
    "the bucket is in another region: set AWS_DEFAULT_REGION to the one that the store's console "
    "shows, and AWS_ENDPOINT_URL to the address for it",
    "бакет в другом регионе: укажите в AWS_DEFAULT_REGION регион из консоли хранилища, а в "
    "AWS_ENDPOINT_URL — адрес для него",
)
_CLOCK: Final = Text(
    "the clock of this computer is wrong: set date, time and time zone",
    "часы этого компьютера неверны: поставьте дату, время и часовой пояс",
)
_BUSY: Final = Text(
    "the store has too many requests or is busy: repeat later; AWS_MAX_ATTEMPTS sets how often it "
    "is tried",
    "хранилище перегружено или занято: повторите позже; число попыток задаёт AWS_MAX_ATTEMPTS",
)
_VIRTUAL: Final = Text(
    "the store wants the bucket in the host's name: write addressing_style = virtual below s3 = in "
    "~/.aws/config",
    "хранилище ждёт бакет в имени узла: в ~/.aws/config под s3 = напишите addressing_style = "
    "virtual",
)
_PATH: Final = Text(
    "the host with the bucket's name is unknown: write addressing_style = path below s3 = in "
    "~/.aws/config",
    "узла с именем бакета нет: в ~/.aws/config под s3 = напишите addressing_style = path",
)
_NO_BUCKET: Final = Text(
    "there is no such bucket at this store: correct its name, or AWS_ENDPOINT_URL; mikas makes no "
    "bucket",
    "в этом хранилище такого бакета нет: исправьте его имя или AWS_ENDPOINT_URL; сам mikas бакетов "
    "не создаёт",
)
_BUCKET_NAME: Final = Text(
    "a bucket can't have this name: write s3://BUCKET/FOLDER",
    "у бакета не может быть такого имени: пишите s3://БАКЕТ/ПАПКА",
)
_DENIED: Final = Text(
    "the key has no right for this: let it list the bucket, and get, put and delete its objects "
    "(s3:ListBucket, s3:GetObject, s3:PutObject, s3:DeleteObject), or choose another key by "
    "AWS_PROFILE",
    "у ключа нет на это прав: разрешите ему список бакета, чтение, запись и удаление объектов "
    "(s3:ListBucket, s3:GetObject, s3:PutObject, s3:DeleteObject) или выберите другой ключ через "
    "AWS_PROFILE",
)
_CHECKSUMS_REFUSED: Final = Text(
    "the store does not know the newer checksums: set AWS_REQUEST_CHECKSUM_CALCULATION="
    "when_required and AWS_RESPONSE_CHECKSUM_VALIDATION=when_required",
    "хранилище не знает новых контрольных сумм: задайте AWS_REQUEST_CHECKSUM_CALCULATION="
    "when_required и AWS_RESPONSE_CHECKSUM_VALIDATION=when_required",
)
_DAMAGED: Final = Text(
    "the data did not arrive as they were sent: repeat; if it comes again, a proxy changes them "
    "(HTTPS_PROXY, NO_PROXY)",
    "данные дошли не такими, как посланы: повторите; если снова так, их меняет прокси "
    "(HTTPS_PROXY, NO_PROXY)",
)
_ENDPOINT: Final = Text(
    "this is no answer of an S3 store: correct AWS_ENDPOINT_URL (the API's address, not the "
    "console's; https:// if the store uses TLS), or repeat later",
    "это не ответ хранилища S3: исправьте AWS_ENDPOINT_URL (нужен адрес API, а не консоли; "
    "https://, если хранилище с TLS) или повторите позже",
)
_NOT_ABLE: Final = Text(
    "the store can't do this request: correct AWS_ENDPOINT_URL, or use another store",
    "хранилище не умеет такой запрос: исправьте AWS_ENDPOINT_URL или возьмите другое хранилище",
)
_HTTPS: Final = Text(
    "the store answers without TLS: write http:// in AWS_ENDPOINT_URL",
    "хранилище отвечает без TLS: в AWS_ENDPOINT_URL напишите http://",
)
_HTTP: Final = Text(
    "the connection was closed without an answer: if the store uses TLS, write https:// in "
    "AWS_ENDPOINT_URL",
    "соединение закрыто без ответа: если хранилище с TLS, в AWS_ENDPOINT_URL напишите https://",
)
_CERTIFICATE: Final = Text(
    "the store's certificate can't be verified: name the file of its authority in AWS_CA_BUNDLE",
    "сертификат хранилища не удаётся проверить: в AWS_CA_BUNDLE укажите файл его центра "
    "сертификации",
)
_NO_BUNDLE: Final = Text(
    "AWS_CA_BUNDLE names no file of certificates (PEM) that can be read",
    "в AWS_CA_BUNDLE указан не файл сертификатов (PEM), или его не прочесть",
)
_PROXY: Final = Text(
    "the proxy refuses or does not answer: correct HTTPS_PROXY and HTTP_PROXY, or name the store's "
    "host in NO_PROXY",
    "прокси отказал или не отвечает: исправьте HTTPS_PROXY и HTTP_PROXY или назовите узел "
    "хранилища в NO_PROXY",
)
_FULL: Final = Text(
    "the store has no more room for you: make room or raise the quota there",
    "места в хранилище больше нет: освободите его или увеличьте квоту там",
)
_ARCHIVED: Final = Text(
    "the object is in an archive: restore it in the store's console",
    "объект в архиве: восстановите его в консоли хранилища",
)
_ACCOUNT: Final = Text(
    "the account at the store is blocked or not paid for: look into the store's console",
    "учётная запись в хранилище заблокирована или не оплачена: загляните в его консоль",
)
_NO_KEYS: Final = Text(
    "no key for the store was found: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or name a "
    "section of ~/.aws/credentials in AWS_PROFILE",
    "ключ к хранилищу не найден: задайте AWS_ACCESS_KEY_ID и AWS_SECRET_ACCESS_KEY или назовите в "
    "AWS_PROFILE раздел ~/.aws/credentials",
)
_PROFILE: Final = Text(
    "~/.aws/config and ~/.aws/credentials can't be read, or have no section that AWS_PROFILE names",
    "~/.aws/config и ~/.aws/credentials не читаются, или в них нет раздела из AWS_PROFILE",
)
_NO_HOST: Final = Text(
    "the store's host is not known: correct AWS_ENDPOINT_URL, or check the network",
    "узел хранилища не найден: исправьте AWS_ENDPOINT_URL или проверьте сеть",
)
_CLOSED: Final = Text(
    "nothing answers at the store's address: correct host and port in AWS_ENDPOINT_URL, or check "
    "the network",
    "по адресу хранилища никто не отвечает: исправьте узел и порт в AWS_ENDPOINT_URL или проверьте "
    "сеть",
)
_SILENT: Final = Text(
    "the store did not answer in time: check the network, HTTPS_PROXY and AWS_ENDPOINT_URL",
    "хранилище не ответило вовремя: проверьте сеть, HTTPS_PROXY и AWS_ENDPOINT_URL",
)
_NO_URL: Final = Text(
    "AWS_ENDPOINT_URL is no address: write https://HOST or http://HOST:PORT",
    "в AWS_ENDPOINT_URL не адрес: пишите https://УЗЕЛ или http://УЗЕЛ:ПОРТ",
)
_NO_REGION: Final = Text(
    "set AWS_DEFAULT_REGION to the region that the store's console shows",
    "укажите в AWS_DEFAULT_REGION регион из консоли хранилища",
)

# Codes of AWS, MinIO, Ceph, Backblaze, Cloudflare, Google and Yandex; a status where a HEAD has
# no code; then the classes of the client (botocore, aiohttp).
SENTENCES: Final[Mapping[str, Text]] = MappingProxyType(
    dict.fromkeys(
        ("InvalidAccessKeyId", "SignatureDoesNotMatch", "InvalidSecurity", "NotSignedUp",
         "XMinioInvalidAccessKeyId", "InvalidClientTokenId", "UnrecognizedClientException",
         "MissingSecurityHeader", "Unauthorized", "401"), _KEYS)
    | dict.fromkeys(
        ("ExpiredToken", "ExpiredTokenException", "TokenRefreshRequired", "InvalidToken",
         "RequestExpired", "UnauthorizedSSOTokenError", "SSOTokenLoadError", "TokenRetrievalError",
         "CredentialRetrievalError"), _EXPIRED)
    | dict.fromkeys(
        ("AuthorizationHeaderMalformed", "PermanentRedirect", "TemporaryRedirect", "Redirect",
         "IllegalLocationConstraintException", "IllegalLocationConstraint",
         "InvalidLocationConstraint", "InvalidRegion", "InvalidRegionName", "WrongRegion", "301",
         "302", "307", "308",
         "RecursionError"), _REGION)  # the client follows a redirect without an end
    | dict.fromkeys(("NoRegionError", "InvalidRegionError"), _NO_REGION)
    | dict.fromkeys(("RequestTimeTooSkewed", "RequestInTheFuture"), _CLOCK)
    | dict.fromkeys(
        ("SlowDown", "ServiceUnavailable", "ServerBusy", "TooManyRequests", "Throttling",
         "ThrottlingException", "RequestLimitExceeded", "RequestTimeout", "InternalError",
         "OperationAborted", "SlowDownRead", "SlowDownWrite", "XMinioServerNotInitialized",
         "BandwidthLimitExceeded", "RequestThrottled", "OperationTimedOut", "408", "429", "502",
         "503", "504"), _BUSY)
    | dict.fromkeys(
        ("SecondLevelDomainForbidden", "InvalidAddressingHeader", "PathStyleDomainForbidden",
         "VirtualHostDomainRequired"), _VIRTUAL)
    | {"host of the bucket": _PATH, NO_BUCKET: _NO_BUCKET}
    | dict.fromkeys(
        ("InvalidBucketName", "InvalidBucketNameException", "ParamValidationError"), _BUCKET_NAME)
    | dict.fromkeys(
        ("AccessDenied", "AllAccessDisabled", "AccessForbidden", "Forbidden", "MethodNotAllowed",
         "UnauthorizedAccess", "AuthorizationFailed", "403", "405"), _DENIED)
    | {_CHECKSUM: _CHECKSUMS_REFUSED}
    | dict.fromkeys(
        ("XAmzContentSHA256Mismatch", "BadDigest", "InvalidDigest", "IncompleteBody",
         "FlexibleChecksumError", "ChecksumMismatch"), _DAMAGED)
    | dict.fromkeys(("NotImplemented", "501", "NotSupported"), _NOT_ABLE)
    | dict.fromkeys(("ResponseParserError", "InvalidURI", "400", "500"), _ENDPOINT)
    | {"no TLS": _HTTPS, "certificate": _CERTIFICATE, "no certificates": _NO_BUNDLE}
    | {"ProxyConnectionError": _PROXY}
    | dict.fromkeys(("407", "ProxyAuthenticationRequired", "InvalidProxiesConfigError"), _PROXY)
    | dict.fromkeys(
        ("QuotaExceeded", "XMinioStorageFull", "EntityTooLarge", "StorageQuotaExceeded",
         "XMinioAdminBucketQuotaExceeded", "StorageCapExceeded", "InsufficientStorage", "507"),
        _FULL)
    | {"InvalidObjectState": _ARCHIVED}
    | dict.fromkeys(
        ("AccountProblem", "UserSuspended", "AccountSuspended", "402", "UserDisable"), _ACCOUNT)
    | dict.fromkeys(("NoCredentialsError", "PartialCredentialsError"), _NO_KEYS)
    | dict.fromkeys(("ProfileNotFound", "ConfigParseError", "ConfigNotFound"), _PROFILE)
    | {"host": _NO_HOST, "EndpointConnectionError": _CLOSED, "ConnectionClosedError": _HTTP}
    | dict.fromkeys(("ConnectTimeoutError", "ReadTimeoutError", "FSTimeoutError"), _SILENT)
    | {"no URL": _NO_URL}
)  # fmt: skip
# What stores answer to a checksum's header that they don't know.
_MAY_BE_CHECKSUMS: Final = frozenset(
    ("NotImplemented", "InvalidArgument", "InvalidRequest", "XAmzContentSHA256Mismatch",
     "MissingContentLength", "BadDigest", "InvalidDigest", "SignatureDoesNotMatch", "NotSupported",
     "InvalidHeader", "InvalidTrailer", "MalformedTrailerError", "400", "501")
)  # fmt: skip
_OF_CHECKSUMS: Final = re.compile(
    "checksum|trailer|aws-chunked|x-amz-sdk|streaming|header you provided implies|"
    "x-amz-content-sha256 must be",
    re.IGNORECASE,
)
_CLOSED_BY_THE_OTHER: Final = frozenset(
    ("ServerDisconnectedError", "ClientOSError", "ConnectionResetError")
)
_NO_CERTIFICATES: Final = frozenset(
    ("FileNotFoundError", "PermissionError", "IsADirectoryError", "SSLError")
)
_SAID: Final = Text("{sentence} ({code})", "{sentence} ({code})")
_STORE_SAID: Final = Text(
    "{sentence} (the store answered {code})", "{sentence} (хранилище ответило {code})"
)
_UNKNOWN: Final = Text(
    "the store refused the request: {words}", "хранилище отклонило запрос: {words}"
)
_LONGEST: Final = 200  # characters of a store's own words


def reason_of_store(error: BaseException) -> Text | None:
    """Return in words why an object store has failed; None: it was no such store."""
    for each in _chain(error):
        if code := _code_in(each):
            words = clean_line(str(each), _LONGEST)
            sentence = SENTENCES.get(_refined(code, each)) or _UNKNOWN.filled(words=words)
            return _STORE_SAID.filled(sentence=sentence, code=code)
        if failed := SENTENCES.get(_failure(each)):
            return _SAID.filled(sentence=failed, code=type(each).__name__)
    return None


def is_of_bucket(error: BaseException) -> bool:
    """Return whether there is no such bucket, which is more than a missing file."""
    return any(_code_in(each) == NO_BUCKET for each in _chain(error))


def is_bare(error: BaseException) -> bool:
    """Return whether a store has answered with a status alone, as it does to a HEAD."""
    code = next(filter(None, map(_code_in, _chain(error))), "")
    return code.isdecimal() and code not in ("404", "410")


def options(place: str) -> dict[str, Any]:
    """Return the options of fsspec for a place: no checksums but those that a request must have,
    and the region of AWS_REGION, which AWS's other programs use.

    Newer clients add checksums to each request, and older stores refuse such requests. What the
    user sets in the environment, or in fsspec's configuration, counts.
    """
    if not place.startswith(tuple(f"{it}://" for it in PROTOCOLS)):
        return {}
    from fsspec.config import conf

    settings: dict[str, Any] = {
        "config_kwargs": {
            key: "when_required" for name, key in _CHECKSUMS.items() if not os.environ.get(name)
        }
    }
    if (region := os.environ.get("AWS_REGION")) and not os.environ.get("AWS_DEFAULT_REGION"):
        settings["client_kwargs"] = {"region_name": region}  # AWS's client for Python skips it
    for name in settings:
        for protocol in PROTOCOLS:
            settings[name] |= conf.get(protocol, {}).get(name, {})
    return settings


def keys_in_files() -> Iterator[str]:
    """Yield the secrets of ~/.aws, which no text may show."""
    for variable, usual in _FILES.items():
        file = Path(os.environ.get(variable) or usual)
        parser = ConfigParser(interpolation=None, strict=False)
        try:
            parser.read(file.expanduser(), encoding="utf-8")
        except (Error, OSError, RuntimeError, UnicodeDecodeError):  # the client says it
            continue
        for section in parser.values():
            for option, value in section.items():
                if option.startswith("aws_") and option.endswith(("_key", "_token", "_key_id")):
                    yield value


def _chain(error: BaseException) -> Iterator[BaseException]:
    seen: list[BaseException] = []
    step: BaseException | None = error
    while step is not None and step not in seen:
        seen.append(step)
        step = step.__cause__ or step.__context__
    return iter(seen)


def _code_in(error: BaseException) -> str:
    response = getattr(error, "response", None)
    if not isinstance(response, Mapping) or not isinstance(response.get("Error"), Mapping):
        return ""
    code = str(response["Error"].get("Code") or "")
    if not _CODE.fullmatch(code):
        code = str(response.get("ResponseMetadata", {}).get("HTTPStatusCode", ""))
    return code


def _refined(code: str, error: BaseException) -> str:
    asked = any(os.environ.get(name, "").lower() == "when_supported" for name in _CHECKSUMS)
    if code in _MAY_BE_CHECKSUMS and (asked or _OF_CHECKSUMS.search(str(error))):
        return _CHECKSUM
    return code


def _failure(error: BaseException) -> str:
    """Return the row of a failure before there was an answer."""
    name, words = type(error).__name__, str(error)
    below = {type(each).__name__ for each in _chain(error)}
    if name == "SSLError":
        return "certificate" if "CERTIFICATE" in words.upper() else "no TLS"
    if name == "EndpointConnectionError":
        if below & {"ClientConnectorDNSError", "gaierror"}:
            return "host of the bucket" if _has_bucket_in_host(words) else "host"
        return "ConnectionClosedError" if below & _CLOSED_BY_THE_OTHER else name
    if name == "HTTPClientError" and os.environ.get("AWS_CA_BUNDLE") and below & _NO_CERTIFICATES:
        return "no certificates"
    if isinstance(error, ValueError) and words.startswith("Invalid endpoint"):
        return "no URL"
    return name


def _has_bucket_in_host(words: str) -> bool:
    """Return whether an address that was not found has the bucket before the user's own host."""
    tried = re.search('"([^"]+)"', words)
    given = os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL") or ""
    host = urlsplit(given).hostname
    found = urlsplit(tried[1]).hostname if tried else None
    return bool(host and found and found.endswith(f".{host}"))
