"""Read guided tests from TOML files: the shipped ones, then the user's folder `tests`.

A wrong file is an error with file and line (`CatalogError`); the others still load. docs/
guided-tests.md describes all keys.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from string import Formatter
from typing import Any, Final

from mikas.catalog import Catalog, Derived, Parameter
from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.formula_syntax import Parsed, parse
from mikas.catalog.ignition_only import DEAD, SPEED, WITNESSES
from mikas.catalog.loading.build import does_not_exist
from mikas.catalog.loading.fields import made, read_table, schema_of
from mikas.catalog.loading.source import CatalogFile, KeyPath, own_files, read_source
from mikas.errors import CatalogError, MikasError, UsageError
from mikas.guided.definition import (
    CONSTANTS,
    SECONDS,
    GuidedStep,
    GuidedTest,
    Measure,
    Rule,
    Statistic,
    parameters_of,
)
from mikas.i18n import Text

FOLDER: Final = "tests"
"""The folder of the user's tests, beside the config file."""

_MOST_PARTS: Final = 50  # steps, measures or rules of a test
_WATCHED: Final = 12
_NAME: Final = re.compile(r"[a-z][a-z0-9-]{0,39}")
_PART: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_RULE_TEXTS: Final = ("text", "check", "doubt")


@dataclass(frozen=True, slots=True)
class LoadedTests:
    """The tests by name, and the error of each file that is not one."""

    tests: Mapping[str, GuidedTest]
    errors: tuple[CatalogError, ...] = ()


def load(
    catalog: Catalog, folder: Path | None = None, formula_catalog: Catalog | None = None
) -> LoadedTests:
    """Return the shipped tests and those in the user's `folder`, a later name over an earlier.

    `formula_catalog`: the catalog with the instruments of a session or a recording, for the user's.
    """
    tests = dict(_shipped(catalog))
    files, problems = own_files(folder)
    errors = [*problems]
    for path in files:
        try:
            test = from_source(read_source(path), formula_catalog or catalog, own=True)
        except CatalogError as error:
            errors.append(error)
        else:
            tests[test.name] = test
    return LoadedTests(tests, tuple(errors))


@lru_cache(maxsize=4)
def _shipped(catalog: Catalog) -> Mapping[str, GuidedTest]:
    """Return the shipped tests by name."""
    files = sorted((Path(__file__).parent / "shipped").glob("*.toml"))
    return {test.name: test for test in (from_source(read_source(path), catalog) for path in files)}


def from_source(source: CatalogFile, catalog: Catalog, *, own: bool = False) -> GuidedTest:
    """Return the test in `source`, named as its file. Raises `CatalogError`."""
    return _Builder(source, catalog).test(own=own)


