"""`mikas co` on the virtual unit, with an analyser whose figure follows what is written to RCOD."""

from __future__ import annotations

import pytest

from mikas.virtual.cars import EngineCar

IDLE = "&scenario=warm-idle"


class Bench:
    """A person who reads an analyser and types its figure; `figure`: by the byte in the unit."""

    def __init__(self, mikas, figure, found=0x88):
        self._mikas, self._figure, self._found = mikas, figure, found
        self.typed: list[str] = []

    def isatty(self):
        return True

    def readline(self):
        written = [each for each in self._changes() if each.get("after")]
        raw = int(written[-1]["after"], 16) if written else self._found
        self.typed.append(f"{self._figure(raw):.2f}")
        return f"{self.typed[-1]}\n"

    def _changes(self):
        try:
            return self._mikas.journal
        except ValueError:  # nothing was changed yet
            return []


@pytest.fixture
def bench(mikas, monkeypatch):
    def sit(figure):
        made = Bench(mikas, figure)
        monkeypatch.setattr("sys.stdin", made)
        return made

    return sit


def raw_of(mikas):
    return mikas("read", "RCOD", "--json").object["readings"]["RCOD"]["raw"]


@pytest.mark.parametrize("sign", [1, -1])
def test_co_goes_on_until_the_analyser_is_in_the_band(mikas, bench, sign):
    analyser = bench(lambda raw: max(0.1, 2.0 + sign * 0.08 * (raw - 0x88)))
    ran = mikas("co", "--target", "0.8", "--yes", "--json", sim=IDLE)
    assert ran.status == 0
    done = ran.object
    assert (done["outcome"], done["raw_before"]) == ("set", "88")
    assert abs(done["steps"][-1]["measured"] - 0.8) <= 0.2
    assert int(done["raw_after"], 16) - 0x88 == pytest.approx(-15 * sign, abs=3)
    assert [f"{step['measured']:.2f}" for step in done["steps"]] == analyser.typed
    assert ("the other way" in ran.err) == (sign < 0)
    assert "mikas write RCOD --raw 88" in ran.err
    assert mikas.journal[-1]["after"] == done["raw_after"]


def test_a_figure_that_does_not_follow_puts_the_found_value_back(mikas, bench):
    bench(lambda raw: 3.0)
    ran = mikas("co", "--target", "0.8", "--yes", sim=IDLE)
    assert ran.status == 0
    assert "does not follow RCOD" in ran.err
    assert ran.lines[0].endswith("(88)")
    assert ran.lines[-1].endswith("(88)")
    assert mikas.journal[-1]["after"] == "88"


def test_lambda_and_one_step_without_a_terminal(mikas):
    ran = mikas(
        "co", "--target", "0.98", "--lambda", "--measured", "1.02", "--yes", "--json", sim=IDLE
    )
    assert ran.object["steps"] == [{"measured": 1.02, "outcome": "write", "raw": "90"}]
    ran = mikas("co", "--target", "0.98", "--lambda", "--measured", "0.97", "--json", sim=IDLE)
    assert (ran.status, ran.object["outcome"]) == (0, "set")


def test_nothing_is_written_without_a_yes_or_warm_idle(mikas, bench):
    ran = mikas("co", "--target", "0.8", "--measured", "2", sim=IDLE)
    assert ran.status == 6
    assert "comes back" not in ran.err
    ran = mikas("co", "--target", "0.8", "--measured", "2", "--yes", sim="&scenario=cold-start")
    assert ran.status == 6
    assert "It needs warm idle: the engine turns at 0 rpm" in ran.err
    mikas.answers("much\n", "2.0\n", "n\n")
    ran = mikas("co", "--target", "0.8", sim=IDLE)
    assert ran.status == 6
    assert "A number from 0 to 15 is needed" in ran.err
    assert list(mikas.home.glob("state/mikas/journal.jsonl")) == []


def test_an_engine_that_leaves_idle_before_the_first_figure_is_seen(mikas, monkeypatch):
    """A person may stand at the analyser for minutes."""
    raw, has_asked = EngineCar.raw, []

    class Person:
        def isatty(self):
            return True

        def readline(self):
            has_asked.append(True)
            return "2.0\n"

    def revved(self, code, now):
        return b"\x40" if code == 0x29 and has_asked else raw(self, code, now)

    monkeypatch.setattr("sys.stdin", Person())
    monkeypatch.setattr(EngineCar, "raw", revved)
    ran = mikas("co", "--target", "0.8", "--yes", sim=IDLE)
    assert ran.status == 6
    assert "the engine turns at 2560 rpm, not at idle" in ran.err
    assert list(mikas.home.glob("state/mikas/journal.jsonl")) == []


def test_the_end_of_input_ends_it_and_says_how_to_put_back(mikas):
    mikas.answers("2.0\n")
    ran = mikas("co", "--target", "0.8", "--yes", sim=IDLE)
    assert ran.status == 130
    assert "mikas write RCOD --raw 88" in ran.err


def test_a_wrong_figure_and_no_terminal_are_refused_before_a_port_is_opened(mikas):
    for words, problem in (
        (("--target", "20"), "from 0 to 15"),
        (("--target", "0.8", "--lambda", "--measured", "0.1"), "from 0.5 to 2"),
        (("--target", "0.8", "--within", "1.1"), "near enough is up to 1"),
        (("--target", "0.98", "--within", "0.2", "--lambda"), "near enough is up to 0.1"),
        (("--target", "0.8"), "--measured"),
        ((), "--target is missing"),
    ):
        ran = mikas("co", *words, sim=IDLE)
        assert ran.status == 2
        assert problem in ran.err


def test_a_unit_that_sets_rcod_by_itself_is_said(mikas, monkeypatch):
    """As one with a CO potentiometer: what was written is read back, and gone soon after."""
    mikas.answers("2.0\n", "1.9\n")
    raw, reads = EngineCar.raw, []

    def forgets(self, code, now):
        if code == 0x41 and code in self._written:
            reads.append(now)
            if len(reads) > 1:
                self._written.clear()
        return raw(self, code, now)

    monkeypatch.setattr(EngineCar, "raw", forgets)
    ran = mikas("co", "--target", "0.8", "--yes", sim=IDLE)
    assert ran.status == 6
    assert "CO potentiometer" in ran.err
    assert len(mikas.journal) == 2  # begin and outcome of one write
