"""The packages of an installation and their megabytes, in the page on installing.

The list is that of pyproject.toml. The megabytes are measured (`python -m tools.package.sizes`);
a list that has changed since then is an error.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from typing import Final

from mikas.catalog import Catalog
from mikas.i18n import Language, Text
from tools.docs.generated.places import filled
from tools.docs.generated.tables import code, table
from tools.docs.pages import DOCS, ROOT, RUSSIAN
from tools.package.sizes import MEASURED, dependencies

CLIENT: Final = ("platformdirs", "pyserial")
"""What a program needs that connects, reads and records (tests/client/test_client_weight.py)."""

USES: Final = {
    "click": Text("the command line", "командная строка"),
    "cryptography": Text("certificates of the dashboard", "сертификаты панели"),
    "fastapi": Text("the dashboard's API", "API панели"),
    "jinja2": Text("pages of the dashboard, reports", "страницы панели, отчёты"),
    "numpy": Text(
        "columns: recordings, exports, charts, reports",
        "столбцы: записи, экспорт, графики, отчёты",
    ),
    "platformdirs": Text("places of settings and recordings", "папки настроек и записей"),
    "pydantic": Text("the dashboard's API", "API панели"),
    "pyserial": Text("serial ports", "последовательные порты"),
    "rich": Text("tables and progress on a terminal", "таблицы и ход работы в терминале"),
    "segno": Text("QR codes of the dashboard's address", "QR-коды адреса панели"),
    "tomlkit": Text("writing settings and catalogs", "запись настроек и каталогов"),
    "uvicorn": Text("the dashboard's server", "сервер панели"),
    "websockets": Text("live values of the dashboard", "значения на панели"),
}
_SUM = {
    "en": re.compile(r"\d+ MB, with all exports \d+ MB"),
    "ru": re.compile(r"\d+ МБ, со всеми форматами экспорта \d+ МБ"),
}


@dataclass(frozen=True, slots=True)
class Sizes:
    """What was measured, in megabytes. `needed`: the number of packages that the others need."""

    mikas: float
    total: int
    with_exports: int
    needed: int
    packages: dict[str, float]


def sizes() -> Sizes:
    """Return the measured sizes. Raises `ValueError` if they are of other packages."""
    found = Sizes(**tomllib.loads(MEASURED.read_text("utf-8")))
    if sorted(found.packages) != dependencies():
        raise ValueError("the dependencies have changed: python -m tools.package.sizes")
    return found


def install(_: Catalog, language: Language) -> str:
    """Return the page with its list and its sums."""
    file = ROOT / (RUSSIAN if language == "ru" else DOCS) / "how-to/install.md"
    found = sizes()
    both = Text(
        f"{found.total} MB, with all exports {found.with_exports} MB",
        f"{found.total} МБ, со всеми форматами экспорта {found.with_exports} МБ",
    ).to(language)
    text = _SUM[language].sub(both, file.read_text("utf-8"))
    return filled(text, {"packages": lambda: _packages(found, language)})


def _packages(found: Sizes, language: Language) -> str:
    headers = ("package|for|needed by a client|MB", "пакет|для чего|нужен клиенту|МБ")
    client = Text("yes", "да").to(language)
    rows = [
        [
            code(name),
            USES[name].to(language),
            client if name in CLIENT else "",
            _number(found.packages[name], language),
        ]
        for name in sorted(found.packages, key=lambda name: (-found.packages[name], name))
    ]
    rest = found.total - found.mikas - sum(found.packages.values())
    needed = Text(
        f"what these need: {found.needed} packages", f"то, что нужно им: пакетов {found.needed}"
    )
    rows += [
        [code("mikas"), "", client, _number(found.mikas, language)],
        ["…", needed.to(language), "", _number(round(rest), language)],
        [Text("together", "вместе").to(language), "", "", _number(found.total, language)],
    ]
    return table(language, headers, rows)


def _number(value: float, language: Language) -> str:
    shown = f"{value:g}"
    return shown.replace(".", ",") if language == "ru" else shown