class _Builder:
    """Builds one test, every mistake with its line."""

    def __init__(self, source: CatalogFile, catalog: Catalog) -> None:
        self._source, self._catalog = source, catalog
        self._form = read_table(source, (), source.tables, schema_of(GuidedTest))

    def test(self, *, own: bool) -> GuidedTest:
        form = self._form
        name = self._name()
        for key in ("title", "finds", "step", "measure", "rule"):
            if not form.get(key):
                raise self._source.error((), f"has no `{key}`", f"нет `{key}`")
        for key in ("step", "measure", "rule"):
            self._check_names(key)
        steps = tuple(self._step(each) for each in form["step"])
        measures = {each.upper(): self._measure(each) for each in form["measure"]}
        rules = tuple(self._rule(each, measures) for each in form["rule"])
        start = self._formula(("start",), form.get("start"))
        chart = self._channels(("chart",), form.get("chart", ()))
        named = [start, *(step.until for step in steps)]
        named += [formula for each in measures.values() for formula in each.formulas]
        inputs = [each for formula in named if formula for each in formula.inputs]
        watched = [each for step in steps for each in (*step.watch, *step.targets)]
        needed = self._needed((*inputs, *watched, *chart))
        return GuidedTest(
            name=name,
            title=self._text("title"),
            finds=self._text("finds"),
            minutes=form.get("minutes", 1.0),
            needs=self._text("needs", required=start is not None),
            start=start,
            chart=chart or steps[0].watch[:2],
            any_order=form.get("any_order", False),
            steps=steps,
            measures=measures,
            rules=rules,
            channels=tuple(each for each in needed if each in self._catalog.channels),
            own=own,
            beside=tuple(each for each in needed if each not in self._catalog.channels),
        )

    def _needed(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the channels to sample: those named, and those by which injection is seen."""
        needed = parameters_of(self._catalog, names)
        if DEAD.isdisjoint(needed) or SPEED not in needed:
            return needed
        return tuple(dict.fromkeys((*needed, *WITNESSES)))

    def _name(self) -> str:
        name = Path(self._source.name).stem.lower()
        if _NAME.fullmatch(name):
            return name
        raise self._source.error(
            (),
            "a test's file is named by small Latin letters, digits and hyphens, as my-test.toml",
            "имя файла проверки — строчные латинские буквы, цифры и дефисы: my-test.toml",
        )

    def _check_names(self, kind: str) -> None:
        table = self._form[kind]
        if len(table) > _MOST_PARTS:
            problem = Text(f"has more than {_MOST_PARTS} parts", f"больше {_MOST_PARTS} частей")
            raise self._source.wrong((kind,), problem)
        seen: set[str] = set()
        for name in table:
            if not _PART.fullmatch(name):
                problem = Text(
                    "is no name of Latin letters, digits and _ that begins with a letter",
                    "имя должно состоять из латинских букв, цифр и _ и начинаться с буквы",
                )
                raise self._source.wrong((kind, name), problem)
            if name.upper() in seen:
                raise self._source.wrong((kind, name), Text("is there twice", "есть дважды"))
            seen.add(name.upper())

    def _step(self, name: str) -> GuidedStep:
        path, keys = ("step", name), self._form["step"][name]
        until = self._formula((*path, "until"), keys.get("until"))
        if until is None and not keys.get("hold"):
            problem = Text("needs `until`, or `hold` in seconds", "нужно `until` или `hold`")
            raise self._source.wrong(path, problem)
        targets = {
            self._channel((*path, "target", each), each): ends
            for each, ends in keys.get("target", {}).items()
        }
        watch = self._channels((*path, "watch"), keys.get("watch", ()))
        return made(
            GuidedStep,
            keys,
            name=name,
            text=self._text(*path, "text"),
            until=until,
            by_hand=keys.get("by_hand", until is None),
            advice=self._text(*path, "advice", required=False),
            watch=watch or tuple(targets),
            targets=targets,
        )

    def _measure(self, name: str) -> Measure:
        path, keys = ("measure", name), self._form["measure"][name]
        for key in ("step", "of", "statistic"):
            if key not in keys:
                raise self._source.wrong(path, Text(f"has no `{key}`", f"нет `{key}`"))
        if keys["step"] not in self._form["step"]:
            raise self._missing((*path, "step"), keys["step"], self._form["step"])
        if (keys["statistic"] is Statistic.PERCENTILE) is not ("percentile" in keys):
            problem = Text(
                'goes with `statistic = "percentile"`', 'нужен вместе со `statistic = "percentile"`'
            )
            raise self._source.wrong((*path, "percentile"), problem)
        of = self._formula((*path, "of"), keys["of"])
        unit, decimals, resolution = self._shown(keys["of"], keys["statistic"])
        given = keys.get("unit")
        return made(
            Measure,
            keys,
            name=name.upper(),
            text=self._text(*path, "text"),
            of=of,
            when=self._formula((*path, "when"), keys.get("when")),
            by=self._formula((*path, "by"), keys.get("by")),
            unit=unit if given is None else self._catalog.units.get(given, Text(given, given)),
            decimals=keys.get("decimals", decimals),
            resolution=resolution,
        )

    def _shown(self, formula: str, statistic: Statistic) -> tuple[Text, int, float]:
        """Return unit, decimals and resolution of a measure of one channel."""
        if statistic is Statistic.SECONDS:
            return Text("s", "с"), 1, 0.0
        if statistic is Statistic.SHARE:
            return Text("%", "%"), 0, 0.0
        if statistic is Statistic.TIMES:
            return NO_TEXT, 0, 0.0
        try:
            channel = self._catalog.formula_channel(formula)
        except MikasError:
            return NO_TEXT, 1, 0.0
        resolution = 0.0
        if isinstance(channel, Parameter) and not channel.is_flag:
            resolution = abs(float(channel.conversion.scale))
        if statistic is Statistic.SLOPE:
            unit = channel.unit_text
            return Text(f"{unit.en}/min", f"{unit.ru}/мин"), channel.decimals + 1, 0.0
        return channel.unit_text, channel.decimals, resolution

    def _rule(self, name: str, measures: Mapping[str, Measure]) -> Rule:
        path, keys = ("rule", name), self._form["rule"][name]
        for key in ("when", "verdict"):
            if key not in keys:
                raise self._source.wrong(path, Text(f"has no `{key}`", f"нет `{key}`"))
        when = self._parsed((*path, "when"), keys["when"])
        for each in when.inputs:
            if each not in measures:
                raise self._missing((*path, "when"), each, measures)
        texts = {key: self._text(*path, key, required=key == "text") for key in _RULE_TEXTS}
        for key, text in texts.items():
            self._check_fields((*path, key), text, measures)
        given = {"name": name, "when": when, "formula": keys["when"], "outcome": keys["verdict"]}
        return made(Rule, keys, **given, **texts)

    def _check_fields(self, path: KeyPath, text: Text, known: Mapping[str, object]) -> None:
        """Refuse a field in braces that names no measure, and any format of it."""
        for words in text:
            try:
                fields = [part for part in Formatter().parse(words) if part[1] is not None]
            except ValueError:
                problem = Text("has a single brace", "содержит одиночную скобку")
                raise self._source.wrong(path, problem) from None
            for _, name, form, conversion in fields:
                if form or conversion or name not in known:
                    raise self._missing(path, f"{name}", known)

    def _formula(self, path: KeyPath, text: str | None) -> Parsed | None:
        """Return the formula of channels at `path`; None if there is none."""
        if text is None:
            return None
        parsed = self._parsed(path, text)
        for each in parsed.inputs:
            if each != SECONDS:
                self._channel(path, each)
        return parsed

    def _parsed(self, path: KeyPath, text: str) -> Parsed:
        try:
            return parse(text, CONSTANTS)
        except UsageError as error:
            raise self._source.wrong(path, error.reason) from None

    def _channel(self, path: KeyPath, name: str) -> str:
        """Return the full name of a channel. Raises `CatalogError`."""
        known = self._catalog.formula_channels
        if (found := name.upper()) not in known:
            raise self._missing(path, name, known)
        if isinstance(channel := known[found], Derived) and channel.accumulates:
            problem = Text(
                f"names {found}, a total; a test needs values of the moment",
                f"называет {found} — это сумма; проверке нужны мгновенные значения",
            )
            raise self._source.wrong(path, problem)
        return found

    def _channels(self, path: KeyPath, names: Iterable[str]) -> tuple[str, ...]:
        found = tuple(dict.fromkeys(self._channel(path, name) for name in names))
        if len(found) > _WATCHED:
            problem = Text(f"has more than {_WATCHED} channels", f"больше {_WATCHED} каналов")
            raise self._source.wrong(path, problem)
        return found

    def _missing(self, path: KeyPath, name: str, known: Iterable[str]) -> CatalogError:
        return self._source.wrong(path, does_not_exist(name, known))

    def _text(self, *path: str, required: bool = True) -> Text:
        found: Any = self._form
        for key in path:
            found = found.get(key, {})
        if not found and not required:
            return NO_TEXT
        for language in ("en", "ru"):
            if not found.get(language):
                where = (*path, language) if found else path
                raise self._source.wrong(path, Text(f"has no `{where[-1]}`", f"нет `{where[-1]}`"))
        return Text(found["en"], found["ru"])
