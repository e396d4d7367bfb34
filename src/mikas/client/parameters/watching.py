"""`Ecu.watch`: samples of chosen parameters at a rate; a failed cycle is a sample with a gap."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing

from mikas.client.parameters import polling
from mikas.client.parameters.data import refused
from mikas.client.parameters.parameters import Parameters
from mikas.client.parameters.readings import Reading, Sample
from mikas.errors import LineError, LinkLost, MikasError, NoConnection, NotSupported, usage_error


class Watcher:
    """One watch of the parameters of these names, at most `rate` samples a second."""

    def __init__(
        self,
        parameters: Parameters,
        names: Sequence[str],
        method: polling.FixedMethod,
        rate: float | None,
    ) -> None:
        polling.check_rate(rate)
        self._tester = parameters.tester
        self._parameters = parameters
        self._wanted = parameters.named(names)
        self._method = method
        self._poller = polling.create_poller(parameters, method, self._wanted, again=bool(names))
        self._turns = [polling.Turn(parameters.wanted(self._wanted), method == "list")]
        self._period = 1 / rate if rate else 0.0
        self._due: float | None = None
        self._worked = False

    def samples(self, count: int | None = None) -> Generator[Sample, None, None]:
        """Yield `count` samples, or samples without end; a failed cycle is a sample with a gap.

        Raises `LinkLost`, `NotSupported` if the unit refuses the method or every parameter.
        """
        if count is not None and count < 0:
            raise usage_error("a count is 0 or more", "число замеров — от 0")
        samples = self._samples()
        return samples if count is None else _first(samples, count)

    def _samples(self) -> Generator[Sample, None, None]:
        with closing(self._poller):
            while True:
                try:
                    readings = self._cycle()
                except LinkLost:
                    raise
                except (LineError, NoConnection) as error:
                    yield self._gap(error)
                except NotSupported as error:
                    if not (self._worked and self._method == "list"):
                        raise
                    yield self._gap(error)
                else:
                    if readings:
                        self._worked = True
                        yield Sample(min(r.time for r in readings.values()), readings)
                    elif self._method not in polling.STREAMS:
                        yield self._gap(refused(self._wanted[0].name, self._wanted[0].code))

    def _cycle(self) -> dict[str, Reading]:
        """Run the next cycle when it is due; return {} without readings in time."""
        if self._method in polling.STREAMS:
            readings = self._poller.cycle()
            times = [reading.time for reading in readings.values()]
            return readings if times and self._is_due(min(times)) else {}
        self._wait()
        readings = self._poller.cycle(self._turns)
        if self._method != "list" and not readings and self._parameters.refuses(self._wanted):
            # Every request would be skipped, and a log would stay empty without an error.
            raise refused(self._wanted[0].name, self._wanted[0].code)
        return readings

    def _wait(self) -> None:
        if self._period:
            if self._due is not None:
                self._tester.wait(self._due)
            now = self._tester.link.now()
            self._due = polling.next_due(now if self._due is None else self._due, now, self._period)

    def _is_due(self, time: float) -> bool:
        """Whether a stream's response of this time is due; if so, set the next due time."""
        if self._due is not None and time < self._due:
            return False
        self._due = polling.next_due(time if self._due is None else self._due, time, self._period)
        return True

    def _gap(self, error: MikasError) -> Sample:
        if self._method == "list":
            # After a power cycle the unit has lost its list.
            self._parameters.unit_list.forget()
        return Sample(self._tester.link.now(), error=error)


def _first(samples: Generator[Sample, None, None], count: int) -> Generator[Sample, None, None]:
    """Yield the first `count` samples; end the method before the last one is yielded."""
    with closing(samples):
        for _ in range(count - 1):
            yield next(samples)
        if count == 0:
            return
        last = next(samples)
    yield last
