"""The scale of a gauge and the least span of a value axis."""

from __future__ import annotations

from catalog_harness import NEW, Write, assert_refused

from mikas.catalog import Derived, Parameter, load, shipped


def test_gauges_and_axes_have_the_scale_of_the_catalog_or_of_the_range(write: Write) -> None:
    first = write(NEW + 'scale = "1/4"\nrange = [0, 60]\n[derived.D]\ntext = "d"\nformula = "P"\n')
    plain = load(first)
    assert plain.parameter("P").gauge_scale == (0, 60)
    assert plain.parameter("P").least_span == 3  # 5 % of the range; 10 steps are 2.5
    assert (plain.channel("D").gauge_scale, plain.channel("D").least_span) == (None, 0.1)
    own = "gauge = [-1, 2.5]\nspan_least = 0.5\n"
    for name in ("P", "D"):
        family = "parameter" if name == "P" else "derived"
        changed = load(first, write(f"[{family}.{name}]\n{own}")).channel(name)
        assert (changed.gauge_scale, changed.least_span) == ((-1, 2.5), 0.5)
    bare = shipped().parameter("0x3F:2")
    assert (bare.gauge_scale, bare.least_span) == ((0, 65535), 10)
    assert load(write(NEW + "range = [1, 1]")).parameter("P").gauge_scale == (0, 255)
    for wrong, problem in (
        ("gauge = [1, 1]", "different ends"),
        ("gauge = [2, 1]", "above its high end"),
        ("gauge = 5", "two numbers"),
        ("span_least = 0", "above 0"),
        ("mask = 1\ngauge = [0, 1]", "makes no sense for a flag"),
        ("mask = 1\nspan_least = 1", "makes no sense for a flag"),
    ):
        line = 5 + wrong.count("\n")
        assert_refused(write(NEW + wrong), line, problem)


def test_every_shipped_number_has_a_scale() -> None:
    """A gauge stands still; a flag has neither key."""
    channels: list[Parameter | Derived] = [*shipped().parameters, *shipped().derived.values()]
    for channel in channels:
        scale, least = channel.gauge_scale, channel.least_span
        if channel.is_flag:
            assert (scale, least) == (None, None)
            continue
        assert scale is not None
        assert least is not None
        assert 0 < least < scale[1] - scale[0]
        assert channel.span_least is not None, f"{channel.name}: span_least is missing"
        if reference := getattr(channel, "reference", None):
            assert scale[0] <= reference[0] <= reference[1] <= scale[1]
