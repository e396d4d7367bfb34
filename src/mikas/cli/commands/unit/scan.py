"""`mikas scan`: which codes the unit answers to 61, and a catalog file to start from."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from pathlib import Path

from mikas.catalog import Catalog
from mikas.catalog.starter import names_of, starter_catalog
from mikas.cli.click_extensions import OVERWRITE, command, output_option
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language, localized, tr
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import check_writable
from mikas.cli.render.output import progress
from mikas.cli.render.values import unit_text, value_text
from mikas.client import Answer, Ecu, ScannedCode
from mikas.client.identity import count_parameters
from mikas.client.parameters.readings import decode
from mikas.commands import ReadUnknownSize
from mikas.errors import (
    NotSupported,
    naming_file,
)
from mikas.i18n import plural
from mikas.saving import save

_CODES = 0x100


@command(
    en="Requests every code 00–FF by command 61 and shows which of them the unit answers, with "
    "size and value, beside the number that command 60 promises. A silent code takes about "
    "2 s, all of them about ten minutes (--timeout 0.2 or --retries 0 shorten that). Changes "
    "nothing in the unit. Ctrl-C shows the codes found so far.",
    ru="Запрашивает командой 61 все коды 00–FF и показывает, на какие из них блок отвечает, с "
    "размером и значением, рядом с числом, которое обещает команда 60. Код без ответа "
    "занимает около 2 с, все — около десяти минут (быстрее: --timeout 0.2 или --retries 0). "
    "В блоке ничего не меняет. Ctrl-C показывает найденное.",
    examples=("mikas scan", "mikas scan -o mine.toml", "mikas scan --retries 0 --json"),
)
@output_option(
    endings=["toml"],
    required=False,
    en="write the unknown codes to OUT, a catalog file for --catalog",
    ru="записать неизвестные коды в OUT, файл каталога для --catalog",
)
@OVERWRITE
@RELEARN
def scan(context: CommandContext, out: Path | None, *, overwrite: bool) -> None:
    if out is not None:
        check_writable(out, overwrite=overwrite)
    found: dict[int, ScannedCode] = {}
    with context.ecu() as ecu:
        heading = [] if out is None else _heading(ecu)
        promised = count_parameters(ecu.tester)
        longest = ceil(_CODES * _silence(ecu) / 60)
        context.say(
            f"Requesting {_CODES} codes: up to {longest} min if the unit is silent to the unknown. "
            "Ctrl-C shows the codes found so far.",
            f"Запрос кодов ({_CODES}): до {longest} мин, если на неизвестные блок молчит. Ctrl-C "
            "покажет найденное.",
        )
        try:
            _request_all(ecu, found)
        finally:  # also after Ctrl-C or a lost adapter
            _show(context, ecu.catalog, found, promised)
            if out is not None:
                _write(context, out, ecu.catalog, found, heading)
        if {each.answer for each in found.values()} <= {Answer.SILENT, Answer.REFUSED}:
            raise NotSupported(command=ReadUnknownSize.of(0, 1).name)


def _silence(ecu: Ecu) -> float:
    """Return the seconds that a silent code takes: its requests, each with D13's wait and `01`."""
    return (1 + min(1, ecu.tester.retries)) * (ecu.tester.line.timing.late + 0.15)


def _request_all(ecu: Ecu, found: dict[int, ScannedCode]) -> None:
    with progress(tr("requesting", "запрос"), _CODES, speed=False) as done:
        for each in ecu.scan():
            is_new = each.code not in found
            found[each.code] = each
            count = len(_data(found))
            done(is_new, tr(f"{each.code:02X}, found {count}", f"{each.code:02X}, есть {count}"))


def _data(found: Mapping[int, ScannedCode]) -> dict[int, ScannedCode]:
    """Return the codes with a datum, in order."""
    return {c: each for c, each in sorted(found.items()) if each.answer is Answer.DATUM}


