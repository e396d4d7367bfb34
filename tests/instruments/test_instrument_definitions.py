"""Definitions: the shipped ones, one's own, and what is refused with file and line."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.errors import CatalogError, UsageError
from mikas.instruments import (
    InstrumentValues,
    NoValues,
    decoder_of,
    decoding,
    definition_named,
    definition_names,
    definition_of_text,
    loading,
)
from mikas.instruments.decoders.patterns import LinePattern

OWN = """\
text = { en = "Boost gauge", ru = "Манометр" }
decoder = "line"
baud = 115200
patterns = ["P={BOOST_BAR} bar, {}*"]
stale = 0.5

[instrument.BOOST_BAR]
text = { en = "Boost", ru = "Наддув" }
unit = "bar"
range = [-1, 4]
"""


def test_every_shipped_definition_has_channels_of_the_catalog_in_both_languages() -> None:
    assert definition_names() == ("14point7", "aem", "gpsd", "innovate", "nmea")
    for name in definition_names():
        found = definition_named(name)
        assert found.channels
        assert all(found.text)
        assert found.source
        for channel in found.channels:
            assert channel == shipped().instruments[channel.name]
            assert None not in (channel.range, channel.gauge)
            assert channel.text.en != channel.text.ru
        assert definition_of_text(name, found.toml) == found  # as a recording keeps it


def test_own_lines_by_a_pattern(tmp_path: Path) -> None:
    path = tmp_path / "boost-gauge.toml"
    path.write_text(OWN, encoding="utf-8")
    found = definition_named(str(path))
    assert (found.name, found.baud, found.stale) == ("boost-gauge", 115200, 0.5)
    assert [channel.unit for channel in found.channels] == ["bar"]
    decoder = decoder_of(found)
    events = decoder.feed(b"\nP=0.52 bar, 21 C\nP=9 bar, 21 C\nP= bar, 1\n")
    assert [type(each) for each in events] == [InstrumentValues, NoValues, NoValues]
    assert events[0] == InstrumentValues(18, {"BOOST_BAR": 0.52})


def test_a_label_is_the_end_of_each_name() -> None:
    left = definition_named("aem").labelled("left")
    assert [channel.name for channel in left.channels] == ["LAMBDA_LEFT", "AFR_LEFT"]
    assert left.channels[0].text.en.endswith(", left")


@pytest.mark.parametrize(
    ("before", "after", "line", "problem"),
    [
        (
            'decoder = "line"',
            'decoder = "lines"',
            2,
            "there is no decoder “lines”; there are: line, ",
        ),
        ("baud = 115200", "baud = 7", 3, "whole number"),
        ("{BOOST_BAR}", "{NOTHING}", 4, "[instrument.NOTHING]"),
        ("{BOOST_BAR}", "{TWAT}", 4, "the unit itself sends"),
        ("{BOOST_BAR}", "x", 4, "write the channel's name"),
        ("{BOOST_BAR}", "{BOOST_BAR", 4, "lone"),
        ("{}*", "**", 4, "two *"),
        ("{}*", "{boost_bar}", 4, "twice"),
        ('patterns = ["P={BOOST_BAR} bar, {}*"]\n', "", 2, "needs one"),
        ("stale = 0.5", "stale = 0", 5, "above 0"),
        ("stale = 0.5", "stael = 0.5", 5, "nearest is `stale`"),
        ("range = [-1, 4]", "range = [4, -1]", 10, "above its high end"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(
    before: str, after: str, line: int, problem: str
) -> None:
    assert before in OWN
    with pytest.raises(CatalogError) as caught:
        definition_of_text("boost", OWN.replace(before, after))
    assert problem in caught.value.problem.en
    assert caught.value.line == line


def test_an_unknown_name_gives_the_nearest_one() -> None:
    with pytest.raises(UsageError, match="Did you mean innovate"):
        definition_named("inovate")
    with pytest.raises(CatalogError, match=r"no-such\.toml"):
        definition_named("no-such.toml")


@given(pattern=st.text(alphabet="{}A1*\\ .x=,", max_size=30), line=st.text(max_size=256))
def test_a_pattern_matches_or_not_and_never_fails(pattern: str, line: str) -> None:
    try:
        found = LinePattern(pattern)
    except UsageError:
        return
    values = found.values(line)
    assert values is None or set(values) == set(found.names)


def test_no_line_takes_long_whatever_the_pattern() -> None:
    """Each part takes what it takes once: else this pattern would try 250⁶ ways."""
    pattern = LinePattern("*a*a*a*a*a*a*{X}!")
    assert pattern.values("a" * 255) is None
    assert LinePattern("*{}*{}*{}*{}*{X}!").values("1 " * 127) is None


class Plx:
    """A decoder of another distribution: a byte is λ in hundredths; 255 breaks it."""

    definition = (
        'text = "PLX"\ndecoder = "plx"\nchannels = ["LAMBDA", "AFR"]\nsource = "its maker"\n'
    )

    def feed(self, data: bytes) -> list[InstrumentValues]:
        if 255 in data:
            raise RuntimeError("255")
        return [InstrumentValues(at, {"LAMBDA": byte / 100}) for at, byte in enumerate(data, 1)]

    def drop(self) -> None: ...


def test_another_distribution_brings_an_instrument(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("plx", f"{__name__}:Plx", "mikas.instruments")
    for module in (loading, decoding):
        monkeypatch.setattr(module, "entries_of", lambda _: {"plx": [entry]})
    assert "plx" in definition_names()
    found = definition_named("plx")
    decoder = decoder_of(found)
    (values,) = decoder.feed(bytes([98]))
    assert isinstance(values, InstrumentValues)
    assert values.values == pytest.approx({"LAMBDA": 0.98, "AFR": 14.406})
    (failed,) = decoder.feed(bytes([255]))
    assert isinstance(failed, NoValues)
    assert "RuntimeError" in failed.reason.en
