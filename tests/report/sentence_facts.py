"""What was put into a report, looked at by itself, for the rules of its sentences."""

from __future__ import annotations

from mikas.catalog import Confidence, shipped
from mikas.catalog.ignition_only import DEAD
from mikas.report.findings import Findings
from mikas.report.subject import ClearedFaults


def idle(f: Findings) -> bool:
    return sum(b - a for a, b in f.measured.idle.spans) >= 10


def real(f: Findings) -> list[int]:
    return [each.code for each in f.subject.faults or () if not each.informational]


def stored(f: Findings, confidence: Confidence) -> bool:
    return any(each.confidence is confidence for each in f.subject.faults or ())


def gone(f: Findings) -> list[ClearedFaults]:
    return [c for c in f.subject.cleared if any(not each.informational for each in c.faults)]


def is_open(f: Findings) -> bool:
    return any((f.subject.faults_read or each.time) - each.time < 600 for each in gone(f))


def sensor_faults(f: Findings) -> set[str]:
    """The parameters with a fault of their sensor; in these cases faults are erased at the end."""
    faults = [*(f.subject.faults or ()), *(each for c in f.subject.cleared for each in c.faults)]
    return {name for each in faults for name in each.sensor}


def referenced(f: Findings) -> dict[str, tuple[float, float]]:
    dead = DEAD if f.measured.ignition_only else ()
    return {
        c.name: c.reference
        for c in f.measured.channels
        if getattr(c, "reference", None) and c.name not in dead
    }


def values_at(f: Findings) -> dict:
    return dict(f.measured.at_idle if idle(f) else f.measured.whole)


def rated(f: Findings) -> dict[str, bool]:
    """Whether the median is inside, by name."""
    if not idle(f):
        return {}
    return {
        name: low - 1e-9 <= values_at(f)[name].median <= high + 1e-9
        for name, (low, high) in referenced(f).items()
        if name in values_at(f) and values_at(f)[name].count >= 5 and name not in sensor_faults(f)
    }


def idle_by(f: Findings) -> set[str]:
    return {each.name for each in f.measured.idle.rules if each.name}


def unknown_idle(f: Findings) -> bool:
    return any(each.name is None for each in f.measured.idle.rules)


def unread(f: Findings) -> bool:
    return any(each.missing >= 10 for each in f.measured.idle.rules)


def no_idle(f: Findings) -> bool:
    return not unknown_idle(f) and not f.measured.idle.spans and not unread(f)


def too_fast(f: Findings) -> bool:
    """Of what shows warm idle the speed alone is outside, and always above."""
    coolant, speed, throttle = f.measured.idle.rules
    return coolant.held and throttle.held and 1300 < speed.least < 1e9


def sides(f: Findings) -> int:
    return len({(a.limit.name, a.limit.side) for a in f.measured.alarms})


def attention(f: Findings) -> bool:
    off = not all(rated(f).values())
    known = real(f) or f.measured.alarms or off or failed_tests(f) or often_retarded(f)
    return bool(known or verdict(f) in ("causes", "unknown"))


def verdict(f: Findings) -> str | None:
    return f.subject.causes.verdict.value if f.subject.causes else None


def undecided(f: Findings) -> bool:
    """Whether something is off, and the data don't decide between the causes."""
    return bool(f.subject.causes and f.subject.causes.something_off)


def often_retarded(f: Findings) -> bool:
    knock = f.measured.knock
    return knock.readings >= 50 and knock.retarded >= 0.2 * knock.readings


def failed_tests(f: Findings) -> bool:
    """In these cases a test was made once."""
    return any(each.outcome in ("attention", "bad") for each in f.subject.tests)


def good(f: Findings) -> bool:
    read = f.subject.faults is not None and not is_open(f)
    return bool(not attention(f) and not undecided(f) and read and rated(f))


def pieces(f: Findings) -> list[str | None]:
    unit = f.subject.unit
    return [] if unit is None else [*unit.program, *unit.data]


def identified(f: Findings) -> bool:
    return f.subject.unit is not None


def silent_part(f: Findings) -> bool:
    unit = f.subject.unit
    return bool(pieces(f)) and unit is not None and not (any(unit.program) and any(unit.data))


def is_virtual(f: Findings) -> bool:
    return f.subject.conditions.port.startswith("sim:")


def drawn(f: Findings) -> bool:
    return any(not each.is_flag for each in f.measured.channels)


def unreferenced(f: Findings) -> set[str]:
    return set(values_at(f)) - set(referenced(f))


def checks(f: Findings) -> bool:
    off = {name for name, inside in rated(f).items() if not inside}
    meanings = any(f.subject.catalog.parameter(name).meaning for name in off)
    return meanings or any(e.check.en for e in f.subject.faults or () if not e.informational)


def unconfirmed(f: Findings, *, ours: bool) -> bool:
    of = f.subject.catalog.parameter
    return any(
        of(n).reference_confidence is Confidence.UNCONFIRMED
        and (of(n).reference == shipped().parameter(n).reference) is ours
        for n in rated(f)
    )


def suspended(f: Findings) -> set[str]:
    return sensor_faults(f) & set(referenced(f)) & set(values_at(f)) if idle(f) else set()


def too_few(f: Findings) -> bool:
    return idle(f) and any(
        values_at(f)[n].count < 5 for n in set(referenced(f)) & set(values_at(f)) - sensor_faults(f)
    )


def related(f: Findings) -> bool:
    shown = set(referenced(f)) & set(values_at(f))
    names = {n for e in f.subject.faults or () for n in e.parameters if n not in e.sensor}
    return idle(f) and bool(names & shown)


def substitutes(f: Findings) -> bool:
    of_stored = {n for e in f.subject.faults or () for n in e.sensor} & set(values_at(f))
    alone = set(values_at(f)) if not idle(f) else unreferenced(f)
    return bool(of_stored or {v.channel.name for v in f.values if v.sensor} & alone)


def alarms(f: Findings):
    return f.measured.alarms


def frames(f: Findings):
    """The frames of real faults; in these cases each has appeared once."""
    of = f.subject.catalog.fault
    came = [each for each in f.subject.appeared if not of(each.code).informational]
    return [each.frame for each in came if each.frame is not None]


def unframed(f: Findings, *, came: bool) -> bool:
    there = {each.code for each in f.subject.appeared}
    with_frame = {each.code for each in frames(f)}
    return any((code in there) is came and code not in with_frame for code in real(f))


def ranged(f: Findings) -> bool:
    """Of the cases' values the throttle alone moves, and is among those that are shown."""
    return any(each.seen - each.without >= 0.5 for each in frames(f))


def framed_substitutes(f: Findings) -> bool:
    of = f.subject.catalog.fault
    return any(e.code in real(f) and set(of(e.code).sensor) & set(e.then) for e in frames(f))


def no_gap(f: Findings) -> bool:
    return f.subject.conditions.interruptions == ()
