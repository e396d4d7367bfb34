"""`mikas pull` on a recording of made pulls."""

from __future__ import annotations

from drives.drive_rig import Road, Session, Unit, recorded


def rise(begin):
    return [
        Unit(begin + at / 20, round((2000 + 15 * at) / 40) * 40, throttle=90) for at in range(201)
    ]


def test_pull_prints_the_best_figures_and_a_row_each_250_rpm(mikas, tmp_path):
    recorded(tmp_path / "a.pcapng", Session([*rise(1.0), *rise(20.0)]))
    ran = mikas("pull", "a.pcapng", "--mass", "1600", "--per-1000", "24", "--json")
    assert ran.status == 0
    first, second = ran.object["pulls"]
    assert first["per_1000"] == 24.0
    assert first["speed_from"] == "FREQ"
    assert second["begin"] - first["begin"] > 15
    power = max(first["points"], key=lambda point: point["power"])
    text = mikas("pull", "a.pcapng", "--mass", "1600", "--per-1000", "24")
    assert f"{power['power']:.0f} ± {power['doubt']:.0f} kW" in text.lines[0]
    assert text.lines[0].startswith("2000 to 5000 rpm in 9.9 s, ")  # the rise, not its points
    assert text.lines[1].split("\t") == ["rpm", "km/h", "kW", "hp", "Nm"]
    assert len(text.lines) == 2 * (2 + len(first["points"])) + 1
    heavier = mikas("pull", "a.pcapng", "--mass", "3200", "--per-1000", "24", "--json")
    assert heavier.object["pulls"][0]["points"][0]["power"] > 1.8 * first["points"][0]["power"]
    mikas.speaks("ru")
    assert "На колёсах" in mikas("pull", "a.pcapng", "--mass", "1600", "--per-1000", "24").out


def test_pull_says_what_it_needs(mikas, tmp_path):
    recorded(tmp_path / "a.pcapng", Session(rise(1.0)))
    for wrong, problem in (
        ((), "--mass is missing"),
        (("--mass", "0"), "from 400 to 20000"),
        (("--mass", "1.6"), "Mass with driver and load, kg: 1.6"),
        (("--mass", "1e9"), "from 400 to 20000"),
        (("--mass", "nan"), "it must be a number"),
        (("--mass", "1600", "--per-1000", "9999"), "Speed at 1000 rpm, km/h: 9999"),
        (("--mass", "1600"), "--per-1000 KM/H"),
        (("--mass", "1600", "--per-1000", "24", "--slope", "45"), "Slope, %: 45"),
    ):
        ran = mikas("pull", "a.pcapng", *wrong)
        assert ran.status == 2
        assert problem in ran.err
    recorded(tmp_path / "b.pcapng", Session([Unit(at / 4, 800) for at in range(40)]))
    ran = mikas("pull", "b.pcapng", "--mass", "1600", "--per-1000", "24")
    assert (ran.status, ran.out) == (0, "")
    assert "There is no pull" in ran.err


def test_a_gear_that_seems_to_change_is_said(mikas, tmp_path):
    road = [Road(at / 5, 60 + at / 5) for at in range(5, 56)]
    recorded(tmp_path / "a.pcapng", Session(rise(1.0), road))
    ran = mikas("pull", "a.pcapng", "--mass", "1600")
    assert "slips" in ran.err


def test_a_throttle_that_was_not_recorded_is_said(mikas, tmp_path):
    """Each rise is taken for a pull then, with the throttle half closed, too."""
    recorded(tmp_path / "a.pcapng", Session([Unit(it.time, it.rpm) for it in rise(1.0)]))
    ran = mikas("pull", "a.pcapng", "--mass", "1600", "--per-1000", "24")
    assert ran.lines
    assert "THR) was not recorded" in ran.err
    ran = mikas("pull", "a.pcapng", "--mass", "1600", "--per-1000", "24", "--json")
    assert ran.object["pulls"][0]["throttle_known"] is False
    recorded(tmp_path / "b.pcapng", Session(rise(1.0)))
    ran = mikas("pull", "b.pcapng", "--mass", "1600", "--per-1000", "24", "--json")
    assert (ran.err, ran.object["pulls"][0]["throttle_known"]) == ("", True)
