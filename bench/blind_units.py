"""Units whose behaviour is drawn from a seed, surveyed blind: what was found, beside the truth.

    python -m bench.blind_units [SEED …]     prints the table of each unit

The survey gets a port and nothing else. Only then is each answer compared with the switches of the
virtual unit: right, open (the survey says so, with its reason), or wrong.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, cast

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions, open_ecu
from mikas.commands import COMMANDS_BY_CODE
from mikas.i18n import Text
from mikas.link.virtual import VirtualLink
from mikas.survey import Survey, SurveyAnswer, SurveyFile, SurveyOptions, SurveyVerdict
from mikas.virtual.build import MODELS, wired
from mikas.virtual.cars import EngineCar
from mikas.virtual.model.engine import Engine
from mikas.virtual.quirks import GROUPS, EcuQuirks
from mikas.virtual.responder import Identity, Responder
from mikas.virtual.scenarios.scenario import SCENARIOS, Start
from mikas.virtual.scenarios.timeline import Inputs, ScenarioTimeline

_LACKED = ("bytes", "blocks", "sfr", "passports", "count", "list", "stream", "stroke")
_REACTION = 5.0  # s that a driver takes to do what is said
_STARTER = 3.0  # s
_PEDAL = 8.0  # %, about 2,500 rpm
_VOLTS = 12.6  # of the virtual car's battery, engine off
_UNTRIED = frozenset((0x12, 0x14, 0x16, 0x22, 0x24, 0x26, 0x32, 0x41, 0x62))


@dataclass(frozen=True, slots=True)
class Compared:
    """One assumption of one unit: the truth, what was found, and whether that is right."""

    name: str
    truth: str
    found: str
    verdict: str


@dataclass(frozen=True, slots=True)
class Surveyed:
    """A blind survey of one unit."""

    seed: int
    rows: tuple[Compared, ...]
    seconds: float
    """From the begin to the end, on the link's clock, with a driver who reacts in 5 s."""
    measuring: float
    """Of these, without waiting for the car."""


def drawn(seed: int) -> dict[str, str]:
    """Return the settings of one unit."""
    random = Random(seed)

    def either(*texts: str) -> str:
        return random.choice(texts)

    def longest() -> str:
        return str(random.choice((1, random.randint(2, 20), random.randint(21, 80), 255)))

    codes = [code for code, _ in shipped().codes if code not in (0x29, 0x2C)]
    unknown = [code for code in range(0x100) if shipped().size_of(code) is None]
    lacked = [group for group in _LACKED if random.random() < 0.15]
    lacking = random.sample(codes, random.randint(0, 4))
    extra = random.sample(unknown, random.randint(0, 6))
    settings = {
        "model": either(*MODELS),
        "echo": either("1", "1", "0"),
        "turn_round": f"{random.uniform(0.0005, 0.03):.4f}",
        "inter_byte": either("0", f"{random.uniform(0.0002, 0.002):.4f}"),
        "least_pause": either("0", "0", f"{random.uniform(0.01, 0.14):.3f}"),
        "stream_gap": f"{random.uniform(0.0001, 0.008):.4f}",
        "stream_load": f"{random.uniform(0.0, 1.0):.2f}",
        "max_list_61": longest(),
        "max_list_64": longest(),
        "max_list_71": longest(),
        "long_list": either("silent", "short"),
        "max_block": longest(),
        "unknown": either("silent", "01"),
        "bad_write": either("silent", "01"),
        "counted_blocks": either("0", "1"),
        "raw_checksum": either("0", "1"),
        "accepts": either("both", "stuffed", "raw"),
        "stream_end": either("byte", "request", "break"),
        "missing": "+".join(lacked),
        "lacking": "+".join(f"{code:02X}" for code in lacking),
        "extra": "+".join(f"{code:02X}:{random.randint(1, 3)}" for code in extra),
        "faults": "+".join(map(str, random.sample((13, 21, 41, 195), random.randint(0, 3)))),
    }
    return {name: text for name, text in settings.items() if text}


