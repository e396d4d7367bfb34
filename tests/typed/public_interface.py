"""Types as a program that uses the library sees them. mypy checks this file; nothing runs it.

`warn_unused_ignores` makes each line with an ignored error a test that there is an error.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, assert_type

import mikas
from mikas.sampling.events import Sampled

if TYPE_CHECKING:
    import polars as pl


def a_misspelt_name_is_an_error() -> None:
    mikas.conect("sim:")  # type: ignore[attr-defined]
    mikas.open("drive.pcapng").to_panda()  # type: ignore[attr-defined]
    mikas.errors.NoEco  # type: ignore[attr-defined]  # noqa: B018


def a_word_that_is_not_among_the_words_is_an_error() -> None:
    mikas.connect("sim:", echo="maybe")  # type: ignore[arg-type]
    mikas.connect("sim:", interpretation="literally")  # type: ignore[arg-type]
    mikas.open("drive.pcapng", interpretation="literally")  # type: ignore[arg-type]
    mikas.open("drive.pcapng", language="de")  # type: ignore[arg-type]
    mikas.open("drive.pcapng").to_polars(time="wall")  # type: ignore[arg-type]
    mikas.session("sim:", method="fastest")  # type: ignore[arg-type]
    mikas.session("sim:", retry=2)  # type: ignore[call-arg]
    mikas.session("sim:", timeout="1 s")  # type: ignore[arg-type]


def values_have_their_types() -> None:
    with mikas.connect("sim:") as ecu:
        assert_type(ecu, mikas.Ecu)
        assert_type(ecu.info(), mikas.Info)
    with mikas.open("drive.pcapng") as recording:
        assert_type(recording, mikas.Recording)
        assert_type(len(recording), int)
        assert_type(recording.duration, float)
        frame: pl.DataFrame = recording.to_polars(time="clock", zone="Europe/Moscow")
        assert_type(frame.height, int)
    with mikas.session("sim:", channels=["FREQ"], timeout=1, echo="on") as session:
        for sample in session:
            assert_type(sample, Sampled)
    assert_type(mikas.__version__, str)


async def asynchronous_values_have_their_types() -> None:
    ecu = await mikas.AsyncEcu.connect("sim:")
    assert_type(ecu, mikas.AsyncEcu)
    reading: asyncio.Future[mikas.Info] = ecu.info()
    assert_type(await reading, mikas.Info)
    assert_type(await ecu.memory.code.read_block(0x8000, 2), bytes)
