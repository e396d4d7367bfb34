"""Common options, the environment and the config file: where each may stand, and which one wins."""

from __future__ import annotations

import pytest

SIM = "sim:?clock=simulated"
FIVE = SIM + "&model=5.4"


def model(ran) -> str:
    assert ran.status == 0, ran.err
    return ran.object["model"]


@pytest.mark.parametrize(
    "argv",
    [
        ["--port", FIVE, "--json", "info", "--quick"],
        ["info", "--quick", "--json", "--port", FIVE],
        ["--json", "info", "--port=" + FIVE, "--quick"],
        ["--port", SIM, "info", "--quick", "--json", "--port", FIVE],
        ["--port", SIM, "--json", "info", "--port", SIM, "--quick", "--port", FIVE],
    ],
)
def test_an_option_stands_before_or_after_the_command_and_the_last_one_wins(mikas, argv):
    assert model(mikas(*argv)) == "Mikas 5.4"


@pytest.mark.parametrize("place", [0, 1, 2])
def test_options_stand_at_each_place_of_a_memory_command(mikas, place):
    argv = ["mem", "read", "ram", "40"]
    argv[place:place] = ["--json", "--port", SIM]
    assert mikas(*argv, sim="&lost=1").object["space"] == "ram"


def test_the_command_line_wins_over_the_environment_and_that_over_the_file(mikas):
    config(mikas, f'port = "{SIM}&supplied=0"')
    assert model(mikas("info", "--quick", "--json", sim="")) == "Mikas 7.1"
    assert model(mikas("info", "--quick", "--json", "--port", FIVE, sim="&lost=1")) == "Mikas 5.4"


def test_the_config_file_sets_port_timing_and_interpretation(mikas, monkeypatch):
    monkeypatch.delenv("MIKAS_PORT")
    config(
        mikas, f'port = "{FIVE}"\ntimeout = 1\nretries = 0\necho = "on"\ninterpretation = "literal"'
    )
    assert model(mikas("info", "--quick", "--json")) == "Mikas 5.4"


def test_the_environment_names_another_config_file(mikas, monkeypatch, tmp_path):
    monkeypatch.delenv("MIKAS_PORT")
    file = tmp_path / "elsewhere.toml"
    file.write_text(f'port = "{FIVE}"', "utf-8")
    monkeypatch.setenv("MIKAS_CONFIG", str(file))
    assert model(mikas("info", "--quick", "--json")) == "Mikas 5.4"


def test_an_empty_port_in_the_environment_is_none(mikas, monkeypatch):
    monkeypatch.setenv("MIKAS_PORT", " ")
    config(mikas, f'port = "{FIVE}"')
    assert model(mikas("info", "--quick", "--json")) == "Mikas 5.4"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("port = ", "not TOML"),
        ("prot = 'COM3'", "no setting “prot”"),
        ("port = 3", "port has to be"),
        ("port = ''", "port has to be"),
        ("echo = 'maybe'", "auto, on, off"),
        ("echo = true", "auto, on, off"),
        ("interpretation = 'other'", "corrected, literal, alternative, family"),
        ("lang = 'de'", "en, ru"),
        ("timeout = 'long'", "seconds"),
        ("timeout = true", "seconds"),
        ("timeout = 0", "seconds"),
        ("timeout = nan", "seconds"),
        ("inter_byte = '0.2'", "seconds"),
        ("inter_byte = 0.0005", "0.001 … 60"),
        ("pause = -0.1", "0 … 2"),
        ("pause = 3", "0 … 2"),
        ("pause = true", "0 … 2"),
        ("pause = 'long'", '"auto" or seconds'),
        ("checksum = 'maybe'", "stuffed, raw"),
        ("checksum = true", "stuffed, raw"),
        ("strict = 1", "true or false"),
        ("strict = 'yes'", "true or false"),
        ("retries = 1.5", "whole number"),
        ("retries = -1", "whole number"),
        ("catalog = 'my.toml'", "list of files"),
        ("catalog = [1]", "list of files"),
        (r'catalog = ["a\u0000b"]', "list of files"),
        ("[port]\na = 1", "port has to be"),
    ],
)
def test_a_wrong_config_file_says_where_and_what(mikas, text, message):
    file = config(mikas, text)
    for argv in (["params"], ["read", "TWAT"]):
        ran = mikas(*argv)
        assert (ran.status, ran.out) == (2, "")
        assert str(file) in ran.err
        assert message in ran.err
        assert len(ran.err.splitlines()) == 1
    ran = mikas("--json", "info")
    assert (ran.status, ran.err) == (2, "")
    assert str(file) in ran.object["error"]["message"]
    assert message in ran.object["error"]["message"]
    assert mikas("--help").status == 0


def test_a_config_file_that_is_not_utf_8_is_an_error(mikas):
    file = config(mikas, "")
    file.write_bytes(b"port = '\xff\xfe'")
    ran = mikas("params")
    assert (ran.status, "UTF-8" in ran.err) == (2, True)