class Driver:
    """Drives the virtual car as the survey says, some seconds later; has a voltmeter."""

    def __init__(self) -> None:
        self.now: Callable[[], float] = float
        self.timeline = DrivenTimeline()

    def say(self, text: Text, /) -> None:
        """Do what the survey asks for."""
        at = self.now() + _REACTION
        if "START" in text.en:
            self.timeline.starts.append(at)
        elif "Hold" in text.en:
            self.timeline.pedal.append((at, _PEDAL))
        elif "Release" in text.en:
            self.timeline.pedal.append((at, 0.0))

    def progress(self, *_: int) -> None:
        """Show nothing."""

    def ready(self, *_: object) -> bool:
        """Return True: it is done."""
        return True

    def number(self, name: str, *_: object) -> float | None:
        """Return the voltmeter's figure."""
        return _VOLTS if name == "voltmeter" else None


class DrivenTimeline:
    """A scenario's timeline whose actions are added while it runs. `starts`: of the starter."""

    duration = inf

    def __init__(self) -> None:
        self.starts: list[float] = []
        self.pedal: list[tuple[float, float]] = [(0.0, 0.0)]

    def at(self, time: float) -> Inputs:
        """Return the driver's actions."""
        starter = any(begin <= time < begin + _STARTER for begin in self.starts)
        throttle = next(value for begin, value in reversed(self.pedal) if begin <= time)
        return Inputs(True, starter, throttle, 0, None, 0.0, 0.0, 0.0)

    def key_on(self, _: float) -> bool:
        """Return True: the ignition stays on."""
        return True

    def next_key_change(self, _: float) -> float:
        """Return infinity: never."""
        return inf


def surveyed(seed: int, folder: Path, trouble: Mapping[str, str] | None = None) -> Surveyed:
    """Survey the unit of this seed on the simulated clock, and compare.

    `trouble`: settings of the line and the adapter, as `lost=0.02` or `latency_ms=16`.
    """
    settings = drawn(seed)
    driver = Driver()
    timeline = cast("ScenarioTimeline", driver.timeline)  # that of its scenario
    start = Start(ambient=20, coolant=82, coolant_at_start=20)
    scenario = replace(SCENARIOS["warm-idle"], start=start, timeline=timeline)
    faults = [int(word) for word in settings.pop("faults", "").split("+") if word]
    identity = Identity(MODELS[settings.pop("model")], ("МИКАС",) * 8)
    car = EngineCar(Engine(scenario, seed), shipped(), faults=faults)
    line = {"seed": str(seed), **(trouble or {})}
    link = VirtualLink(wired(Responder(car, identity), settings | line))
    driver.now = link.now
    with open_ecu(link, ConnectionOptions()) as ecu:
        survey = Survey(ecu, folder / f"{seed}.zip", SurveyOptions(memory=True), driver)
        survey.run()
        content = survey.save()
    rows = tuple(_compared(drawn(seed), content, link.granularity))
    return Surveyed(seed, rows, link.now(), sum(survey.seconds.values()))


def _compared(settings: dict[str, str], content: SurveyFile, late: float) -> Iterator[Compared]:
    """`late`: the seconds that the adapter hands bytes over late, at most."""
    quirks = EcuQuirks().with_options({k: v for k, v in settings.items() if k in _QUIRKS})
    answers = {answer.id: answer for answer in content.answers}
    for name, truth, question, found, is_right in _truths(settings, quirks, late):
        answer = answers[question]
        if answer.verdict is SurveyVerdict.FOUND:
            value = found(answer.value)
            verdict = "right" if is_right(truth, value) else "wrong"
            yield Compared(name, _shown(truth), _shown(value), verdict)
        else:
            yield Compared(name, _shown(truth), _reason(answer), "open")


def _equal(truth: object, value: object) -> bool:
    return truth == value


def _near(share: float, least: float) -> Callable[[Any, Any], bool]:
    def is_right(truth: float, value: float) -> bool:
        return abs(truth - value) <= max(share * truth, least)

    return is_right


def _itself(value: Any) -> Any:  # noqa: ANN401  (JSON)
    return value


