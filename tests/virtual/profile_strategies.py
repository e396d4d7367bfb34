"""Random profiles of units, and the JSON of wrong ones."""

from __future__ import annotations

from hypothesis import strategies as st

from mikas.commands import COMMANDS_BY_CODE, StreamAtStroke
from mikas.virtual.quirks import BadWrite, ChecksumForm, LongList, StreamEnd
from mikas.virtual.unit_profile import CodeProfile, Moves, UnitProfile

codes = st.integers(0, 0xFF)
bodies = st.binary(min_size=1, max_size=4)


def maybe(strategy):
    return st.none() | strategy


def up_to(highest):
    return st.floats(0, highest, allow_nan=False, allow_subnormal=False).map(lambda s: round(s, 6))


@st.composite
def code_profiles(draw):
    size = draw(st.sampled_from([1, 1, 1, 2, 3, 255]))
    samples = draw(st.lists(st.binary(min_size=size, max_size=size), max_size=3))
    return CodeProfile(size, tuple(samples), draw(st.sampled_from(Moves)))


passport = st.binary(max_size=16).map(
    lambda data: data.replace(b"\0", b" ").decode("cp866").translate(
        {code: 0x2400 + code for code in range(0x20)} | {0x7F: 0x2421}
    )
)  # fmt: skip


@st.composite
def profiles(draw):
    known = draw(st.dictionaries(st.sampled_from(sorted(COMMANDS_BY_CODE)), st.booleans()))
    supported = {code for code, answers in known.items() if answers} | {0x01}
    return UnitProfile(
        version_code=draw(maybe(codes)),
        echo=draw(maybe(st.booleans())),
        turn_round=draw(maybe(up_to(0.3))),
        turn_round_spread=draw(maybe(up_to(0.01))),
        inter_byte=draw(maybe(up_to(0.05))),
        least_pause=draw(maybe(up_to(0.2))),
        supported=frozenset(supported),
        missing=frozenset(known.keys() - supported),
        unknown=draw(maybe(st.just("silent") | bodies.map(lambda body: body.hex().upper()))),
        bad_write=draw(maybe(st.sampled_from(BadWrite))),
        counted_blocks=draw(maybe(st.booleans())),
        max_block=draw(maybe(st.integers(1, 255))),
        max_list_61=draw(maybe(st.integers(1, 255))),
        max_list_64=draw(maybe(st.integers(1, 255))),
        max_list_71=draw(maybe(st.integers(1, 255))),
        long_list=draw(maybe(st.sampled_from(LongList))),
        accepts=draw(maybe(st.sampled_from(ChecksumForm))),
        sends=draw(maybe(st.sampled_from([ChecksumForm.STUFFED, ChecksumForm.RAW]))),
        stream_end=draw(maybe(st.sampled_from(StreamEnd))),
        stream_gap=draw(maybe(up_to(0.1))),
        stream_load=draw(maybe(up_to(5))),
        strokes=draw(
            maybe(
                st.dictionaries(
                    st.sampled_from(StreamAtStroke.CODES), st.sampled_from([2.0, 1.0, 0.5, 0.25])
                )
            )
        ),
        codes=draw(maybe(st.dictionaries(codes, code_profiles(), max_size=6))),
        parameter_count=draw(maybe(codes)),
        passports=draw(maybe(st.lists(maybe(passport), min_size=8, max_size=8).map(tuple))),
        faults=draw(maybe(st.lists(codes, max_size=4).map(tuple))),
    )


any_json = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["01", "silent", "0A1B", "1A"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(
        st.sampled_from(["61", "7F", "1A", "size", "samples", "moves"]) | st.text(max_size=4),
        inner,
        max_size=4,
    ),
    max_leaves=8,
)  # fmt: skip
