"""Files in folders that others may write to: only a regular one is opened, without waiting."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mikas.errors import UnfitFile, reason_at
from mikas.files import Mode, open_regular, read_json, read_regular, regular

MODES: tuple[Mode, ...] = ("rb", "r+b", "a+b")


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    file = tmp_path / "elsewhere" / "secret"
    file.parent.mkdir()
    file.write_bytes(b"not yours")
    return file


@pytest.mark.posix
def test_nothing_but_a_regular_file_is_opened(
    tmp_path: Path, secret: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a socket's name is short
    Path("link").symlink_to(secret)
    Path("dangling").symlink_to(tmp_path / "elsewhere" / "none")
    Path("device").symlink_to("/dev/zero")
    os.mkfifo("pipe")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        for name in ("link", "dangling", "device", "pipe", "socket", "elsewhere", "/dev/zero"):
            for mode in MODES:
                with pytest.raises(UnfitFile) as caught:
                    open_regular(Path(name), mode)
                assert reason_at(Path(name), caught.value).ru != caught.value.text.en
    assert secret.read_bytes() == b"not yours"
    assert not (tmp_path / "elsewhere" / "none").exists()


@pytest.mark.posix
def test_what_takes_the_place_of_a_file_after_the_check_is_not_opened(
    tmp_path: Path, secret: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between two calls another program has its turn: the opened file is what counts."""
    file = tmp_path / "a.bin"

    def replaced_by(make: Callable[[], object]) -> None:
        real = os.open

        def late(*given: Any) -> int:
            file.unlink()
            make()
            return real(*given)

        for mode in MODES:
            file.unlink(missing_ok=True)
            file.write_bytes(b"mine")
            with monkeypatch.context() as patch:
                patch.setattr(os, "open", late)
                with pytest.raises(OSError, match=r"link|replaced|pipe|No such device"):
                    open_regular(file, mode)

    replaced_by(lambda: file.symlink_to(secret))
    replaced_by(lambda: os.mkfifo(file))
    replaced_by(lambda: file.symlink_to("/dev/zero"))
    with monkeypatch.context() as windows:  # no flag there: the names are compared
        windows.setattr(regular, "_NO_FOLLOW", 0)
        replaced_by(lambda: file.symlink_to(secret))
    assert secret.read_bytes() == b"not yours"


def test_a_file_with_a_second_name_is_read_but_not_changed(tmp_path: Path, secret: Path) -> None:
    file = tmp_path / "copy"
    os.link(secret, file)
    assert read_regular(file, 100) == b"not yours"
    for mode in MODES[1:]:
        with pytest.raises(UnfitFile, match="second name"):
            open_regular(file, mode)
    secret.unlink()
    with open_regular(file, "a+b") as alone:
        alone.write(b"!")
    assert read_regular(file, 100) == b"not yours!"


@pytest.mark.posix
def test_a_link_is_followed_only_if_the_user_named_it(tmp_path: Path, secret: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(secret)
    assert read_regular(link, 100, follow=True) == b"not yours"
    with pytest.raises(UnfitFile, match="not followed"):
        read_regular(link, 100)


def test_only_a_missing_file_to_append_to_is_made(tmp_path: Path) -> None:
    for mode in MODES[:2]:
        with pytest.raises(FileNotFoundError):
            open_regular(tmp_path / "new", mode)
    with open_regular(tmp_path / "new", "a+b") as file:
        file.write(b"1")
    assert (tmp_path / "new").read_bytes() == b"1"


def test_no_more_is_read_than_allowed(tmp_path: Path) -> None:
    file = tmp_path / "large"
    with file.open("wb") as out:
        out.truncate(1 << 40)
    with pytest.raises(UnfitFile, match="larger than 4 KB"):
        read_regular(file, 4096)
    file.write_bytes(bytes(4096))
    assert read_regular(file, 4096) == bytes(4096)


@pytest.mark.parametrize(
    "text",
    ["[" * 200_000, '{"a":' * 50_000, "[1e999]", "[NaN]", "9" * 5000, "9" * 40, "", "{", "\xff"],
)
def test_json_that_nothing_can_use_is_one_kind_of_error(tmp_path: Path, text: str) -> None:
    file = tmp_path / "a.json"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError):  # noqa: PT011  (json's own words)
        read_json(file, 1 << 20)


def test_texts_of_json_are_cleaned(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text(r'{"a": ["\ud800\u001b[2J", 1.5, -3, null]}')
    assert read_json(file, 100) == {"a": ["\ufffd\ufffd[2J", 1.5, -3, None]}