def _truths(
    settings: dict[str, str], quirks: EcuQuirks, late: float
) -> Iterator[tuple[str, Any, str, Callable[[Any], Any], Callable[[Any, Any], bool]]]:
    """Yield each assumption: its name, the truth, the question, its value, and whether it fits."""
    has = frozenset(COMMANDS_BY_CODE) - quirks.missing - _UNTRIED
    sizes = {code: size for code, size in shipped().codes if code not in quirks.lacking}
    sizes |= quirks.extra_sizes
    yield "model", f"{MODELS[settings['model']]:02X}", "version", _itself, _equal
    yield "echo", settings["echo"] == "1", "echo", _itself, _equal
    yield (
        "turn-round",
        quirks.turn_round,
        "turn_round",
        lambda v: v["median"],
        _near(0.02, 1e-4 + late),
    )
    yield "pause in a response", quirks.inter_byte, "inter_byte", _itself, _near(0.05, 5e-5)
    yield "least pause", quirks.least_pause, "least_pause", _itself, _near(0, 0.003 + late)
    yield "unknown command", quirks.unknown.value, "unknown", _itself, _equal
    yield "commands", has, "commands", lambda v: _codes(v["supported"]), _equal
    yield "23 with a count", quirks.counted_blocks, "counted_blocks", _itself, _equal
    yield "largest block", quirks.max_block, "max_block", lambda v: min(v.values()), _equal
    for code in (0x61, 0x64, 0x71):
        name = f"{code:02X}"
        yield f"list of {name}", quirks.longest_list(code), f"max_list_{name}", _itself, _equal
    yield "too long a list", _long_list(quirks), "long_list", _itself, _equal
    yield "a write it can't do", quirks.bad_write.value, "bad_write", _itself, _equal
    yield "checksum understood", quirks.accepts.value, "checksum_accepted", _itself, _equal
    raw = "raw" if quirks.raw_checksum else "stuffed"
    yield "checksum sent", raw, "checksum_sent", _itself, _equal
    yield "end of a stream", quirks.stream_end.value, "stream_end", _itself, _equal
    yield "stream's pause", quirks.stream_gap, "stream_gap", _itself, _near(0.03, 1e-4)
    load = quirks.stream_load
    yield "stream and engine", load, "stream_load", lambda v: v["load"], _near(0.05, 0.03)
    half = dict.fromkeys(GROUPS["stroke"], 0.5)
    yield "strokes", half, "strokes", _rates, _like
    yield "codes and sizes", sizes, "codes", lambda v: _sizes(v["sizes"]), _equal
    faults = [int(word) for word in settings.get("faults", "").split("+") if word]
    yield "faults", faults, "faults", _itself, _equal
    yield "UACC", "b/10", "uacc_scale", lambda v: v["formula"], _equal
    yield "FREQ", "min-1", "freq", lambda v: v["unit"], _equal


def _long_list(quirks: EcuQuirks) -> str:
    return "short" if quirks.long_list.value == "short" else quirks.unknown.value


def _codes(names: list[str]) -> frozenset[int]:
    return frozenset(int(name, 16) for name in names)


def _sizes(sizes: dict[str, int]) -> dict[int, int]:
    return {int(code, 16): size for code, size in sizes.items()}


def _rates(rates: dict[str, float | None]) -> dict[int, float]:
    return {int(code, 16): rate or 0.0 for code, rate in rates.items()}


def _like(truth: dict[int, float], value: dict[int, float]) -> bool:
    return truth.keys() == value.keys() and all(
        abs(truth[code] - rate) < 0.03 for code, rate in value.items()
    )


def _shown(value: object) -> str:
    match value:
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.4g}"
        case frozenset() | dict() if value and all(isinstance(code, int) for code in value):
            numbers = sorted(code for code in value if isinstance(code, int))
            listed = " ".join(f"{code:02X}" for code in numbers)
            if isinstance(value, dict) and all(isinstance(v, int) for v in value.values()):
                return " ".join(f"{code:02X}:{value[code]}" for code in numbers)
            return listed
        case list():
            return " ".join(map(str, value)) or "–"
    return str(value)


def _reason(answer: SurveyAnswer) -> str:
    return f"{answer.verdict.value}: {answer.text.en}"


_QUIRKS = frozenset(EcuQuirks.__dataclass_fields__)


def table(unit: Surveyed) -> str:
    """Return the unit's table in Markdown."""
    lines = [
        f"## Unit {unit.seed}: {unit.seconds:.0f} s, of these measuring {unit.measuring:.0f} s"
    ]
    lines += ["| assumption | truth | found | |", "|---|---|---|---|"]
    lines += [f"| {row.name} | {row.truth} | {row.found} | {row.verdict} |" for row in unit.rows]
    return "\n".join(lines)


def main() -> None:
    seeds = [int(word) for word in sys.argv[1:]] or list(range(1, 9))
    with TemporaryDirectory() as folder:
        for seed in seeds:
            print(table(surveyed(seed, Path(folder))), flush=True)


if __name__ == "__main__":
    main()