def test_a_relative_catalog_is_beside_the_config_file(mikas):
    file = config(mikas, 'catalog = ["mine.toml"]')
    (file.parent / "mine.toml").write_text(OWN, "utf-8")
    assert mikas("read", "BARO", "--json").object["readings"]["BARO"]["unit"] == "kPa"


SUM_0D, SUM_40 = "6192", "615F"  # bodies whose checksum is 0D, 40


@pytest.mark.parametrize(
    ("file", "argv", "sent"),
    [
        ("", [], "61 92 40 CD 0D"),
        ("", ["--checksum", "raw"], "61 92 0D 0D"),
        ("checksum = 'raw'", [], "61 92 0D 0D"),
        ("checksum = 'raw'", ["--checksum", "stuffed"], "61 92 40 CD 0D"),
    ],
)
def test_the_checksum_of_a_request_has_the_form_that_is_set(mikas, file, argv, sent):
    """D3."""
    if file:
        config(mikas, file)
    mikas("raw", SUM_0D, "--capture", "x.pcapng", *argv)
    assert sent.replace(" ", "") in wires(mikas)


def test_a_unit_that_takes_a_raw_checksum_only_is_read_with_that_setting(mikas, monkeypatch):
    """D3: as a receiver that knows no stuffing in the checksum."""
    from mikas.virtual.ecu import VirtualEcu

    receive = VirtualEcu.receive

    def only_raw(self, data, now):
        return receive(self, data.replace(b"\x40\x00\x0d", b"\x00\x0d"), now)

    monkeypatch.setattr(VirtualEcu, "receive", only_raw)
    ran = mikas(
        "raw", SUM_40, "--capture", "x.pcapng", "--checksum", "raw", "--json", sim="&unknown=01"
    )
    assert ran.object["response"] == "01"
    assert "615F400D" in wires(mikas)


IRREGULAR = b"\x40\x3d\x83\x0d"  # 7D of TWAT, 85 °C, as 40 + 3D


@pytest.mark.parametrize(
    ("file", "argv", "damaged"),
    [
        ("", [], False),
        ("", ["--strict"], True),
        ("strict = true", [], True),
        ("strict = true", ["--no-strict"], False),
    ],
)
def test_an_irregular_escape_is_damage_only_if_strict(mikas, monkeypatch, file, argv, damaged):
    """D4."""
    from mikas.virtual import ecu

    encode = ecu.encode
    monkeypatch.setattr(
        ecu, "encode", lambda body, **form: encode(body, **form) if body == b"\x0a" else IRREGULAR
    )
    if file:
        config(mikas, file)
    for command in (["raw", "611A"], ["watch", "TWAT", "--count", "1", "--method", "single"]):
        ran = mikas(*command, "--json", *argv)
        assert ("damaged" in ran.err + ran.out) is damaged, (command, ran)


@pytest.mark.parametrize(
    ("file", "argv", "status"),
    [
        ("", [], 0),
        ("", ["--inter-byte", "0,01"], 4),
        ("inter_byte = 0.01", [], 4),
        ("inter_byte = 0.01", ["--inter-byte", "0.2"], 0),
    ],
)
def test_the_longest_pause_inside_a_response_can_be_set(mikas, file, argv, status):
    """D14: several pauses of 10 to 60 ms inside a response of 44 ms."""
    if file:
        config(mikas, file)
    many = ",".join(map(str, range(1, 21)))
    ran = mikas(
        "faults", *argv, "--retries", "0", sim=f"&faults={many}&stall_every=0.01&stall_ms=60"
    )
    assert ran.status == status, ran.err


@pytest.mark.parametrize(
    ("file", "argv", "pause"),
    [
        ("", [], 0.1),
        ("", ["--pause", "auto"], 0.1),
        ("", ["--pause", "0,15"], 0.15),
        ("pause = 0.15", [], 0.15),
        ("pause = 0.15", ["--pause", "AUTO"], 0.1),
        ("pause = 'auto'", ["--pause", "0.2"], 0.2),
    ],
)
def test_the_pause_before_a_request_is_set_or_found(mikas, file, argv, pause):
    """D14."""
    if file:
        config(mikas, file)
    ran = mikas("info", "--quick", "--json", *argv, sim="&least_pause=0.1")
    assert ran.status == 0, ran.err
    assert ran.object["pause"] == pause
    assert ran.object["limits"]["pause"] == (0.1 if pause == 0.1 else 0)
    assert f"{pause * 1000:g} ms between" in mikas("info", *argv, sim="&least_pause=0.1").out


def wires(mikas) -> list[str]:
    """The bytes of each frame that the capture holds."""
    return [it.get("wire", "") for it in mikas("decode", "x.pcapng", "--json").objects]


