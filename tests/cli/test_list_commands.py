"""`mikas list set`, `mikas list read`: what is asked, kept and said."""

from __future__ import annotations

from cli_harness import is_one_short_paragraph, is_russian

from mikas.client import Ecu


def test_set_asks_and_is_journaled(mikas):
    refused = mikas("list", "set", "TWAT", "INJ")
    assert refused.status == 6
    assert "TWAT INJ (1A 3F)" in refused.err
    ran = mikas("list", "set", "twat", "INJ", "--yes", "--json")
    assert (ran.status, ran.object["names"]) == (0, ["TWAT", "INJ"])
    assert [entry["command"] for entry in mikas.journal] == ["CWRITL", "CWRITL"]


def test_names_that_can_not_be_kept_are_said_on_stderr_in_each_run(mikas):
    folder = mikas.home / "state" / "mikas"
    folder.mkdir(parents=True)
    (folder / "units").write_text("in the place of the folder")
    for _ in range(2):
        ran = mikas("list", "set", "TWAT", "INJ", "--yes", "--json")
        assert (ran.status, ran.object["names"]) == (0, ["TWAT", "INJ"])
        assert ran.err.count("can't be saved") == 1
        assert f"{folder / 'units' / 'lists'} (" in ran.err
    is_russian(mikas("list", "set", "TWAT", "--yes", "--lang", "ru").err)


def test_read_gives_what_read_gives(mikas, monkeypatch):
    """A new virtual unit each time: its list is set on the way."""
    read_list = Ecu.read_list

    def set_before(self, *names):
        self.set_list("TWAT", "FREQ")
        return read_list(self, *names)

    monkeypatch.setattr(Ecu, "read_list", set_before)
    listed = mikas("list", "read", "--json").object["readings"]
    read = mikas("read", "TWAT", "FREQ", "--json").object["readings"]
    assert list(listed) == list(read)
    assert all(listed[name].keys() == read[name].keys() for name in read)


def test_reading_a_list_that_is_unknown_or_lost_says_to_set_it(mikas):
    unknown = mikas("list", "read")
    assert unknown.status == 2
    assert "`mikas list set NAME…`" in unknown.err
    is_one_short_paragraph(unknown.err)
    mikas("list", "set", "TWAT", "--yes")
    lost = mikas("list", "read")  # this unit is new, as after a power cycle
    assert lost.status == 5
    assert "`mikas list set` does that" in lost.err
    is_one_short_paragraph(lost.err)
    assert mikas("list", "read").status == 2
    is_russian(mikas("list", "read", "--lang", "ru").err)
    is_russian(mikas("list", "read", "TWAT", "--lang", "ru").err)


def test_a_wrong_name_or_none_is_refused(mikas):
    for argv in (["list"], ["list", "set"], ["list", "set", "NOSUCH"], ["list", "read", "0x1A:9"]):
        assert mikas(*argv).status == 2
