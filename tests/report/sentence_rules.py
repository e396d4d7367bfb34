"""The rules of docs/reference/report.md as functions of the findings, by sentence.

A second implementation: it looks at what was put in, not at what the report's modules made of it,
wherever that is possible.
"""

from __future__ import annotations

from collections.abc import Callable

from mikas.catalog import Confidence, shipped
from mikas.catalog.ignition_only import DEAD
from mikas.report.findings import Findings
from mikas.report.subject import ClearedFaults

# What was put in, looked at anew


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


RULES: dict[str, Callable[[Findings], bool]] = {
    "No problems found": good,
    "Attention needed": attention,
    "Not enough data for a conclusion": lambda f: (
        not attention(f) and not good(f) and verdict(f) != "sound"
    ),
    "Nothing found, but not everything was checked": lambda f: (
        not attention(f) and not good(f) and verdict(f) == "sound"
    ),
    "The file has no packets": lambda f: f.subject.conditions.empty,
    "The stored faults were not read": lambda f: (
        f.subject.faults is None and not f.subject.conditions.empty
    ),
    "No faults are stored": lambda f: f.subject.faults is not None and not real(f),
    "No faults are stored now": lambda f: (
        f.subject.faults is not None and not real(f) and bool(gone(f))
    ),
    "{} stored: {}": lambda f: bool(real(f)),
    "{}, and whether {} back is not known yet": lambda f: (
        f.subject.faults is not None and not real(f) and is_open(f)
    ),
    "{}, and not back {}": lambda f: (
        f.subject.faults is not None and not real(f) and bool(gone(f)) and not is_open(f)
    ),
    "an alarm was on: {}": lambda f: sides(f) == 1,
    "alarms were on: {}": lambda f: sides(f) > 1,
    "this unit controls the ignition alone (injection and air flow are zero while the engine "
    "runs), so nothing of injection, mixture, air meter and idle valve is judged": lambda f: (
        f.measured.ignition_only
    ),
    "the engine knocked {}, above {} rpm {}": lambda f: f.measured.knock.knocks > 0,
    "the ignition was retarded for knock in {} % of the readings": lambda f: (
        often_retarded(f) or (f.measured.knock.knocks > 0 and f.measured.knock.readings >= 50)
    ),
    "none of the values has a reference to judge it by": lambda f: idle(f) and not referenced(f),
    "no value could be rated at warm idle": lambda f: (
        idle(f) and not rated(f) and bool(referenced(f))
    ),
    "the one value that can be rated is normal at warm idle": lambda f: (
        list(rated(f).values()) == [True]
    ),
    "all {} values that can be rated are normal at warm idle": lambda f: (
        len(rated(f)) > 1 and all(rated(f).values())
    ),
    "at warm idle {} of the {} values that can be rated {} outside the normal range: {}": (
        lambda f: not all(rated(f).values())
    ),
    "not rated because of a fault of the sensor: {}": lambda f: bool(suspended(f)),
    "whether that was warm idle is not certain": lambda f: (
        idle(f) and bool(idle_by(f) & sensor_faults(f))
    ),
    "the data can't show whether there was warm idle, so no value is rated": lambda f: (
        not idle(f) and unknown_idle(f)
    ),
    "warm idle lasted only {}, so no value is rated": lambda f: (
        not idle(f) and not unknown_idle(f) and bool(f.measured.idle.spans)
    ),
    "no warm idle was found, so no value is rated": lambda f: (
        not unknown_idle(f) and not f.measured.idle.spans and unread(f)
    ),
    "the speed was never below {} rpm, so no value is rated at warm idle; if it stays there with a "
    "warm engine and the pedal released, the idle is too fast": lambda f: (
        no_idle(f) and too_fast(f)
    ),
    "there was no warm idle, so no value is rated": lambda f: no_idle(f) and not too_fast(f),
    "the guided test “{}” found: {}": failed_tests,
    "Not read in this session.": lambda f: f.subject.faults is None,
    "No faults are stored.": lambda f: f.subject.faults == (),
    "Read {}.": lambda f: (f.subject.faults_read or 0) > 1e9,
    "Erased {}:": lambda f: any(each.erased for each in f.subject.cleared),
    "Stored before, no longer stored {} (no erase command was recorded):": lambda f: any(
        not each.erased for each in f.subject.cleared
    ),
    "Drive as usual, then read the faults again: a fault that comes back still has its cause.": (
        is_open
    ),
    "Check:": lambda f: any(each.check.en for each in f.subject.faults or ()),
    "unknown fault number": lambda f: any(
        not each.known
        for each in [
            *(f.subject.faults or ()),
            *(each for c in f.subject.cleared for each in c.faults),
        ]
    ),
    "a message, not a fault": lambda f: any(e.informational for e in f.subject.faults or ()),
    "the text is confirmed by two sources": lambda f: stored(f, Confidence.CONFIRMED),
    "the text is from one source": lambda f: stored(f, Confidence.REPORTED),
    "text unconfirmed: commonly printed, no source known": lambda f: (
        stored(f, Confidence.UNCONFIRMED)
    ),
    "it was set {}": lambda f: any(each.sets > each.times for each in alarms(f)),
    "still on at the end": lambda f: any(each.still for each in alarms(f)),
    "by the alarm's event; its values were not kept": lambda f: any(
        each.limit.name not in f.measured.whole for each in alarms(f)
    ),
    "perhaps a substitute value: fault {} of its sensor is stored": lambda f: bool(
        {each.limit.name for each in alarms(f)} & sensor_faults(f)
    ),
    "once, {}, {}": lambda f: any(each.times == 1 for each in alarms(f)),
    "{}, {} in all, first {}": lambda f: any(each.times > 1 for each in alarms(f)),
    "less than 1 s": lambda f: any(each.seconds < 0.5 for each in alarms(f)),
    "Not rated: the sensor's circuit is faulty (fault {}), the unit may use a substitute value.": (
        lambda f: bool(suspended(f))
    ),
    "Not rated: too few readings at warm idle ({}).": too_few,
    "See also stored fault {}.": related,
    "perhaps a substitute value": lambda f: (
        substitutes(f)
        or bool({each.limit.name for each in alarms(f)} & sensor_faults(f))
        or framed_substitutes(f)
    ),
    "The unit stored the fault {}.": lambda f: bool(frames(f)),
    "The values are those of the later time, with the lowest and the highest in between.": ranged,
    "No freeze frame ({}): the moment is not known to a minute, or its values are not known.": (
        lambda f: unframed(f, came=True)
    ),
    "No freeze frame ({}): stored before the first reading of the faults.": lambda f: (
        unframed(f, came=False)
    ),
    "{} of the readings": lambda f: (
        bool(rated(f)) or any(f.subject.catalog.channel(n).is_flag for n in unreferenced(f))
    ),
    "Also measured at warm idle; not rated, as no normal range is known": lambda f: (
        idle(f) and bool(unreferenced(f))
    ),
    "Over the whole time; not rated without warm idle": lambda f: (
        not idle(f) and bool(values_at(f))
    ),
    "on in {} of the readings": lambda f: any(
        f.subject.catalog.channel(n).is_flag for n in unreferenced(f)
    ),
    "Shaded: normal range at warm idle.": lambda f: bool(referenced(f)),
    "Bar at the bottom: warm idle.": lambda f: drawn(f) and bool(f.measured.idle.spans),
    "Grey: no data.": lambda f: drawn(f) and bool(f.subject.conditions.interruptions),
    "From the recording": lambda f: bool(f.subject.conditions.file),
    "measured on the connected car": lambda f: (
        not f.subject.conditions.file and not is_virtual(f)
    ),
    "measured on a virtual car": lambda f: not f.subject.conditions.file and is_virtual(f),
    "a virtual car": is_virtual,
    "date unknown": lambda f: f.subject.conditions.date is None,
    "not reported by the unit": silent_part,
    "not read": lambda f: not pieces(f),
    "Warm idle means: {}; values count after {} s of this.": lambda f: True,
    "Where this was not read ({}): {}.": lambda f: any(e.instead for e in f.measured.idle.rules),
    "For {} of {} the {} ({}) was not read; that time does not count. Read it together with the "
    "other values to rate all of it.": lambda f: any(
        each.name and each.missing >= 10 for each in f.measured.idle.rules
    ),
    "Found: {} in {}.": idle,
    "Can't be determined, as this was not recorded: {}.": lambda f: (
        not idle(f) and unknown_idle(f)
    ),
    "Not found: {}.": lambda f: (
        not idle(f) and not unknown_idle(f) and any(not e.held for e in f.measured.idle.rules)
    ),
    "Only {} found; {} s are needed.": lambda f: (
        not idle(f) and not unknown_idle(f) and all(e.held for e in f.measured.idle.rules)
    ),
    "others before": lambda f: (
        f.subject.conditions.other_methods and bool(f.subject.conditions.method)
    ),
    "none": no_gap,
    "not noted in this file": lambda f: f.subject.conditions.interruptions is None,
    "{} since connecting": lambda f: f.subject.conditions.errors is not None,
    "{} more": lambda f: (
        len(f.subject.conditions.interruptions or ()) > 3 or len(f.subject.conditions.clock) > 3
    ),
    "The model of the unit: it was not identified.": lambda f: not identified(f),
    "The unit's passports: they were not read.": lambda f: identified(f) and not pieces(f),
    "The unit's passports: it does not report them.": lambda f: (
        bool(pieces(f)) and not any(pieces(f))
    ),
    "Which faults are stored: they were not read in this session.": lambda f: (
        f.subject.faults is None
    ),
    "Whether there were faults before: according to one source the unit keeps them for about two "
    "hours and loses them when the battery is disconnected.": lambda f: (
        f.subject.faults is not None and not real(f) and not gone(f)
    ),
    "The meaning of the unknown fault numbers.": lambda f: stored(f, Confidence.UNKNOWN),
    "How exact the normal ranges are: they are commonly printed ones for a good ZMZ-406 at warm "
    "idle, without a known source. A value outside is a reason to check, not a proof.": lambda f: (
        unconfirmed(f, ours=True)
    ),
    "How exact these normal ranges are: {}. They come from the user's catalog.": lambda f: (
        unconfirmed(f, ours=False)
    ),
    "The cause: the checks are general knowledge of such engines, the easiest first.": checks,
    "Whether the engine was at warm idle: the {} shows it, and because of the sensor's fault {} "
    "the unit may use a substitute value for it.": lambda f: (
        idle(f) and bool(idle_by(f) & sensor_faults(f))
    ),
    "Not measured: {}.": lambda f: bool(f.measured.channels) and bool(
        {p.name for p in f.subject.catalog.parameters if p.reference}
        - {c.name for c in f.measured.channels}
    ),
    "All values: the data contain none.": lambda f: not f.measured.channels,
    "Whether a limit was crossed: no value with limits was measured.": lambda f: (
        bool(f.measured.channels) and not any(c.alarm_limits for c in f.measured.channels)
    ),
    "{}: the protocol's source is doubtful here; the plausible interpretation is used.": lambda f: (
        any(getattr(each, "errata", ()) for each in f.measured.channels)
    ),
    "The file holds recordings of {} cars ({}); this report is of the last recording's car alone. "
    "“mikas split” makes a file of each.": lambda f: len(f.subject.conditions.cars) > 1,
    "The file holds {} sessions; this report covers the last one.": lambda f: (
        f.subject.conditions.sessions > 1 and len(f.subject.conditions.cars) < 2
    ),
    "The session used {} ports; this report covers the one with most values.": lambda f: (
        f.subject.conditions.ports > 1
    ),
    "The data in {} of the file; all readable data were used.": lambda f: (
        f.subject.conditions.damaged > 0
    ),
    "Whether the car stood still: the unit sends no vehicle speed, so coasting in neutral looks "
    "like idle.": idle,
    "Quantities that the unit does not measure: compression, fuel pressure, spark, exhaust.": (
        lambda f: True
    ),
}  # fmt: skip
ALWAYS = {
    "Warm idle means: {}; values count after {} s of this.",
    "Quantities that the unit does not measure: compression, fuel pressure, spark, exhaust.",
}
