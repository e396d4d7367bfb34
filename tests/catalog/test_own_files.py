"""The files of a folder of the user's own: sorted, not too many, an unread folder is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from mikas.catalog.loading import source
from mikas.catalog.loading.source import own_files


def test_only_toml_files_are_read_sorted_by_name(tmp_path: Path) -> None:
    for name in ("b.toml", "a.toml", "notes.txt"):
        (tmp_path / name).touch()
    assert own_files(tmp_path) == ([tmp_path / "a.toml", tmp_path / "b.toml"], ())


def test_no_folder_and_an_absent_one_have_no_files(tmp_path: Path) -> None:
    assert own_files(None) == ([], ())
    assert own_files(tmp_path / "absent") == ([], ())


def test_a_folder_that_cannot_be_read_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: Path) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", refuse)
    files, (error,) = own_files(tmp_path)
    assert files == []
    assert str(error).startswith(f"{tmp_path}")
    assert "can't be read: " in str(error)


def test_of_too_many_files_the_first_are_read_and_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source, "MOST_FILES", 2)
    for name in "cab":
        (tmp_path / f"{name}.toml").touch()
    files, (error,) = own_files(tmp_path)
    assert files == [tmp_path / "a.toml", tmp_path / "b.toml"]
    assert "more than 2 .toml files" in str(error)
