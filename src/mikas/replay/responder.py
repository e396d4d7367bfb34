"""The virtual ECU of a replay: its memory, and its responses."""

from __future__ import annotations

from mikas import commands as c
from mikas.replay.car import ReplayCar
from mikas.virtual.memory import EcuMemory
from mikas.virtual.responder import Answer, Responder


class ReplayMemory(EcuMemory):
    """The last recorded or written cells; unrecorded ones hold the default pattern."""

    def __init__(self, car: ReplayCar) -> None:
        self._car = car
        self._applied = 0
        self._until = 0.0
        contents: dict[str, dict[int, bytes]] = {}
        for cells in reversed(car.recorded.cells):  # the first recorded one wins
            space = contents.setdefault(cells.space, {})
            for address, value in enumerate(cells.data, cells.address):
                space[address] = bytes([value])
        super().__init__(contents)

    def read(self, space: str, address: int, count: int = 1) -> bytes:
        """Return the cells at the present position."""
        self._follow()
        return super().read(space, address, count)

    def write(self, space: str, address: int, data: bytes) -> None:
        """Write cells; a value holds until the next recorded one."""
        self._follow()
        super().write(space, address, data)

    def power_cycle(self) -> None:
        """Restore the recorded cells."""
        super().power_cycle()
        self._applied = 0

    def _follow(self) -> None:
        position = self._car.position()
        recorded = self._car.recorded.cells
        if position < self._until:
            self.power_cycle()
        self._until = position
        while self._applied < len(recorded) and recorded[self._applied].time <= position:
            cells = recorded[self._applied]
            super().write(cells.space, cells.address, cells.data)
            self._applied += 1


class ReplayResponder(Responder):
    """Answers like the recorded ECU, refusals included."""

    def __init__(self, car: ReplayCar) -> None:
        recorded = car.recorded
        super().__init__(car, car.identity(), recorded.quirks, ReplayMemory(car))
        self._replayed = car
        self._silences_past = 0

    def power_cycle(self) -> None:
        """Drop written data, but only after a loss of supply, not after a hole."""
        past = self._replayed.silences_past()
        if past != self._silences_past:
            self._silences_past = past
            super().power_cycle()

    def answer(self, body: bytes, now: float) -> Answer:
        """Return the recorded response, else that of a virtual ECU."""
        car = self._replayed
        car.look(now)
        # The ECU may have lost its supply since the last request, also by a seek.
        self.power_cycle()
        recorded = car.recorded
        if body and body[0] in recorded.refusals:
            return recorded.refusals[body[0]]
        if body and body[0] not in c.COMMANDS_BY_CODE and body in recorded.others:
            return recorded.others[body].at(car.position())
        self.identity = car.identity()
        return super().answer(body, now)
