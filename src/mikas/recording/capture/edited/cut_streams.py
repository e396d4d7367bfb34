"""Find streams whose request another tool has cut off, and what the recording says of them.

A stream (71, 7F … 83) is requested once, then only responses come. `editcap -r` may leave these
without the request. The last note of a plan names the parameters of the stream, and no stream of
another plan begins without another note (`mikas.sampling`). So the responses are read by it:

- if three or more follow each other without a request, which nothing but a stream does, and have
  the length of that plan's;
- if its names are those of the shipped catalog, by whose definitions it was recorded;
- if the unit was being sampled, and sent nothing by itself before the note: a unit that does not
  end a stream (D12) may go on with that of the plan before;
- if the responses come soon after the note, or the same stream is requested again behind them,
  before another plan: else the note of that may be cut off, too.

Readers get the request by a note of the kind `LEFT_OUT`, as a problem; without a request if the
plan is not known, and then the responses have no values (D13).
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import BinaryIO, Final, TypeGuard

from mikas.commands import Availability, Datum, StreamAtStroke, StreamCyclic
from mikas.errors import UnknownParameter
from mikas.framing import Decoder, Frame
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.edited.marks import Edit, Marked, PacketTimes
from mikas.recording.capture.notes import Kind, Note, read_block, said_in_place
from mikas.recording.capture.scan import RawBlock, Scanner

_FEWEST: Final = 3  # responses in a row that only a stream gives
_MANY: Final = 20  # the same without a plan: a file may hold what somebody has made by hand
_EXCHANGE: Final = 2  # frames behind a request that is no stream: its echo, its response
_NEVER: Final = 1 << 32
_MOST_PACKETS, _MOST_NOTES = 64, 8  # from a plan back to the request before
_SOON: Final = 5.0  # s from the note of a plan to its stream; faults are read before it
_CODES: Final = frozenset(bytes([it]) for it in (*StreamCyclic.CODES, *StreamAtStroke.CODES))
_VERSIONS: Final = (b"\x09", b"\x0a")
_AVAILABILITY: Final = Availability().body()
_SAMPLING: Final = "sampling"
_METHODS: Final = {"stream": None, **{f"stroke{number}": number for number in range(5)}}


@dataclass(frozen=True, slots=True)
class _PlannedStream:
    """What a plan says. `time`: of its note."""

    request: bytes
    length: int
    time: float


def _planned(plan: Note, catalog: Note | None) -> _PlannedStream | None:
    """Return the stream of a plan; None if it has none, or its parameters are not known."""
    from mikas.catalog import shipped  # slow to load, and few recordings are cut

    method, names = plan.data.get("method"), plan.data.get("names")
    if not isinstance(method, str) or method not in _METHODS or not isinstance(names, list):
        return None
    if catalog is not None and catalog.data.get("version") != shipped().version:
        return None
    with suppress(UnknownParameter):
        found = [shipped().parameter(name) for name in names if isinstance(name, str)]
        data = tuple(dict.fromkeys(Datum(it.code, it.size) for it in found))
        if len(found) < len(names) or not data:
            return None
        stroke = _METHODS[method]
        command = StreamCyclic(data) if stroke is None else StreamAtStroke(data, stroke)
        return _PlannedStream(command.body(), sum(it.size for it in data), plan.time)
    return None


class CutStreams:
    """The streams without a request in a file, from what `marked` yields of it.

    `changes`: the notes that say so, for `marks.changed`.
    """

    def __init__(self, file: BinaryIO) -> None:
        self.changes: list[Edit] = []
        self._scanner = Scanner(file)
        self._times = PacketTimes(self._scanner)
        self._front: int | None = None  # the end of the blocks in front of a section's packets
        self._order: pcapng.Order = "<"
        self._latest: dict[str, Note] = {}  # by kind

    def add(self, raw: RawBlock, item: Marked) -> None:
        """Take the next of them."""
        if isinstance(item, pcapng.Section):
            self.finish()
            self._front, self._order, self._latest = raw.end, raw.order, {}
            self._times.begin(raw)
            return
        if raw.offset == self._front:
            self._front = raw.end
        else:
            self.finish()
        if isinstance(item, Note):
            self._latest[item.kind] = item
            if item.kind != Kind.PLAN or self._front is not None:
                return
            if (plan := self._planned()) and self._is_quiet_before(raw):
                self._search(raw.end, plan)

    def finish(self) -> None:
        """Take the end of the blocks in front of a section's packets."""
        if self._front is not None:
            self._search(self._front, self._planned())
            self._front = None

    def _planned(self) -> _PlannedStream | None:
        """Return the stream of the latest plan; None if there is none, or it can't go on."""
        plan, state = self._latest.get(Kind.PLAN), self._latest.get(Kind.STATE)
        if plan is None or (state is not None and state.data.get("state") != _SAMPLING):
            return None
        return _planned(plan, self._latest.get(Kind.CATALOG))

    def _is_quiet_before(self, note: RawBlock) -> bool:
        """Return whether just one exchange was before a note: no stream was going on."""
        offset, received, notes = note.offset, b"", 0
        for _ in range(_MOST_PACKETS):
            raw = self._scanner.extent_before(offset, self._order)
            while raw is not None and raw.kind == pcapng.CUSTOM and notes < _MOST_NOTES:
                raw, notes = self._scanner.extent_before(raw.offset, self._order), notes + 1
            raw = raw and self._scanner.block(raw.offset, self._order)
            block = raw and _parsed(raw)
            if raw is None or not isinstance(block, pcapng.EnhancedPacket):
                break
            if not self._times.is_of_unit(block):
                offset = raw.offset
                continue
            if block.flags & 3 == pcapng.OUTBOUND:
                return _is_exchange(block.data, received)
            offset, received = raw.offset, block.data + received
        return False

    def _search(self, offset: int, plan: _PlannedStream | None) -> None:
        """Search from here to the first stream's request, or, without a plan, any request."""
        turn, found = _Turn(0), None
        sent, requested = Decoder(), b""
        while not requested and (raw := self._scanner.block(offset, self._order)) is not None:
            block = _parsed(raw)
            if isinstance(block, pcapng.Section) or _is_plan(block):
                break
            if isinstance(block, pcapng.EnhancedPacket) and not self._times.is_of_unit(block):
                offset = raw.end
                continue
            is_sent = (
                isinstance(block, pcapng.EnhancedPacket) and block.flags & 3 == pcapng.OUTBOUND
            )
            if plan is None and (is_sent or found is not None):
                break
            if isinstance(block, pcapng.EnhancedPacket) and is_sent:
                turn = _Turn(_EXCHANGE if _asks_for_data(block.data) else _NEVER)
                streams = [body for body in _bodies(sent, block.data) if body[:1] in _CODES]
                requested = streams[0] if streams else b""
            elif found is None and _is_received(block):
                turn.add(block.data, raw, plan)
                found = turn if turn.frames >= (_FEWEST if plan else _MANY) else None
            offset = raw.end
        if found is None or found.begin is None:
            return
        is_known = plan is not None and self._is_of(plan, found, requested)
        data = {"stream": [*plan.request] if plan is not None and is_known else []}
        at = found.begin.offset
        self.changes.append(Edit(at, at, said_in_place(data, self._order)))

    def _is_of(self, plan: _PlannedStream, turn: _Turn, requested: bytes) -> bool:
        """Return whether these responses are of that plan's stream. `requested`: the next one."""
        time = self._times.of(turn.begin)
        if turn.lengths != {plan.length} or time is None or requested not in (b"", plan.request):
            return False
        since = time - plan.time
        return 0.0 <= since <= _SOON or (since > 0.0 and bool(requested))


