"""The rows of a recording on the calendar: which of them have a date, and in which zone.

The times of a row count on the link's clock. That of a real link is UNIX time, so each row has a
date; a simulated one begins at zero, and its rows have none.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mikas.errors import usage_error
from mikas.options import nearest
from mikas.recording.exchanges.arrays import Floats
from mikas.recording.table.channels import calendar


def microseconds(times: Floats) -> NDArray[np.int64]:
    """Return the times in whole microseconds from 1970. Raises `UsageError` for one without date.

    A float of 64 bits has UNIX time to a quarter of a microsecond.
    """
    ends = (float(times.min()), float(times.max())) if times.size else ()
    if any(calendar(time) is None for time in ends):
        raise usage_error(
            "this recording, or a part of it, has no date: its clock does not count from 1970, as "
            'that of a virtual car on simulated time. Take time="elapsed": seconds from the '
            "first row",
            "у этой записи или у её части нет даты: её часы идут не от 1970 года, как у "
            'виртуальной машины с условным временем. Возьмите time="elapsed" — секунды от '
            "первой строки",
        )
    found: NDArray[np.int64] = np.rint(times * 1e6).astype(np.int64)
    return found


def checked_zone(name: str) -> str:
    """Return `name` if it is a zone of this computer. Raises `UsageError`, with the nearest one."""
    if name == "UTC":  # also without a database of zones
        return name
    from zoneinfo import ZoneInfo, available_timezones

    try:
        ZoneInfo(name)
    except (KeyError, ValueError, OSError):  # unknown, no name of a zone, a folder
        near = "".join(nearest(name, available_timezones()))
        en, ru = (f". Did you mean {near}?", f". Может быть, {near}?") if near else ("", "")
        raise usage_error(
            f"there is no time zone “{name}”; a zone is UTC, Europe/Moscow, Asia/Yekaterinburg …"
            + en,
            f"часового пояса «{name}» нет; пояс — это UTC, Europe/Moscow, Asia/Yekaterinburg …"
            + ru,
        ) from None
    return name
