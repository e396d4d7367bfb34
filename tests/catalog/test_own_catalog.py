"""The user's own catalog file: how it is edited, and how it goes with the other files."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog import AlarmLimits, Level, load, shipped
from mikas.catalog.own.changes import remove_channel, reset_keys, set_channel, set_keys
from mikas.catalog.own.editing import with_keys, without
from mikas.catalog.own.file import OwnCatalog, left_out
from mikas.errors import CatalogError, UnknownParameter, UsageError

# Entries in every form that TOML has for them, each with its comments.
FORMS = (
    (
        '# {n}: as a table\n[derived.{n}]  # {n} header\nformula = "FREQ * 2"  # {n} formula\n'
        'text = {{ en = "{n}", ru = "{n}" }}\n\n'
    ),
    (
        '[derived.{n}]\n# {n}: first\ntext = """\n[derived.NOT_ONE]\n# {n} no comment\n"""\n'
        'formula = "FREQ\\n+ 1"\n\n[derived.{n}.limits]\nwarning_high = 5  # {n} limit\n'
    ),
    '[derived]\n{n} = {{ formula = "FREQ", text = "{n}" }}  # {n} inline\n',
    '[derived.{n}.limits]\ndanger_high = 9\n[derived.{n}]\nformula = "FREQ" # {n}\ntext = "{n}"\n',
    'derived.{n}.formula = "FREQ" # {n} dotted\nderived.{n}.text = "{n}"\n',
    "derived.\"{n}\" = {{ formula = 'FREQ', text = '{n}' }} # {n} quoted\n",
)
DOTTED = FORMS[4:]  # only above the first header
HEAD = '# my car\nversion = "my car, 3"  # since May\n'
TAIL = (
    "\n# this car has another thermostat\n[parameter.TWAT]\nreference = [82, 97]\n\n"
    '[fault.55]\ntext.ru = "Датчик скорости"  # не установлен\n'
)
KEYS = st.fixed_dictionaries(
    {},
    optional={
        "formula": st.sampled_from(["JAIR / FREQ", "A\nif FREQ else 0"]),
        "text": st.one_of(
            st.text(st.characters(exclude_categories=["Cs"], exclude_characters="#"), max_size=9),
            st.fixed_dictionaries({"en": st.just("x"), "ru": st.just("ы")}),
        ),
        "decimals": st.one_of(st.none(), st.integers(0, 6)),
        "limits": st.dictionaries(
            st.sampled_from(["warning_high", "danger_high", "hysteresis"]),
            st.one_of(st.none(), st.just(False), st.integers(0, 99), st.sampled_from([0.1, 1e-7])),
        ),
    },
)


@st.composite
def files(draw):
    names = draw(st.lists(st.sampled_from(["AA", "BB", "CC"]), max_size=3, unique=True))
    forms = [draw(st.sampled_from(FORMS)) for _ in names]
    if forms.count(FORMS[2]) > 1:
        forms = [form if form is not FORMS[2] else FORMS[0] for form in forms]
    if FORMS[2] in forms and any(form is not FORMS[2] for form in forms):
        forms = [FORMS[2] if form is FORMS[2] else FORMS[0] for form in forms]
        forms.sort(key=lambda form: form is not FORMS[2])
    parts = sorted(zip(forms, names, strict=True), key=lambda part: part[0] not in DOTTED)
    return HEAD + "".join(form.format(n=name) for form, name in parts) + TAIL


def comments(text: str, *, but: str) -> list[str]:
    """The comments of other entries than `but`."""
    found = (line.partition("#")[2] for line in text.splitlines() if "#" in line)
    return [each for each in found if but not in each]


def merged(table: dict, keys: dict) -> dict:
    for key, value in keys.items():
        if key == "limits":
            inner = merged(dict(table.get(key, {})), value)
            table = {**table, key: inner} if inner else {k: v for k, v in table.items() if k != key}
        elif value is None:
            table = {k: v for k, v in table.items() if k != key}
        else:
            table = {**table, key: value}
    return table


