"""Derived channels as data: the shipped ones against the facts, a person's own, and wrong ones."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
from catalog_harness import FREE, Write, assert_refused, refused

from mikas.catalog import Confidence, Derived, Level, Parameter, load, shipped
from mikas.catalog.model import in_order
from mikas.errors import UnknownParameter
from mikas.i18n import Text

NEW = '[derived.D]\nformula = "TWAT + 1"\ntext = "d"\n'
DOCUMENT = Path(__file__).parents[2] / "docs" / "reference" / "catalog.md"


def computed(channels: Mapping[str, Derived], **values: float) -> dict[str, float]:
    for channel in in_order(channels, channels):
        values[channel.name] = channel.calculation().number(values)
    return values


# --- the shipped ones


def test_warm_idle_gives_the_fuel_and_air_of_the_facts() -> None:
    at_idle = computed(shipped().derived, INJ=4.8, FREQ=850, JAIR=15)
    assert at_idle["FUEL_STROKE"] == pytest.approx(10)
    assert at_idle["AIR_STROKE"] == pytest.approx(147, abs=0.5)
    assert at_idle["FILLING"] == pytest.approx(21, abs=0.5)
    # 4 injections of 10 mg in two turns, 425 times a minute, 60 minutes; 0.74 kg a litre
    assert at_idle["FUEL_FLOW"] == pytest.approx(4 * 10 * 425 * 60 / 740_000)
    assert at_idle["FUEL_USED"] == pytest.approx(at_idle["FUEL_FLOW"] / 3600)
    # 4.8 ms of the 141.2 ms that two turns last
    assert at_idle["DUTY"] == pytest.approx(100 * 4.8 / (2 * 60_000 / 850))


def test_air_and_fuel_agree_at_idle() -> None:
    at_idle = computed(shipped().derived, INJ=4.8, FREQ=850, JAIR=15)
    assert at_idle["AIR_STROKE"] / at_idle["FUEL_STROKE"] == pytest.approx(14.7, abs=0.1)


def test_full_load_fills_the_cylinder_as_the_facts_say() -> None:
    assert computed(shipped().derived, INJ=16, FREQ=5200, JAIR=385)["FILLING"] == pytest.approx(
        90, abs=1
    )


def test_a_standing_engine_has_no_filling_and_uses_no_fuel() -> None:
    standing = computed(shipped().derived, INJ=0, FREQ=0, JAIR=0)
    assert [name for name, value in standing.items() if value != value] == ["AIR_STROKE", "FILLING"]
    assert standing["FUEL_FLOW"] == standing["FUEL_STROKE"] == standing["DUTY"] == 0


def test_an_injector_does_not_give_back() -> None:
    assert computed(shipped().derived, INJ=0.5, FREQ=5200, JAIR=1)["FUEL_STROKE"] == 0


def test_every_shipped_channel_is_complete() -> None:
    for name, channel in shipped().derived.items():
        assert channel.name == name
        assert channel.text.en
        assert re.search("[А-яЁё]", channel.text.ru)
        assert channel.unit in shipped().units
        assert channel.unit_text == shipped().units[channel.unit]
        assert channel.source
        assert channel.is_flag is False
        assert pickle.loads(pickle.dumps(channel)) == channel
        assert len({channel, channel}) == 1
    known = {name: channel.confidence for name, channel in shipped().derived.items()}
    assert known == dict.fromkeys(known, Confidence.UNCONFIRMED) | {
        "AIR_STROKE": Confidence.REPORTED,
        "FILLING": Confidence.REPORTED,
    }
    assert [each.name for each in shipped().derived.values() if each.accumulates] == ["FUEL_USED"]


# --- asking


@pytest.mark.parametrize("name", ["FUEL_USED", "fuel_used", " Fuel_Used "])
def test_a_channel_is_found_in_any_case(name: str) -> None:
    assert shipped().channel(name) is shipped().derived["FUEL_USED"]


def test_a_channel_may_be_a_parameter() -> None:
    assert shipped().channel("twat") is shipped().parameter("TWAT")
    raw = shipped().channel("0x1A")
    assert isinstance(raw, Parameter)
    assert raw.name == "0x1A"


@pytest.mark.parametrize(
    ("asked", "nearest"),
    [("FUEL_USD", "FUEL_USED"), ("TWATT", "TWAT"), ("DUТУ", "DUTY"), ("0х1А", "0x1A")],
)
def test_suggestions_are_of_both_kinds(asked: str, nearest: str) -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().channel(asked)
    assert caught.value.suggestions[0] == nearest


def test_there_are_three_suggestions_at_most() -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().channel("FUEL_STROK")
    assert caught.value.suggestions == ("FUEL_STROKE", "FUEL_USED", "FUEL_FLOW")


def test_parameter_knows_parameters_only() -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().parameter("DUTY")
    assert "DUTY" not in caught.value.suggestions


# --- a person's own


def test_the_files_of_the_document_load_as_it_says(write: Write) -> None:
    shown = re.findall(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    assert len(shown[2].splitlines()) == 5
    catalog = load(*map(write, shown))
    own = catalog.derived["LOAD"]
    assert catalog.channel("load") is own
    assert (own.inputs, own.constants, own.unit) == (("JAIR",), (("full", 385),), "%")
    assert own.text == Text("Engine load", "Нагрузка двигателя")
    assert (own.decimals, own.accumulates, own.alarm_limits) == (2, False, None)
    assert (own.source, own.confidence) == ("own3.toml", Confidence.UNCONFIRMED)
    assert own.calculation().number({"JAIR": 38.5}) == pytest.approx(10)
    stroke = catalog.derived["FUEL_STROKE"]
    assert dict(stroke.constants) == {"dead_time": 0.8, "injector": 2.9}
    limits = catalog.parameter("TWAT").alarm_limits
    assert limits is not None
    assert (limits.warning_high, limits.danger_high, limits.hysteresis) == (100, 110, 3)


def test_a_formula_may_name_what_comes_later(write: Write) -> None:
    catalog = load(
        write(
            '[derived.A]\nformula = "b * 2"\ntext = ""\n'
            '[derived.b]\nformula = "p + DUTY"\ntext = ""\n'
            f'[parameter.P]\ncode = {FREE}\nsize = 1\ntext = "p"\n'
        )
    )
    assert catalog.derived["A"].inputs == ("B",)
    assert catalog.derived["B"].inputs == ("P", "DUTY")
    assert computed(catalog.derived, P=1, INJ=12, FREQ=100, JAIR=1)["A"] == 4


def test_a_shipped_formula_is_overridden(write: Write) -> None:
    catalog = load(write('[derived.fuel_flow]\nformula = "JQT"\ndecimals = 3\n'))
    changed = catalog.derived["FUEL_FLOW"]
    assert (changed.inputs, changed.unit, changed.decimals) == (("JQT",), "l/h", 3)
    assert list(catalog.derived) == list(shipped().derived)


def test_a_channel_without_a_unit_has_an_empty_one(write: Write) -> None:
    own = load(write(NEW)).derived["D"]
    assert (own.unit, own.unit_text) == ("", Text("", ""))


def test_a_constant_hides_a_channel_of_its_name(write: Write) -> None:
    own = load(write(NEW + '[derived.E]\ntext=""\nformula = "twat + TWAT"\nconstants.twat = 1.5'))
    assert own.derived["E"].inputs == ("TWAT",)
    assert own.derived["E"].calculation().number({"TWAT": 1}) == 2.5


def test_a_thousand_channels_that_need_each_other_are_ordered(write: Write) -> None:
    text = '[derived.D0]\nformula = "TWAT"\ntext = ""\n' + "".join(
        f'[derived.D{n}]\nformula = "D{n - 1} + 1"\ntext = ""\n' for n in range(1, 1001)
    )
    derived = load(write(text)).derived
    order = in_order(derived, ["D1000"])
    assert [each.name for each in order] == [f"D{n}" for n in range(1001)]


def test_a_catalog_knows_what_each_channel_needs_of_the_unit(write: Write) -> None:
    catalog = load(
        write(
            '[derived.A]\nformula = "TWAT + FREQ"\ntext = ""\n'
            '[derived.B]\nformula = "A + JAIR"\ntext = ""\n'
        )
    )
    for _ in range(2):  # the second time it is known
        assert catalog.required_by(["B"]) == ("TWAT", "FREQ", "JAIR")
    assert catalog.required_by(["A", "UACC"]) == ("TWAT", "FREQ", "UACC")
    assert catalog.required_by(["TWAT"]) == ("TWAT",)
    assert catalog.required_by([]) == ()


# --- wrong files


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("\n[derived.D]\ntext = ''\n", 2, "`derived.D` has no `formula`"),
        ("\n[derived.D]\nformula = 'TWAT'\n", 2, "`derived.D` has no `text`"),
        (NEW + "formul = ''\n", 4, "unknown key `formul`; the nearest is `formula`"),
        (NEW.replace('"TWAT + 1"', "1"), 2, "`derived.D.formula` must be a text in quotes"),
        (NEW.replace("+", "+ +*"), 2, "`derived.D.formula` is not a formula: invalid syntax"),
        (NEW.replace("TWAT", "TWAT.real"), 2, "`derived.D.formula` has “TWAT.real” in it"),
        (NEW.replace("TWAT", "eval(TWAT)"), 2, "`derived.D.formula` calls “eval”"),
        (NEW.replace("TWAT", "TWATT"), 2, "names TWATT, which does not exist; the nearest is TWAT"),
        (NEW.replace("TWAT", "ТWАТ"), 2, "which does not exist; the nearest is TWAT"),
        (NEW.replace("TWAT", "DUTI"), 2, "names DUTI, which does not exist; the nearest is DUTY"),
        (NEW.replace("TWAT", "TWAT * fcator") + "constants.factor = 1", 2,
         "names FCATOR, which does not exist; the nearest is factor"),
        (NEW.replace("TWAT", "qqqqqq"), 2, "names QQQQQQ, which does not exist"),
        (NEW.replace("TWAT", "D"), 2, "`derived.D.formula` goes in a circle: D → D"),
        ("[derived.FUEL_STROKE]\n#\nformula = 'FUEL_USED'\n", 3,
         "`derived.FUEL_STROKE.formula` goes in a circle: FUEL_"),
        ("[derived.TWAT]\nformula = 'FREQ'\ntext = ''\n", 1,
         "`derived.TWAT` is the name of a parameter"),
        ("\n[parameter.duty]\ncode = 1\nsize = 1\ntext = ''\n", 2,
         "`parameter.duty` is the name of a derived channel"),
        (NEW + "[parameter.D]\ncode = 1\nsize = 1\ntext = ''\n", 1,
         "`derived.D` is the name of a parameter"),
        (NEW + "constants = 1\n", 4, "`derived.D.constants` must be a table"),
        (NEW + "constants.a = '1'\n", 4, "`derived.D.constants.a` must be a number"),
        (NEW + "constants.a = inf\n", 4, "`derived.D.constants.a` must be a number"),
        (NEW + "constants = {b = 1, A = 1}\n", 4,
         "`derived.D.constants.A` is no name of small Latin letters"),
        (NEW + "accumulates = 1\n", 4, "`derived.D.accumulates` must be true or false"),
        (NEW + "decimals = 7\n", 4, "`derived.D.decimals` must be a whole number from 0 to 6"),
        # limits
        (NEW + "limits.warning = 1\n", 4, "unknown key `warning`; the nearest is `warning_"),
        (NEW + "limits.warning_low = '1'\n", 4, "must be a number, or false for no limit"),
        (NEW + "limits.warning_low = true\n", 4, "must be a number, or false for no limit"),
        (NEW + "limits.hysteresis = -1\n", 4, "can't be: hysteresis is below 0"),
        (NEW + "limits.when_true = 'danger'\n", 4, "unknown key `when_true`"),
        (NEW + "[derived.D.limits]\nwarning_low = 2\nwarning_high = 1\n", 6,
         "`derived.D.limits.warning_high` can't be: warning_high 1 must be above warning_low 2"),
        (NEW + "[derived.D.limits]\ndanger_low = 2\nwarning_low = 1\n", 6,
         "can't be: warning_low 1 must be above danger_low 2"),
        (NEW + "[derived.D.limits]\ndanger_low = 1\ndanger_high = 2\nhysteresis = 1\n", 7,
         "`derived.D.limits.hysteresis` can't be: danger_high 2 must be above danger_low 1 and"),
        ("[parameter.TWAT.limits]\nwarning_low = 98\n", 2,
         "`parameter.TWAT.limits.warning_low` can't be: warning_high 100 must be above"),
        ("[parameter.DET.limits]\nwarning_high = 1\n", 2, "makes no sense for a flag"),
        ("[parameter.DET.limits]\nhysteresis = 1\n", 2, "makes no sense for a flag"),
        ("[parameter.DET]\nmask = 1\nlimits.hysteresis = 1\n", 3, "makes no sense for a flag"),
        ("[parameter.DET.limits]\nwhen_true = true\n", 2,
         'must be one of "none", "warning", "danger"'),
        ("[parameter.TWAT.limits]\nwhen_true = 'danger'\n", 2, "makes sense for a flag only"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_refused_with_its_line(
    write: Write, text: str, line: int, problem: str
) -> None:
    assert_refused(write(text), line, problem)


def test_the_file_that_brought_a_name_last_is_to_blame(write: Write) -> None:
    parameter = write(f"[parameter.D]\ncode = {FREE}\nsize = 1\ntext = ''\n")
    again = write("[parameter.D]\ntext.en = 'again'\n[derived.DUTY]\nunit = '1'\n")
    derived = write(NEW)
    for files, to_blame in [
        ((parameter, derived, again), derived),
        ((derived, parameter, again), parameter),
    ]:
        error = refused(*files)
        assert (error.file, error.line) == (str(to_blame), 1)


def test_of_a_long_circle_the_begin_and_the_end_are_shown(write: Write) -> None:
    text = "".join(
        f'[derived.D{n}]\ntext = "t"\nformula = "D{(n + 1) % 500}"\n' for n in range(500)
    )
    shown = refused(write(text)).problem.en.partition("in a circle: ")[2].split(" → ")
    assert (len(shown), shown[7], shown[0]) == (9, "…", shown[-1])


def test_a_circle_is_shown_from_each_channel_to_its_input(write: Write) -> None:
    inputs = {"A": "B", "B": "C", "C": "A"}
    text = "".join(f'[derived.{n}]\nformula = "{i}"\ntext = ""\n' for n, i in inputs.items())
    shown = refused(write(text)).problem.en.partition("in a circle: ")[2].split(" → ")
    assert sorted(shown[1:]) == ["A", "B", "C"]
    assert [inputs[name] for name in shown[:-1]] == shown[1:]


# --- limits


def test_the_shipped_limits_are_those_of_the_facts() -> None:
    channels = [*shipped().parameters, *shipped().derived.values()]
    given = {each.name: each.alarm_limits for each in channels if each.alarm_limits}
    assert {name: (it.lows, it.highs, it.when_true) for name, it in given.items()} == {
        "TWAT": ((), ((Level.WARNING, 100),), Level.NONE),
        "FREQ": ((), ((Level.WARNING, 6000),), Level.NONE),
        "UACC": (((Level.WARNING, 10),), ((Level.DANGER, 18),), Level.NONE),
        "DET": ((), (), Level.WARNING),
        "DUTY": ((), ((Level.DANGER, 100),), Level.NONE),
    }
    for limits in given.values():
        assert limits.source
        assert (limits.hysteresis > 0) == limits.for_number
    reported = [name for name, it in given.items() if it.confidence is Confidence.REPORTED]
    assert reported == ["UACC", "DET"]


def test_a_sound_idle_alarms_nowhere() -> None:
    for parameter in shipped().parameters:
        if parameter.alarm_limits and parameter.reference:
            low, high = parameter.reference
            assert all(limit < low for _, limit in parameter.alarm_limits.lows)
            assert all(
                high < limit - parameter.alarm_limits.hysteresis
                for _, limit in parameter.alarm_limits.highs
            )


def test_limits_are_laid_over(write: Write) -> None:
    catalog = load(
        write("[parameter.UACC.limits]\nwarning_high = 15.5\ndanger_high = false\n"),
        write("[parameter.TWAT.limits]\nwarning_high = false\n"),
        write("[parameter.DET.limits]\nwhen_true = 'danger'\nconfidence = 'reported'\n"),
    )
    voltage, knock = catalog.parameter("UACC").alarm_limits, catalog.parameter("DET").alarm_limits
    assert voltage is not None
    assert voltage.highs == ((Level.WARNING, 15.5),)
    assert voltage.lows == ((Level.WARNING, 10),)
    assert (voltage.source, voltage.confidence) == ("own1.toml", Confidence.UNCONFIRMED)
    assert catalog.parameter("TWAT").alarm_limits is None
    assert knock is not None
    assert (knock.when_true, knock.for_flag, knock.for_number) == (Level.DANGER, True, False)
    assert (knock.source, knock.confidence) == ("own3.toml", Confidence.REPORTED)


def test_limits_keep_their_source_where_a_later_file_states_no_other_limit(write: Write) -> None:
    catalog = load(
        write("[parameter.UACC.limits]\ndanger_high = false\nhysteresis = 1\n"),
        write("[parameter.TWAT.limits]\ndanger_high = 115\nsource = 'me'\n"),
        write("[parameter.TWAT]\nspan_least = 4\n[parameter.FREQ.limits]\ndanger_high = 7000\n"),
        write("[parameter.FREQ]\nspan_least = 900\n[parameter.DET.limits]\nsource = 'manual'\n"),
    )
    found = {name: catalog.parameter(name).alarm_limits for name in ("UACC", "TWAT", "FREQ", "DET")}
    assert {name: (it.source, it.confidence) for name, it in found.items() if it} == {
        "UACC": ("S1, faults 25 and 26", Confidence.REPORTED),
        "TWAT": ("me", Confidence.UNCONFIRMED),
        "FREQ": ("own3.toml", Confidence.UNCONFIRMED),
        "DET": ("manual", Confidence.REPORTED),
    }


def test_limits_of_what_a_later_file_makes_another_kind_are_dropped(write: Write) -> None:
    knock = write("[parameter.DET.limits]\nwhen_true = 'danger'\n")
    catalog = load(knock, write("[parameter.TWAT]\nmask = 1\n[parameter.DET]\nmask = 0\n"))
    assert catalog.parameter("TWAT").is_flag
    assert catalog.parameter("TWAT").alarm_limits is None
    assert catalog.parameter("DET").alarm_limits is None
    limits = load(
        write("[parameter.TWAT]\nmask = 1\n"),
        write("[parameter.TWAT.limits]\nwhen_true = 'warning'\n"),
    ).parameter("TWAT").alarm_limits  # fmt: skip
    assert limits is not None
    assert (limits.when_true, limits.for_number) == (Level.WARNING, False)


# --- start-up


def test_numpy_is_not_imported_for_single_numbers() -> None:
    script = (
        "import sys; from mikas.catalog import shipped; shipped().channel('DUTY').calculation()\n"
        "assert 'numpy' not in sys.modules\n"
        "assert shipped().derived['DUTY'].calculation().number({'INJ': 12, 'FREQ': 100}) == 1\n"
        "assert 'numpy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
