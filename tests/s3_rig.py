"""A small S3 server, which refuses as stores in the field do; moto refuses nothing."""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import md5
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape

KEY, SECRET = "AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMIK7MDENGbPxRfiCYEXAMPLEKEY"
TOKEN = "FwoGZXIvYXdzEXAMPLETOKENforaSession"


@dataclass(frozen=True)
class Request:
    method: str
    host: str
    bucket: str
    key: str
    query: dict[str, str]
    headers: dict[str, str]  # names in small letters


@dataclass(frozen=True)
class Refusal:
    """`code` None: a body that is no XML of a store."""

    status: int
    code: str | None
    message: str = "words of the store"
    more: str = ""  # further elements
    headers: dict[str, str] = field(default_factory=dict)

    def body(self) -> bytes:
        if self.code is None:
            return b"<!doctype html><title>Console</title><p>Welcome"
        text = f"<Code>{self.code}</Code><Message>{escape(self.message)}</Message>{self.more}"
        return f'<?xml version="1.0"?><Error>{text}</Error>'.encode()


Rule = Callable[[Request], Refusal | None]


class FakeS3(ThreadingHTTPServer):
    """`objects`: by key of the one bucket. `listed` None: lists have all of them, else a late store
    lists these alone. `rule`: what it refuses.
    """

    daemon_threads = True

    def __init__(self, *, bucket: str = "cars", wants_virtual_host: bool = False) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.bucket, self.wants_virtual_host = bucket, wants_virtual_host
        self.objects: dict[str, bytes] = {}
        self.listed: set[str] | None = None
        self.rule: Rule = lambda _: None
        self.requests: list[Request] = []

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"

    def handle_error(self, *_) -> None:
        """Say nothing of a client that went away."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: FakeS3

    def log_message(self, *_) -> None:
        pass

    def _request(self) -> Request:
        parts = urlsplit(self.path)
        path = unquote(parts.path).lstrip("/")
        host = self.headers.get("Host", "")
        if self.server.wants_virtual_host and host.startswith(f"{self.server.bucket}."):
            bucket, key = self.server.bucket, path
        else:
            bucket, _, key = path.partition("/")
        query = {name: of[0] for name, of in parse_qs(parts.query, keep_blank_values=True).items()}
        headers = {name.lower(): value for name, value in self.headers.items()}
        return Request(self.command, host, bucket, key, query, headers)

    def _answer(self, status: int, body: bytes = b"", **headers: str) -> None:
        self.send_response(status)
        for name, value in {"Content-Length": str(len(body)), **headers}.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _serve(self) -> None:
        data = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        if "chunked" in self.headers.get("Transfer-Encoding", ""):
            data = self._chunks()
        request = self._request()
        self.server.requests.append(request)
        refusal = self.server.rule(request)
        if refusal is None and request.bucket != self.server.bucket:
            refusal = Refusal(404, "NoSuchBucket", "The specified bucket does not exist")
        if refusal is not None:
            self._answer(refusal.status, refusal.body(), **refusal.headers)
        elif request.method == "PUT":
            self.server.objects[request.key] = data
            self._answer(200, ETag=_tag(data))
        elif request.method == "DELETE":
            self.server.objects.pop(request.key, None)
            self._answer(204)
        elif request.key:
            self._object(request)
        else:
            self._answer(200, _list(self.server, request), Content_Type="application/xml")

    def _chunks(self) -> bytes:
        found = b""
        while size := int(self.rfile.readline().split(b";")[0], 16):
            found += self.rfile.read(size)
            self.rfile.readline()
        while self.rfile.readline().strip():
            pass
        return found

    def _object(self, request: Request) -> None:
        data = self.server.objects.get(request.key)
        if data is None:
            self._answer(404, Refusal(404, "NoSuchKey").body())
            return
        status, part = 200, data
        if wanted := re.fullmatch(r"bytes=(\d+)-(\d*)", request.headers.get("range", "")):
            end = int(wanted[2]) + 1 if wanted[2] else len(data)
            status, part = 206, data[int(wanted[1]) : end]
        self._answer(status, part, ETag=_tag(data), Last_Modified="Sat, 28 Nov 2026 10:00:00 GMT")

    do_GET = do_HEAD = do_PUT = do_DELETE = _serve  # noqa: N815  (names of the base class)


def _tag(data: bytes) -> str:
    return f'"{md5(data, usedforsecurity=False).hexdigest()}"'


def _list(server: FakeS3, request: Request) -> bytes:
    prefix, part = request.query.get("prefix", ""), request.query.get("delimiter", "")
    keys, folders = [], set()
    for key in sorted(server.objects if server.listed is None else server.listed):
        rest = key.removeprefix(prefix)
        if not key.startswith(prefix):
            continue
        if part and part in rest:
            folders.add(prefix + rest.partition(part)[0] + part)
        else:
            keys.append(key)
    found = "".join(
        f"<Contents><Key>{escape(key)}</Key><Size>{len(server.objects.get(key, b''))}</Size>"
        f"<ETag>{escape(_tag(server.objects.get(key, b'')))}</ETag>"
        "<LastModified>2026-11-28T10:00:00.000Z</LastModified></Contents>"
        for key in keys
    )
    found += "".join(
        f"<CommonPrefixes><Prefix>{escape(it)}</Prefix></CommonPrefixes>" for it in sorted(folders)
    )
    return (
        '<?xml version="1.0"?><ListBucketResult><IsTruncated>false</IsTruncated>'
        f"<KeyCount>{len(keys) + len(folders)}</KeyCount>{found}</ListBucketResult>"
    ).encode()


@contextmanager
def serving(server: FakeS3) -> Iterator[FakeS3]:
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def settings(url: str) -> dict[str, str]:
    """The environment of a user of the store at `url`, who repeats nothing."""
    return {
        "AWS_ACCESS_KEY_ID": KEY, "AWS_SECRET_ACCESS_KEY": SECRET, "AWS_ENDPOINT_URL": url,
        "AWS_MAX_ATTEMPTS": "1", "AWS_CONFIG_FILE": os.devnull,
        "AWS_SHARED_CREDENTIALS_FILE": os.devnull, "AWS_EC2_METADATA_DISABLED": "true",
    }  # fmt: skip