@settings(max_examples=25, deadline=None)
@given(files(), st.sampled_from(["AA", "bb", "NEW"]), KEYS)
def test_a_change_keeps_all_other_entries_and_comments(text: str, name: str, keys: dict) -> None:
    after = with_keys(text, "derived", name, keys)
    wanted, got = tomllib.loads(text), tomllib.loads(after)
    entries = wanted.pop("derived", {})
    changed = merged(entries.pop(name.upper(), {}), keys)
    entries |= {name.upper(): changed} if changed else {}
    assert {key.upper(): entry for key, entry in got.pop("derived", {}).items()} == entries
    assert got == wanted
    assert comments(after, but=name.upper()) == comments(text, but=name.upper())


@settings(max_examples=10, deadline=None)
@given(files(), st.sampled_from(["AA", "bb"]))
def test_a_removed_entry_takes_nothing_with_it(text: str, name: str) -> None:
    before, after = tomllib.loads(text), tomllib.loads(without(text, "derived", name))
    before.get("derived", {}).pop(name.upper(), None)
    assert after.get("derived", {}) == before.pop("derived", {})
    after.pop("derived", None)
    assert after == before
    left = comments(without(text, "derived", name), but=name.upper())
    assert left == comments(text, but=name.upper())


@pytest.fixture
def own(tmp_path: Path) -> OwnCatalog:
    return OwnCatalog(tmp_path / "config" / "catalog.toml")


LIMITS = {"danger_low": None, "warning_low": None, "warning_high": 105.0, "danger_high": 115.0}
LOAD = {
    "formula": "100 * JAIR / full",
    "constants": {"full": 385.0},
    "text": {"en": "Load", "ru": "Нагрузка"},
    "unit": "%",
    "decimals": 1,
    "limits": {**LIMITS, "hysteresis": 2.0},
}


def test_limits_are_written_as_far_as_they_differ(own: OwnCatalog) -> None:
    known = shipped()
    before = known.parameter("TWAT").alarm_limits
    assert before is not None
    same = {key: getattr(before, key) for key in (*LIMITS, "hysteresis")}
    assert set_keys(own, known, "TWAT", {"limits": same}).version == known.version
    assert not own.path.exists()
    changed = set_keys(own, known, "twat", {"limits": {**same, "danger_high": 115.0}})
    limits = changed.parameter("TWAT").alarm_limits
    assert limits is not None
    assert (limits.danger_high, limits.warning_high) == (115, before.warning_high)
    assert tomllib.loads(own.path.read_text("utf-8")) == {
        "parameter": {"TWAT": {"limits": {"danger_high": 115}}}
    }
    none = set_keys(own, changed, "TWAT", {"limits": dict.fromkeys(same)})
    assert none.parameter("TWAT").alarm_limits is None
    assert own.load().catalog.parameter("TWAT").alarm_limits is None
    assert reset_keys(own, none, "TWAT", ["limits"]).parameter("TWAT").alarm_limits == before


def test_scales_references_and_limits_of_flags_can_be_set(own: OwnCatalog) -> None:
    keys = {"gauge": (0.0, 120.5), "reference": (80.0, 97.0), "span_least": 4.0}
    known = set_keys(own, shipped(), "TWAT", keys)
    twat = known.parameter("TWAT")
    assert (twat.gauge, twat.reference, twat.span_least) == ((0, 120.5), (80, 97), 4)
    known = set_keys(own, known, "DET", {"limits": {"when_true": Level.DANGER}})
    assert known.parameter("DET").alarm_limits == AlarmLimits(
        when_true=Level.DANGER, source="catalog.toml"
    )
    known = set_keys(own, known, "TWAT", {"gauge": None})
    assert known.parameter("TWAT").gauge == shipped().parameter("TWAT").gauge
    known = reset_keys(own, known, "TWAT", ["gauge", "reference", "span_least"])
    assert known.parameter("TWAT").reference == shipped().parameter("TWAT").reference
    assert list(own.entries()) == [("parameter", "DET")]