def _show(
    context: CommandContext,
    catalog: Catalog,
    found: Mapping[int, ScannedCode],
    promised: int | None,
) -> None:
    data = _data(found)
    unclear = [c for c, each in sorted(found.items()) if each.answer is Answer.UNCLEAR]
    if context.output.json:
        context.output.data(
            {
                "codes": [
                    {
                        "code": f"{code:02X}",
                        "size": each.size,
                        "raw": each.raw,
                        "name": names_of(catalog, code) or None,
                    }
                    for code, each in data.items()
                ],
                "promised": promised,
                "unclear": [f"{code:02X}" for code in unclear],
                "requested": len(found),
            }
        )
        return
    if data:
        context.output.listing(
            data.values(),
            {
                tr("code", "код"): lambda each: f"{each.code:02X}",
                tr("bytes", "байт"): lambda each: str(each.size),
                tr("raw", "байты"): lambda each: each.raw.hex(" ").upper(),
                tr("name", "имя"): lambda each: names_of(catalog, each.code),
                tr("value", "значение"): lambda each: _value(context, catalog, each),
            },
            right="1",
        )
    said = tr("not reported", "не сообщает") if promised is None else str(promised)
    context.say(
        f"Codes with a value: {len(data)}; number of parameters by command 60: {said}.",
        f"Кодов со значением: {len(data)}; число параметров по команде 60: {said}.",
    )
    if unclear:
        listed = " ".join(f"{code:02X}" for code in unclear)
        context.say(
            f"Unclear ({len(unclear)}; 01 that may be a value or a refusal, or a bad line): "
            f"{listed}.",
            f"Неясно ({len(unclear)}; 01 — значение или отказ, либо плохая связь): {listed}.",
        )
    if len(found) < _CODES:
        context.say(
            f"Stopped: {len(found)} of {_CODES} codes were requested.",
            f"Прервано: запрошено кодов {len(found)} из {_CODES}.",
        )


def _value(context: CommandContext, catalog: Catalog, each: ScannedCode) -> str:
    """Return the values of a known code; of an unknown one the number, low byte first."""
    parameters = catalog.by_code(each.code)
    if not parameters:
        return str(int.from_bytes(each.raw, "little"))
    if parameters[0].size != each.size:
        size = parameters[0].size
        return tr(f"? (bytes in the catalog: {size})", f"? (байтов в каталоге: {size})")
    interpretation = context.options.interpretation
    readings = [decode(p, each.raw, each.time, interpretation) for p in parameters]
    return ", ".join(f"{value_text(r)} {unit_text(r)}".rstrip() for r in readings)


def _heading(ecu: Ecu) -> list[str]:
    pieces = " · ".join(piece for piece in ecu.passport().pieces if piece)
    return [
        tr(
            "Codes that a unit answers to command 61, found by `mikas scan`. Give each a name,",
            "Коды, на которые блок отвечает по команде 61 (найдены `mikas scan`). Дайте каждому",
        ),
        tr(
            "a unit and a formula once their meaning is known: "
            "docs/reference/catalog.md has the keys.",
            "имя, единицу и формулу, когда узнаете его смысл; ключи описаны в "
            "docs/reference/catalog.md.",
        ),
        f"{localized(ecu.model.text)}: {pieces or '–'}",
    ]


def _write(
    context: CommandContext,
    out: Path,
    catalog: Catalog,
    found: Mapping[int, ScannedCode],
    heading: list[str],
) -> None:
    data = {code: each.raw for code, each in _data(found).items()}
    if len(found) < _CODES:
        left = [code for code in range(_CODES) if code not in found]
        heading = [
            *heading,
            tr(
                f"Incomplete: {plural(len(left), 'code was', 'codes were')} not requested.",
                f"Неполно: не запрошено кодов {len(left)}.",
            ),
        ]
    with naming_file(out):
        save(out, starter_catalog(data, catalog, heading, current_language()), follow=True)
    new = sum(catalog.size_of(code) is None for code in data)
    context.say(
        f"{out}: {plural(new, 'code', 'codes')} that the catalog does not know. "
        f"Use it with: --catalog {out}",
        f"{out}: кодов, которых нет в каталоге: {new}. Подключить файл: --catalog {out}",
    )
