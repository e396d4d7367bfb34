"""How much of the wire's limit (§5) sampling reaches: on simulated time, and over a paced pty."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bench.rig import Port, Session, Watch, connected, everything, paced, sample, simulated
from bench.rows import Row, Scope, Theme
from mikas.catalog import shipped
from mikas.client.parameters.polling import FixedMethod
from mikas.sampling.plan import Plan, PlannedParameter

_LIMITS = {"single": 5.0, "batch": 17.8, "list": 30.0, "stream": 35.0}  # §5, data not stuffed
_TARGETS: dict[FixedMethod, float | None] = {
    "single": None,
    "batch": 97.0,
    "list": 97.0,
    "stream": 98.0,
}
_PAUSE = 0.055  # s between two requests, as testers of that time did it

_FAST = ("FREQ", "UOZ", "INJ", "JAIR", "THR", "UACC")
_SLOW = ("TWAT", "TAIR", "TWATI", "RCOK", "FSM", "SSM")

_METHOD = """\
All 21 codes of [§4](../protocol.md#s4), 25 data bytes a set, of a virtual ECU that idles warm;
the line echoes, the ECU turns round in 2 ms and leaves 0.4 ms between the responses of a stream.
What runs is the sampler of `mikas log`. 100 % is the wire's time for what was really carried,
stuffing included: bytes · 10 / 9600, and 2 ms a request ([§5](../protocol.md#s5)). """
_SIMULATED = """\
On the simulated clock the tester's own computing takes no time: these rows say what the protocol's
handling leaves of the wire."""
_PTY = """\
Tester and ECU are two processes on the same machine, joined by a pty on which every byte comes when
its last bit would have left the wire. What is missing from 100 % is the computing of both, the
system's switching between them, and the ECU's own lateness."""


def run(scope: Scope) -> Iterator[Theme]:
    yield theme(scope, "The wire on simulated time", simulated, _METHOD + _SIMULATED, runs=3)
    yield theme(scope, "The wire over a pty", paced, _METHOD + _PTY, runs=scope.of(9, 2))
    yield dump(scope)


def theme(scope: Scope, title: str, port: Port, method: str, runs: int) -> Theme:
    rows = []
    for name, target in _TARGETS.items():
        sets = scope.of(round(3 * _LIMITS[name]), round(_LIMITS[name]))  # three seconds, or one
        with port() as plug:
            session = sample(plug, everything(), name, sets=sets, runs=runs)
        aside = (
            f"{_rate(session):.2f} sets/s; [§5](../protocol.md#s5) says {_LIMITS[name]:.1f} "
            "for data not stuffed"
        )
        rows.append(_percent(f"`{name}`", session, target, aside))
    rows += [*_auto(scope, port, runs), *_lumps(scope, port, runs)]
    rows += [_mixed(scope, port, runs), _usual(scope, port)]
    return Theme(title, method, rows)


def _percent(what: str, session: Session, target: float | None, aside: str) -> Row:
    if session.gaps:
        aside += f"; {session.gaps} cycles LOST"
    return Row(what, [s.percent for s in session.laps], "%", 1, at_least=target, aside=aside)


def _rate(session: Session) -> float:
    rates = sorted(lap.rate for lap in session.laps)
    return rates[len(rates) // 2]


def _auto(scope: Scope, port: Port, runs: int) -> Iterator[Row]:
    with port() as plug:
        session = sample(plug, everything(), None, sets=scope.of(100, 30), runs=runs)
    rates = [lap.rate for lap in session.laps]
    how = "the sampler tries each method for a second and takes the fastest; that second is not in."
    aside = f"chose `{session.method}`"
    yield Row("`auto`", rates, "sets/s", 2, at_least=33, aside=aside, how=how)


def _lumps(scope: Scope, port: Port, runs: int) -> Iterator[Row]:
    with port(latency_ms=16) as plug:
        session = sample(plug, everything(), "stream", sets=scope.of(100, 30), runs=runs)
    what = "`stream`, adapter with 16 ms"
    row = _percent(what, session, 95.0, f"{_rate(session):.2f} sets/s")
    yield row
    with port(latency_ms=16) as plug:
        session = sample(plug, everything(), "list", sets=scope.of(60, 15), runs=runs)
    yield _percent("`list`, adapter with 16 ms", session, None, f"{_rate(session):.2f} sets/s")


def _mixed(scope: Scope, port: Port, runs: int) -> Row:
    wanted = [PlannedParameter(shipped().parameter(name)) for name in _FAST]
    wanted += [PlannedParameter(shipped().parameter(name), 10) for name in _SLOW]
    plan = Plan(tuple(wanted), "batch")
    flat = Plan(tuple(PlannedParameter(each.parameter) for each in wanted), "batch")
    with port() as plug:
        session = sample(plug, wanted, "batch", sets=scope.of(120, 40), runs=runs)
    how = (
        f"{', '.join(_FAST)} in every cycle, {', '.join(_SLOW)} in every tenth, spread over the "
        "ten; by 61."
    )
    aside = (
        f"{_rate(session):.1f} cycles/s; the plan's price said {plan.price().rate:.1f}, and "
        f"{flat.price().rate:.1f} for all twelve in every cycle"
    )
    return replace(_percent("mixed rates", session, None, aside), how=how)


def _usual(scope: Scope, port: Port) -> Row:
    """One request a parameter, a pause behind each."""
    sets = scope.of(5, 1)
    with connected(port) as ecu:
        codes = {parameter.code: parameter.name for parameter in ecu.catalog.parameters}
        ecu.read()  # what is asked only once in a session is over
        watch = Watch(ecu)
        laps = []
        for _ in range(sets):
            for name in codes.values():
                ecu.read(name)
                ecu.tester.wait(ecu.tester.link.now() + _PAUSE)
            laps.append(watch.lap(1))
    return Row(
        "the usual way",
        [lap.rate for lap in laps],
        "sets/s",
        2,
        aside=f"{laps[0].percent:.0f} % of the wire",
        how="for comparison: one request a parameter (61), 55 ms of pause behind each answer.",
    )


def dump(scope: Scope) -> Theme:
    size = scope.of(0x10000, 0x1000)
    with connected(paced) as ecu, tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "code.bin"
        watch = Watch(ecu)
        target.write_bytes(ecu.memory.code.read_block(0, size))
        lap = watch.lap(1)
    aside = f"{lap.seconds:.1f} s"
    row = Row(f"CODE, {size // 1024} KiB", [lap.percent], "%", 1, aside=aside)
    method = "One read of the program memory over the pty, in blocks of 255 bytes (25); once."
    return Theme("A dump over a pty", method, [row])