def test_a_formula_that_is_none_is_refused_by_the_reader_of_the_file(own: OwnCatalog) -> None:
    with pytest.raises(CatalogError, match=r"LOAD\.formula` is not a formula"):
        set_channel(own, shipped(), "LOAD", {**LOAD, "formula": "100 * (JAIR"}, new=True)
    assert not own.path.exists()


def test_a_channel_of_ones_own_is_added_changed_and_removed(own: OwnCatalog) -> None:
    known = set_channel(own, shipped(), "load", LOAD, new=True)
    load_ = known.derived["LOAD"]
    assert (load_.formula, load_.constants, load_.unit) == (LOAD["formula"], (("full", 385),), "%")
    assert load_.alarm_limits is not None
    assert load_.alarm_limits.hysteresis == 2
    assert own.load().catalog.version == known.version
    more = {**LOAD, "formula": "LOAD / 2", "constants": {}, "limits": None, "unit": None}
    known = set_channel(own, known, "HALF", more, new=True)
    with pytest.raises(UsageError, match="LOAD is needed by HALF"):
        remove_channel(own, known, "LOAD")
    circle = {**LOAD, "formula": "HALF + 1", "constants": {}}
    with pytest.raises(CatalogError, match="goes in a circle"):
        set_channel(own, known, "LOAD", circle, new=False)
    plain = {**LOAD, "formula": "JAIR", "constants": {}, "limits": None, "decimals": 0}
    known = set_channel(own, known, "LOAD", plain, new=False)
    assert (known.derived["LOAD"].constants, known.derived["LOAD"].alarm_limits) == ((), None)
    known = remove_channel(own, known, "HALF")
    known = remove_channel(own, known, "LOAD")
    assert known.derived.keys() == shipped().derived.keys()
    assert own.path.read_text("utf-8").startswith("# Definitions of your own")


@pytest.mark.parametrize("name", ["TWAT", "FUEL_FLOW", "Ж", "1X", "", "A.B", 'A"'])
def test_a_name_that_can_not_be_a_channel_is_refused(own: OwnCatalog, name: str) -> None:
    with pytest.raises(UsageError):
        set_channel(own, shipped(), name, LOAD, new=True)
    assert not own.path.exists()


def test_what_is_refused_leaves_the_file_as_it_was(own: OwnCatalog, tmp_path: Path) -> None:
    known = set_keys(own, shipped(), "TWAT", {"gauge": (0, 130)})
    before = own.path.read_bytes()
    for keys in ({"gauge": (5, 5)}, {"limits": {"danger_low": 9, "warning_high": 1}}):
        with pytest.raises(CatalogError):
            set_keys(own, known, "TWAT", keys)
    for name in ("NOTHING", "0x1A"):
        with pytest.raises(UnknownParameter):
            set_keys(own, known, name, {"gauge": (0, 1)})
    with pytest.raises(UsageError, match="not a channel of your own"):
        set_channel(own, known, "FUEL_FLOW", LOAD, new=False)
    over = tmp_path / "over.toml"
    over.write_text("[parameter.TWAT]\ngauge = [0, 99]\n", "utf-8")
    below = OwnCatalog(own.path, [over])
    with pytest.raises(UsageError, match="--catalog"):
        set_keys(below, below.load().catalog, "TWAT", {"gauge": (0, 150)})
    assert own.path.read_bytes() == before