class _Turn:
    """What was received since something was sent. `skipped`: frames that are no stream's.

    `begin`: the packet with which the others begin; `frames`, `lengths`: their number, and those of
    their bodies.
    """

    def __init__(self, skipped: int) -> None:
        self.begin: RawBlock | None = None
        self.frames = 0
        self.lengths: set[int] = set()
        self._skipped = skipped
        self._decoder = Decoder()

    def add(self, data: bytes, raw: RawBlock, plan: _PlannedStream | None) -> None:
        """Take the next packet."""
        if self.begin is None and not self._skipped and self._decoder.is_between_frames:
            self.begin = raw
        for event in self._decoder.feed(data):
            if not isinstance(event, Frame) or (plan and event.body == plan.request):
                continue  # the echo of the request
            if self.begin is None:
                self._skipped = max(0, self._skipped - 1)
            else:
                self.frames += 1
                self.lengths.add(len(event.body))


def _parsed(raw: RawBlock) -> pcapng.Block | None:
    with suppress(pcapng.Malformed):
        return pcapng.parse(raw.kind, raw.body, raw.order)
    return None


def _is_received(block: pcapng.Block | None) -> TypeGuard[pcapng.EnhancedPacket]:
    return isinstance(block, pcapng.EnhancedPacket) and block.flags & 3 == pcapng.INBOUND


def _is_plan(block: pcapng.Block | None) -> bool:
    note = read_block(block) if isinstance(block, pcapng.Custom) else None
    return note is not None and note.kind == Kind.PLAN


def _bodies(decoder: Decoder, data: bytes) -> list[bytes]:
    return [event.body for event in decoder.feed(data) if isinstance(event, Frame)]


def _asks_for_data(wire: bytes) -> bool:
    """Return whether a packet that was sent is a request that has one response."""
    bodies = _bodies(Decoder(), wire)
    return bool(bodies) and all(it != _AVAILABILITY and it[:1] not in _CODES for it in bodies)


def _is_exchange(sent: bytes, received: bytes) -> bool:
    """Return whether these are a request and its response, also `01` and a version (D13)."""
    answers = _bodies(Decoder(), received)
    if _bodies(Decoder(), sent) == [_AVAILABILITY]:
        if answers[:1] == [_AVAILABILITY]:
            del answers[0]  # the echo
        return len(answers) == 1 and answers[0] in _VERSIONS
    return len(answers) <= _EXCHANGE and _asks_for_data(sent)
