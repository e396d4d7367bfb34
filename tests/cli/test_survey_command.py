"""`mikas survey`: what it asks, shows, writes and keeps."""

from __future__ import annotations

import json
from pathlib import Path

from mikas.survey import read_survey

STANDING = "&scenario=survey"


def survey(mikas, *words, sim=STANDING):
    return mikas("survey", "-o", "unit.zip", *words, sim=sim)


def test_a_survey_without_questions(mikas):
    ran = survey(mikas, "--yes", "--json", "--voltmeter", "12.5", "--memory")
    assert ran.status == 0, ran
    assert ran.object["out"] == "unit.zip"
    steps = {step["name"]: step for step in ran.object["steps"]}
    assert steps["echo"]["ok"] is True
    assert steps["stream_end"]["clauses"] == ["D12"]
    assert steps["uacc_scale"]["verdict"] == "found"
    assert steps["long_list"]["ok"] is None
    assert ran.object["seconds"].keys() >= {"codes", "lists", "strokes", "samples_raised"}
    content = read_survey(Path("unit.zip"))
    assert [answer.id for answer in content.answers] == list(steps)
    assert content.unit["passports"] is None
    assert content.unit["counted_blocks"] is False


def test_a_survey_without_the_engine_in_russian(mikas):
    ran = survey(mikas, "--yes", "--without-engine", "--lang", "ru")
    assert ran.status == 0
    assert "эхо адаптера\tD1\tнайдено\tадаптер возвращает посланное" in ran.out
    assert "не спрошено\tобследование сделано без пуска двигателя" in ran.out
    assert "unit.zip: найдено ответов" in ran.err
    assert "файл не отправляйте" in ran.err


def test_the_file_of_a_real_unit_is_asked_for(mikas, monkeypatch):
    monkeypatch.setattr("mikas.survey.survey.NO_UNITS", frozenset())
    ran = survey(mikas, "--yes", "--without-engine")
    assert "Send the file with an issue" in ran.err
    assert "don't send" not in ran.err


def test_it_asks_for_consents_figures_and_whether_to_save(mikas):
    mikas.answers("y\n", "д\n", "twelve\n", "99\n", "12,5 V\n", "y\n")
    ran = survey(mikas, "--without-engine")
    assert ran.status == 0, ran
    assert ran.err.index("May memory be read") < ran.err.index("May the texts")
    assert "“twelve” is no number from 6 to 18 V" in ran.err
    assert "“99” is no number" in ran.err
    assert "Save it as unit.zip? [y/N]" in ran.err
    content = read_survey(Path("unit.zip"))
    assert content.measured["voltage"]["meter"] == 12.5
    assert content.unit["passports"][0] == "МИКАС 7.1"
    assert content.unit["max_block"] == 255


def test_consent_is_not_taken_for_granted(mikas):
    """Enter alone, or the end of input, is no."""
    mikas.answers("\n")
    assert survey(mikas, "--without-engine").status == 6  # and not saved: no answer is no yes
    state = json.loads(Path("unit.zip.part/state.json").read_text("utf-8"))
    assert state["measured"]["memory"] is state["measured"]["passports_consent"] is False


def test_a_survey_that_is_not_saved_is_kept_and_goes_on(mikas):
    mikas.answers("n\n", "n\n", "12.5\n", "n\n")
    ran = survey(mikas, "--without-engine")
    assert ran.status == 6
    assert "stays in unit.zip.part; remove that folder to forget it" in ran.err
    assert not Path("unit.zip").exists()
    again = survey(mikas, "--yes", "--without-engine")
    assert again.status == 0
    assert "goes on: unit.zip.part" in again.err
    assert "codes 00–FF" not in again.err
    assert read_survey(Path("unit.zip")).measured["voltage"]["meter"] == 12.5


def test_a_terminal_that_is_gone_stops_it_as_ctrl_c_does(mikas, monkeypatch):
    class Gone:
        def isatty(self) -> bool:
            return True

        def readline(self) -> str:
            raise OSError(5, "Input/output error")

    mikas.answers("n\n", "n\n", "12.5\n", "n\n")
    assert survey(mikas, "--without-engine").status == 6
    monkeypatch.setattr("sys.stdin", Gone())
    assert survey(mikas, "--without-engine").status == 130
    assert survey(mikas, "--yes").status == 0


def test_without_a_terminal_and_without_yes_nothing_is_sent(mikas):
    ran = survey(mikas)
    assert ran.status == 6
    assert "--yes" in ran.err
    assert not Path("unit.zip.part").exists()


def test_an_existing_file_is_kept_unless_overwrite(mikas):
    Path("unit.zip").write_text("mine")
    ran = survey(mikas, "--yes", "--without-engine")
    assert ran.status == 2
    assert "exists already" in ran.err
    assert Path("unit.zip").read_text() == "mine"
    assert survey(mikas, "--yes", "--without-engine", "--overwrite").status == 0
    assert read_survey(Path("unit.zip")).answers


def test_an_engine_that_is_not_stopped_ends_it(mikas):
    ran = survey(mikas, "--yes", sim="&scenario=warm-idle")
    assert ran.status == 6
    assert "the engine was not stopped within 5 minutes" in ran.err
    assert "goes on from there" in ran.err


def test_a_key_turned_off_is_no_bug(mikas):
    """The unit is gone in the middle: an error of the connection, and the same command goes on."""
    ran = survey(mikas, "--yes", "--without-engine", sim="&scenario=key-off")
    assert ran.status in {3, 4, 6}, ran
    assert "the same command goes on from there" in ran.err.replace("\n", " ")
    again = survey(mikas, "--yes", "--without-engine")
    assert again.status == 0


def test_figures_that_no_car_has_are_refused_before_anything_is_sent(mikas):
    ran = survey(mikas, "--yes", "--voltmeter", "124")
    assert ran.status == 2
    assert "--voltmeter 124: it must be from 6 to 18 V" in ran.err
    assert survey(mikas, "--yes", "--starter", "200", "--lang", "ru").status == 2
    assert not Path("unit.zip.part").exists()


def test_a_consent_that_comes_too_late_is_said_to_be(mikas):
    mikas.answers("n\n", "n\n", "12.5\n", "n\n")
    assert survey(mikas, "--without-engine").status == 6
    again = survey(mikas, "--yes", "--memory", "--passports")
    assert again.status == 0
    assert "It was begun without --memory, and stays so" in again.err
    assert "It was begun without --passports, and stays so" in again.err
    assert read_survey(Path("unit.zip")).unit["passports"] is None


def test_an_engine_that_the_unit_does_not_show_is_not_taken_to_run(mikas):
    """With --yes there is no person who says that it runs."""
    ran = survey(mikas, "--yes", "--json", sim="&scenario=survey&lacking=29%2B2C")
    assert ran.status == 0, ran
    steps = {step["name"]: step for step in ran.object["steps"]}
    assert steps["strokes"]["verdict"] == "not-asked"
    assert "no person has said so" in steps["strokes"]["detail"]
    assert "7F" not in read_survey(Path("unit.zip")).unit["missing"]


def test_nothing_is_said_to_be_kept_where_its_folder_can_not_be_made(mikas):
    Path("unit.zip.part").write_text("mine")
    ran = survey(mikas, "--yes", "--without-engine")
    assert ran.status not in {0, 1}, ran
    assert "unit.zip.part" in ran.err
    assert "kept" not in ran.err
    assert Path("unit.zip.part").read_text() == "mine"
