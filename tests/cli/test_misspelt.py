"""Misspelt commands, options and values: the nearest is named, in both languages."""

from __future__ import annotations

import pytest
from cli_harness import is_one_short_paragraph, is_russian


@pytest.mark.parametrize(
    ("line", "nearest"),
    [
        ("raed", "Did you mean read?"),
        ("version", "Did you mean mikas --version?"),
        ("mem dumb", "Did you mean dump?"),
        ("-help", "There is no option -help. Did you mean --help?"),
        ("-port sim: read", "There is no option -port. Did you mean --port?"),
        ("read -port=sim:", "There is no option -port. Did you mean --port?"),
        ("read -x", "There is no option -x. Help"),
        ("read -vx", "There is no option -x. Help"),
        ("read --por sim:", "There is no option --por. Did you mean --port?"),
        ("watch --method strem", "Did you mean stream?"),
        ("read --echo of", "Did you mean off?"),
        ("causes --complaint hnuts", "Did you mean hunts?"),
        ("mem read rma 0", "Did you mean ram?"),
        ("faults earse", "the only value is erase"),
        ("demo --no-browser --scenario ctiy", "There is no scenario and no file “ctiy”"),
        ("sim --scenario ctiy", "Did you mean city?"),
        ("decode drvie.pcapng", "Did you mean drive.pcapng?"),
        ("mem diff drive.pcapng nowhere/drive.pcapng", "there is no file “nowhere/drive.pcapng”."),
        ("read TWAAT", "Did you mean TWAT"),
        ("read --port smi:", "Did you mean sim:?"),
    ],
)
def test_the_nearest_is_named(mikas, tmp_path, line, nearest):
    (tmp_path / "drive.pcapng").touch()
    english, russian = mikas(*line.split()), mikas(*line.split(), "--lang", "ru")
    assert (english.status, english.out) == (2, "")
    assert nearest in english.err
    assert "Invalid port" not in english.err or "--port" in line
    is_one_short_paragraph(english.err)
    is_russian(russian.err)


def test_a_missing_value_is_shown_by_an_example(mikas):
    for line in ("log", "mem dump ram", "export a.pcapng", "write", "publish", "fleet sql"):
        ran = mikas(*line.replace("a.pcapng", __file__).split())
        assert ran.status == 2
        assert f"For example: mikas {line.split()[0]} " in ran.err
        is_one_short_paragraph(ran.err)
    error = mikas("log", "--json").object["error"]
    assert error["advice"] == ["For example: mikas log -o drive.pcapng.", "Help: mikas log --help"]
