"""Files in folders that others may write to; `archives` reads ZIP, `locks` says who writes."""

from mikas.files.regular import (
    ABSENT,
    Mode,
    absolute,
    allow_open,
    beside,
    check_regular,
    check_unlinked,
    open_files,
    open_regular,
    read_json,
    read_regular,
    too_large,
    utf_8,
)

__all__ = [
    "ABSENT",
    "Mode",
    "absolute",
    "allow_open",
    "beside",
    "check_regular",
    "check_unlinked",
    "open_files",
    "open_regular",
    "read_json",
    "read_regular",
    "too_large",
    "utf_8",
]
