"""Every command with arguments that it can have, for property tests."""

from __future__ import annotations

from hypothesis import strategies as st

from mikas import commands as c

bytes_ = st.integers(0, 255)
words = st.integers(0, 0xFFFF)
SIZES = {code: 1 + (code in (0x3F, 0x21, 0x40, 0x59)) for code in range(256)}
data = st.lists(bytes_, min_size=1, max_size=30).map(
    lambda codes: tuple(c.Datum(code, SIZES[code]) for code in codes)
)


@st.composite
def blocks(draw, last):
    address = draw(st.integers(0, last))
    return address, draw(st.integers(1, min(255, last + 1 - address)))


def values(data_):
    """The data that answer `data_`."""
    return st.tuples(*(st.binary(min_size=d.size, max_size=d.size) for d in data_))


def reads_block(cls, last):
    return blocks(last).flatmap(
        lambda b: st.tuples(st.just(cls(*b)), st.binary(min_size=b[1], max_size=b[1]))
    )


def writes_block(cls, last):
    return blocks(last).flatmap(
        lambda b: st.tuples(
            st.binary(min_size=b[1], max_size=b[1]).map(lambda d: cls(b[0], d)), st.none()
        )
    )


def reads_data(make):
    return data.flatmap(lambda d: st.tuples(make(d), values(d)))


# (command, a value that it can be answered with)
text16 = st.binary(min_size=16, max_size=16).map(c.ReadProgramPassport(1).read)
exchanges = st.one_of(
    st.tuples(st.just(c.Availability()), bytes_),
    st.tuples(st.just(c.ReadFaults()), st.lists(bytes_, max_size=255).map(tuple)),
    st.tuples(bytes_.map(c.ReadRamByte), bytes_),
    st.tuples(st.builds(c.WriteRamByte, bytes_, bytes_), bytes_),
    st.tuples(words.map(c.ReadXramByte), bytes_),
    st.tuples(st.builds(c.WriteXramByte, words, bytes_), bytes_),
    st.tuples(words.map(c.ReadCodeByte), bytes_),
    st.tuples(st.builds(c.WriteCodeByte, words, bytes_), bytes_),
    reads_block(c.ReadRamBlock, 0xFF),
    writes_block(c.WriteRamBlock, 0xFF),
    reads_block(c.ReadXramBlock, 0xFFFF),
    writes_block(c.WriteXramBlock, 0xFFFF),
    reads_block(c.ReadCodeBlock, 0xFFFF),
    writes_block(c.WriteCodeBlock, 0xFFFF),
    st.tuples(bytes_.map(c.ReadSfr), bytes_),
    st.tuples(st.builds(c.WriteSfr, bytes_, bytes_), bytes_),
    st.tuples(words.map(c.GoTo), st.binary(max_size=5)),
    st.tuples(st.integers(1, 3).map(c.ReadProgramPassport), text16),
    st.tuples(st.integers(1, 5).map(c.ReadDataPassport), text16),
    st.tuples(st.just(c.CountParameters()), bytes_),
    reads_data(lambda d: st.just(c.ReadParameters(d))),
    st.tuples(st.builds(c.WriteParameter, bytes_, st.binary(min_size=1, max_size=2)), st.none()),
    reads_data(lambda d: st.just(c.ReadList(d))),
    st.tuples(data.map(c.WriteList), st.none()),
    reads_data(lambda d: st.just(c.StreamCyclic(d))),
    reads_data(lambda d: st.integers(0, 4).map(lambda s: c.StreamAtStroke(d, s))),
)