def test_a_wrong_own_file_is_left_out_with_its_problem(own: OwnCatalog, tmp_path: Path) -> None:
    own.path.parent.mkdir()
    own.path.write_bytes(b"[parameter.TWAT]\r\nreference = [82, 97]\r\nlimit = 3\r\n")
    loaded = own.load()
    assert loaded.catalog.version == shipped().version
    assert loaded.problem is not None
    assert (loaded.problem.file, loaded.problem.line) == (str(own.path), 3)
    said = left_out(loaded.problem)
    assert said.en.startswith(f"Your own catalog was left out: {own.path}:3: ")
    assert said.ru.startswith(f"Ваш каталог не подключён: {own.path}:3: ")
    with pytest.raises(CatalogError, match=r"catalog\.toml:3"):
        set_keys(own, loaded.catalog, "TWAT", {"gauge": (0, 150)})
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("[parameter.TWAT]\nlimit = 3\n", "utf-8")
    with pytest.raises(CatalogError, match=r"wrong\.toml:2"):
        OwnCatalog(own.path, [wrong]).load()
    # Mended, it keeps its line ends; and by a link it stays where it is.
    own.path.write_bytes(b"[parameter.TWAT]\r\nreference = [82, 97] # mine\r\n")
    set_keys(own, own.load().catalog, "TWAT", {"span_least": 7.0})
    assert own.path.read_bytes().count(b"\r\n") == own.path.read_bytes().count(b"\n") == 3
    assert load(own.path).parameter("TWAT").span_least == 7
    big = OwnCatalog(tmp_path / "big.toml")
    big.path.write_text("#" * 300_000, "utf-8")
    with pytest.raises(CatalogError, match="larger than 256 KB"):
        set_keys(big, shipped(), "TWAT", {"gauge": (0, 150)})


def test_a_file_that_can_not_be_read_or_written_is_named(
    own: OwnCatalog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert own.load().catalog.version == shipped().version
    known = set_channel(own, shipped(), "LOAD", LOAD, new=True)
    before = own.path.read_bytes()
    assert own.change(lambda text: text).version == known.version
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("[parameter.TWAT]\nlimit = 3\n", "utf-8")
    with pytest.raises(CatalogError, match=r"wrong\.toml:2"):
        OwnCatalog(own.path, [wrong]).load()
    (tmp_path / "latin.toml").write_bytes(b"# \xff\n")
    assert OwnCatalog(tmp_path / "latin.toml").entries() == {}
    for path in (tmp_path, tmp_path / "latin.toml"):
        with pytest.raises(CatalogError) as refused:
            OwnCatalog(path).change(lambda text: text + "# more\n")
        assert refused.value.file == str(path)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    nowhere = OwnCatalog(tmp_path / ("n" * 300) / "catalog.toml").load()  # no such name can exist
    assert nowhere.catalog.version == shipped().version
    assert nowhere.problem is not None
    monkeypatch.setattr("mikas.catalog.own.file.save", full)
    with pytest.raises(CatalogError, match=r"catalog\.toml: No space left"):
        set_keys(own, known, "LOAD", {"limits": {**LIMITS, "danger_high": 120.0}})
    assert own.path.read_bytes() == before


def test_an_entry_of_a_form_that_tomlkit_does_not_master_is_left_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = "[parameter.TWAT]\nreference = [82, 97]"
    assert with_keys(text, "parameter", "TWAT", {"decimals": 1}) == f"{text}\ndecimals = 1\n"
    with pytest.raises(CatalogError) as refused:
        with_keys("[parameter.TWAT\n", "parameter", "TWAT", {"decimals": 1}, file="own.toml")
    assert (refused.value.file, refused.value.line) == ("own.toml", 1)

    def raising(*_: object, **__: bool) -> str:
        raise TypeError

    for way in (raising, lambda *_, **__: "decimals = 1\n", lambda *_, **__: "no TOML"):
        monkeypatch.setattr("mikas.catalog.own.editing._by_tomlkit", way)
        with pytest.raises(CatalogError) as refused:
            with_keys(text, "parameter", "TWAT", {"reference": [1, 2]}, file="own.toml")
        assert (refused.value.file, refused.value.line) == ("own.toml", 2)


def test_catalogs_are_compared_by_the_values_that_they_make(own: OwnCatalog) -> None:
    known = set_channel(own, shipped(), "LOAD", LOAD, new=True)
    other = set_channel(own, known, "LOAD", {**LOAD, "decimals": 3}, new=False)
    assert {"LOAD", "TWAT"} < known.same_channels(other)
    assert "LOAD" not in known.same_channels(shipped())
    other = set_channel(own, known, "LOAD", {**LOAD, "formula": "JAIR", "constants": {}}, new=False)
    assert "LOAD" not in known.same_channels(other)