@pytest.mark.parametrize(
    ("argv", "environment", "file", "russian"),
    [
        ([], {"LANG": "C.UTF-8"}, "", False),
        ([], {"LANG": "ru_RU.UTF-8"}, "", True),
        ([], {"LANG": "ru_RU.UTF-8", "LC_ALL": "C"}, "", False),
        ([], {"LANG": "en_GB.UTF-8", "LC_MESSAGES": "ru_RU"}, "", True),
        ([], {"LANG": "ru_RU.UTF-8", "MIKAS_LANG": "en"}, "", False),
        ([], {"MIKAS_LANG": "ru"}, "", True),
        ([], {"LANG": "de_DE.UTF-8"}, "", False),
        ([], {"LANG": "C"}, "lang = 'ru'", True),
        ([], {"LANG": "C", "MIKAS_LANG": "en"}, "lang = 'ru'", False),
        (["--lang", "ru"], {"MIKAS_LANG": "en"}, "lang = 'en'", True),
        (["--lang=ru"], {}, "", True),
        (["--lang", "en"], {"LANG": "ru_RU.UTF-8"}, "lang = 'ru'", False),
        (["--lang", "ru", "--lang", "en"], {}, "", False),
    ],
)
def test_the_language_follows_option_environment_and_file(
    mikas, monkeypatch, argv, environment, file, russian
):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    if file:
        config(mikas, file)
    for command in (["--help"], ["params", "--help"], ["params"], ["read", "TWAAT"]):
        for line in (argv + command, command + argv):
            ran = mikas(*line)
            message = ran.out + ran.err
            assert any("а" <= letter <= "я" for letter in message) is russian, message


def test_the_interpretation_of_a_value_can_be_chosen(mikas):
    corrected = mikas("read", "UACC", "--json").object["readings"]["UACC"]
    literal = mikas("read", "UACC", "--interpretation", "literal", "--json").object["readings"][
        "UACC"
    ]
    assert corrected["value"] > 13
    assert literal["value"] < 0
    assert mikas("params", "--interpretation", "literal").out != mikas("params").out


OWN = """
[parameter.BARO]
code = 0x1A
size = 1
scale = 0.5
unit = "kPa"
text.en = "Pressure"
text.ru = "Давление"
source = "own"
confidence = "unconfirmed"
"""


def test_a_parameter_of_ones_own_is_listed_and_read(mikas, tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(OWN, "utf-8")
    names = {
        p["name"] for p in mikas("params", "--catalog", "own.toml", "--json").object["parameters"]
    }
    assert "BARO" in names
    reading = mikas("--catalog", "own.toml", "read", "BARO", "--json").object["readings"]["BARO"]
    assert (reading["unit"], reading["value"]) == ("kPa", int(reading["raw"], 16) / 2)
    assert "BARO" in mikas("watch", "--count", "1", "--catalog", "own.toml").lines[0]


def test_a_broken_catalog_says_file_and_line(mikas, tmp_path):
    (tmp_path / "bad.toml").write_text(OWN + "\ncolour = 3\n", "utf-8")
    for argv in (["params"], ["read"], ["decode", "bad.toml"]):
        ran = mikas(*argv, "--catalog", "bad.toml")
        assert (ran.status, ran.out) == (2, "")
        assert "bad.toml:12:" in ran.err
    ran = mikas("params", "--catalog", "absent.toml", "--lang", "ru")
    assert ran.status == 2
    assert ran.err.startswith("absent.toml: файл не читается: нет такого файла")


def test_v_prints_the_port_and_the_same_values(mikas):
    quiet, loud = mikas("read", "TWAT"), mikas("read", "TWAT", "-v")
    assert quiet.out.split("\t")[0] == loud.out.split("\t")[0]
    assert "sim:?clock=simulated" not in quiet.err
    assert "sim:?clock=simulated" in loud.err


def config(mikas, text: str):
    file = mikas.home / "config" / "mikas" / "config.toml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, "utf-8")
    return file


def test_the_own_catalog_beside_the_config_file_is_used(mikas, monkeypatch, tmp_path):
    monkeypatch.setenv("MIKAS_CONFIG", str(tmp_path / "config.toml"))
    own = tmp_path / "catalog.toml"
    own.write_text('[derived.DOUBLE]\nformula = "FREQ * 2"\ntext = "Double"\n', "utf-8")
    derived = mikas("params", "--json").object["derived"]
    assert (derived[-1]["name"], derived[-1]["source"]) == ("DOUBLE", "catalog.toml")
    over = tmp_path / "over.toml"
    over.write_text('[derived.DOUBLE]\nformula = "FREQ * 3"\n', "utf-8")
    derived = mikas("params", "--json", "--catalog", str(over)).object["derived"]
    assert derived[-1]["formula"] == "FREQ * 3"
    # A wrong one is left out with a note, and no command is useless.
    own.write_text('[derived.DOUBLE]\nformula = "FREQ %"\ntext = "Double"\n', "utf-8")
    shown = mikas("params", "--json")
    assert shown.status == 0
    assert f"{own}:2" in shown.err
    assert shown.object["derived"][-1]["name"] != "DOUBLE"
