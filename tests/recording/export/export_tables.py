"""Tables to export: drawn ones for properties, one fixed one whose files are read by eye."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

from mikas.i18n import Text
from mikas.recording.export import export
from mikas.recording.table.channels import Channel, Rows
from mikas.sampling.events import AlarmChanged, Gap, Marker, StateChanged, TextNote

NAN = float("nan")
START = 1_700_000_000.0  # 2023-11-14 22:13:20 UTC

TWAT = Channel(
    "TWAT", "°C", Text("Coolant temperature", "Температура охлаждающей жидкости"), decimals=0
)
UACC = Channel("UACC", "V", Text("Board voltage", "Напряжение бортсети"), decimals=1)
IDLE = Channel("IDLE", "", Text("Idle", "Холостой ход"), is_flag=True)
CHANNELS = (TWAT, UACC, IDLE)


def rows(times, **values):
    return Rows(np.array(times, float), {name: np.array(v, float) for name, v in values.items()})


FIXED = [
    rows([START], TWAT=[85], UACC=[13.84], IDLE=[1]),
    rows([START + 0.0286, START + 1.5], TWAT=[NAN, -40], UACC=[-0.04, NAN], IDLE=[NAN, 0]),
]

HIGH = Text("Board voltage 18.1 V is above 18 V: danger", "Напряжение 18,1 В выше 18 В: опасность")
EVENTS = [  # as a recording has them: a gap is noted when it has ended
    StateChanged(START - 1, "sampling"),
    Marker(START - 0.5, "стук"),
    AlarmChanged(START + 1, "UACC", "danger", "none", "high", 18.1, 18.0, HIGH),
    Gap(START + 1.25, START + 0.25, START + 1.25, Text("no\nanswer", "нет ответа")),
    TextNote(START + 1.5, 'a "note"\twith\n two lines'),
    Marker(START + 9, ""),
    Gap(START + 9.5, START + 9.5, None, None),
]


class Drawn(NamedTuple):
    """Channels, the rows in pieces, and the same rows as whole columns."""

    channels: list[Channel]
    pieces: list[Rows]
    times: np.ndarray
    values: dict[str, np.ndarray]


_names = st.text(
    st.characters(categories=["L", "N"], include_characters="_- .", max_codepoint=0x2FFF),
    min_size=1,
    max_size=12,
).filter(lambda name: name == name.strip() and name.casefold() != "time")
_words = st.text(st.characters(categories=["L", "N", "P", "S", "Zs"]), max_size=20)
_units = st.sampled_from(["", "°C", "° crank", "об/мин", "%", "1/s"])
ALL_FLOATS = st.floats(allow_infinity=True, allow_nan=True)
MODERATE = st.one_of(st.just(NAN), st.floats(-1e6, 1e6))


@st.composite
def tables(draw, floats, *, least=0):
    """Times rise from `START`, in whole milliseconds; every flag is 0, 1 or missing."""
    channels = draw(
        st.lists(
            st.builds(
                Channel,
                name=_names,
                unit=_units,
                text=st.builds(Text, _words, _words),
                is_flag=st.booleans(),
                decimals=st.integers(0, 3),
            ),
            min_size=1,
            max_size=4,
            unique_by=lambda channel: channel.name.casefold(),
        )
    )
    count = draw(st.integers(least, 20))
    steps = draw(st.lists(st.integers(0, 100_000), min_size=count, max_size=count))
    times = START + np.cumsum(np.array(steps, float)) / 1000
    flags = st.sampled_from([0.0, 1.0, NAN])
    values = {
        channel.name: np.array(
            draw(st.lists(flags if channel.is_flag else floats, min_size=count, max_size=count)),
            float,
        )
        for channel in channels
    }
    cuts = sorted(draw(st.lists(st.integers(0, count), max_size=4)))
    pieces = [
        Rows(times[a:b], {name: column[a:b] for name, column in values.items()})
        for a, b in zip([0, *cuts], [*cuts, count], strict=True)
    ]
    return Drawn(channels, pieces, times, values)


def exported(drawn, out, **options):
    result = export(out, drawn.channels, iter(drawn.pieces), overwrite=True, **options)
    assert result.rows == len(drawn.times)
    assert result.out == out
    return out


def from_start(drawn):
    return drawn.times - drawn.times[0] if len(drawn.times) else drawn.times
