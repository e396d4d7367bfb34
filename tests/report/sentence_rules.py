"""The rules of docs/reference/report.md as functions of the findings, by sentence.

A second implementation: it looks at what was put in (`sentence_facts`), not at what the report's
modules made of it, wherever that is possible.
"""

from __future__ import annotations

from collections.abc import Callable

from sentence_facts import (
    alarms,
    attention,
    checks,
    drawn,
    failed_tests,
    framed_substitutes,
    frames,
    gone,
    good,
    identified,
    idle,
    idle_by,
    is_open,
    is_virtual,
    no_gap,
    no_idle,
    often_retarded,
    pieces,
    ranged,
    rated,
    real,
    referenced,
    related,
    sensor_faults,
    sides,
    silent_part,
    stored,
    substitutes,
    suspended,
    too_fast,
    too_few,
    unconfirmed,
    unframed,
    unknown_idle,
    unread,
    unreferenced,
    values_at,
    verdict,
)

from mikas.catalog import Confidence
from mikas.report.findings import Findings

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
