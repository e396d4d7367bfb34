"""Archives of others: what is read of them, and each reason to refuse one before it costs much."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import UnfitFile
from mikas.files.archives import MOST_BYTES, MOST_MEMBERS, Archive

MOST = 1 << 16


def packed(*members: tuple[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, data in members:
            archive.writestr(name, data)
    return out.getvalue()


def read(data: bytes, name: str = "a", most: int = MOST) -> bytes:
    return Archive(io.BytesIO(data)).read(name, most)


def refused(data: bytes, name: str = "a", most: int = MOST) -> str:
    with pytest.raises(UnfitFile) as caught:
        read(data, name, most)
    en, ru = caught.value.text
    assert ru != en
    return en


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_a_member_is_read(method):
    archive = Archive(io.BytesIO(packed(("a", b"1" * 900), ("b/c", b"2"), method=method)))
    assert archive.names == ("a", "b/c")
    assert archive.read("a", 900) == b"1" * 900
    assert archive.read("b/c", 1) == b"2"


def test_a_comment_behind_it_does_not_matter():
    out = io.BytesIO(packed(("a", b"1")))
    with zipfile.ZipFile(out, "a") as archive:
        archive.comment = b"c" * 0xFFFF
    assert read(out.getvalue()) == b"1"


def test_a_missing_member_is_named():
    assert "has no unit.json" in refused(packed(("a", b"")), "unit.json")


def test_a_bomb_is_refused_without_being_unpacked():
    bomb = packed(("a", bytes(MOST * 500)))
    assert len(bomb) < MOST
    assert "more than 64 KB" in refused(bomb)


def test_a_bomb_that_lies_about_its_size_is_refused():
    data = bytearray(packed(("a", bytes(MOST * 50))))
    size = struct.pack("<L", MOST * 50)
    assert data.count(size) == 2  # in the member's header and in the list
    assert "damaged" in refused(bytes(data).replace(size, struct.pack("<L", 10)))


def test_too_many_members_are_refused():
    many = [(str(at), b"") for at in range(MOST_MEMBERS + 1)]
    assert "64" in refused(packed(*many))
    assert read(packed(*many[2:], ("a", b"1"))) == b"1"


def test_a_long_list_of_members_is_not_even_read(monkeypatch):
    data = packed(*((f"{at:06}", b"") for at in range(3000)))
    monkeypatch.setattr(zipfile.ZipFile, "_RealGetContents", lambda _: pytest.fail("it was read"))
    assert "too many members" in refused(data)


def test_a_list_in_the_form_of_64_bits_is_refused():
    data = packed(("a", b"1"))
    at = data.rfind(b"PK\5\6")
    record = b"PK\6\6" + struct.pack("<QHHLLQQQQ", 44, 45, 45, 0, 0, 1, 1, 1 << 33, 0)
    locator = b"PK\6\7" + struct.pack("<LQL", 0, at, 1)
    assert "too many members" in refused(data[:at] + record + locator + data[at:])


def test_a_file_of_a_gigabyte_is_refused_unread(tmp_path):
    path = tmp_path / "large.zip"
    with path.open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with path.open("rb") as file, pytest.raises(UnfitFile, match="more than 64 MB"):
        Archive(file)


def test_a_name_that_stands_twice_is_refused():
    with pytest.warns(UserWarning, match="Duplicate"):
        data = packed(("a", b"1"), ("a", b"2"))
    assert "twice" in refused(data)


@pytest.mark.parametrize("data", [b"", b"PK", b"PK\3\4" + bytes(100), b"PK\5\6" + bytes(10)])
def test_no_archive_and_a_cut_one_are_said_to_be_so(data):
    assert "no ZIP archive" in refused(data)


def test_a_cut_archive_is_refused():
    assert "no ZIP archive" in refused(packed(("a", b"1" * 100))[:-30])


def test_a_damaged_member_is_named():
    data = bytearray(packed(("a", b"123456789"), method=zipfile.ZIP_STORED))
    data[data.index(b"123456789")] ^= 1
    assert "a in the archive is damaged" in refused(bytes(data))


def test_a_password_and_another_packing_are_named():
    data = packed(("a", b"123456789"))
    at = data.rfind(b"PK\1\2")
    locked = data[: at + 8] + b"\1\0" + data[at + 10 :]
    assert "password" in refused(locked)
    other = data[: at + 10] + b"\x0e\0" + data[at + 12 :]  # LZMA
    assert "deflate" in refused(other)


def test_an_offset_outside_is_refused():
    data = packed(("a", b"1"))
    at = data.rfind(b"PK\1\2") + 42
    refused(data[:at] + struct.pack("<L", 0xFFFFFFFF) + data[at + 4 :])


WHOLE = packed(("a", b"12345" * 40), ("b", b"6"))


@given(
    st.lists(
        st.tuples(st.integers(0, len(WHOLE) - 1), st.integers(0, 255) | st.none()), max_size=6
    ),
    st.binary(max_size=30),
)
def test_any_change_gives_the_member_or_a_reason(changes, more):
    data = bytearray(WHOLE)
    for at, value in changes:
        if value is None:
            del data[at:]
        elif at < len(data):
            data[at] = value
    try:
        found = read(bytes(data) + more)
    except UnfitFile as error:
        assert error.text.en
    else:
        assert found == b"12345" * 40 or zlib.crc32(found) in {
            int.from_bytes(data[at + 16 : at + 20], "little")
            for at in range(len(data))
            if data[at : at + 4] == b"PK\1\2"
        }
