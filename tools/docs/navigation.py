"""The pages of the site, once for both languages. A page that is not here is an error.

A path is that of the English page below docs/; the Russian one has the same below docs/ru/.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mikas.i18n import Text
from tools.docs.generated import python_pages as python


@dataclass(frozen=True, slots=True)
class Entry:
    """A page, with its title in the navigation."""

    path: str
    title: Text


@dataclass(frozen=True, slots=True)
class Section:
    """Pages, and sections of pages, under one title."""

    title: Text
    entries: tuple[Entry | Section, ...]


def _page(path: str, en: str, ru: str) -> Entry:
    return Entry(path, Text(en, ru))


HOME = "index.md"
NAVIGATION: tuple[Entry | Section, ...] = (
    _page(HOME, "What mikas is", "Что такое mikas"),
    Section(
        Text("Tutorials", "Первые шаги"),
        (
            _page("tutorials/owner.md", "For the owner", "Владельцу"),
            _page("tutorials/mechanic.md", "For the mechanic", "Мастеру"),
            _page("tutorials/tuner.md", "For the tuner", "Настройщику"),
            _page("tutorials/developer.md", "For the developer", "Разработчику"),
        ),
    ),
    Section(
        Text("How to …", "Как сделать"),
        (
            _page("how-to/wiring.md", "Wire the cable", "Подключить кабель"),
            _page("how-to/survey.md", "A car and ten minutes", "Машина и десять минут"),
            _page("how-to/phone.md", "With a phone", "С телефоном"),
            _page("how-to/install.md", "Install", "Установить"),
            _page("how-to/terminal.md", "Begin in a terminal", "Начать в терминале"),
            _page("how-to/library.md", "The library", "Библиотека"),
            _page("how-to/coming-from.md", "Coming from python-can …", "После python-can …"),
            _page("how-to/wireshark.md", "Wireshark", "Wireshark"),
            _page("how-to/sigrok.md", "sigrok and PulseView", "sigrok и PulseView"),
            _page("how-to/notebooks.md", "Notebooks", "Блокноты Jupyter"),
            _page("how-to/fleet.md", "Many recordings, a fleet", "Много записей, автопарк"),
            _page("how-to/instruments.md", "λ meter and GPS", "Лямбда-прибор и GPS"),
            _page("how-to/trips.md", "Trips and fuel", "Поездки и расход"),
            _page("how-to/co.md", "Setting the idle CO", "Регулировка СО"),
            _page("how-to/mqtt.md", "MQTT and Home Assistant", "MQTT и Home Assistant"),
        ),
    ),
    Section(
        Text("Reference", "Справочник"),
        (
            Section(
                Text("The dashboard", "Панель в браузере"),
                (
                    _page("reference/screens.md", "All screens, keys", "Все экраны, клавиши"),
                    _page("reference/screens/live.md", "Live", "Приборы"),
                    _page("reference/screens/channel.md", "A channel's card", "Карточка канала"),
                    _page("reference/screens/chart.md", "Chart", "График"),
                    _page("reference/screens/scatter.md", "Scatter and Table", "Облако и Таблица"),
                    _page("reference/screens/faults.md", "Faults", "Ошибки"),
                    _page("reference/screens/tests.md", "Tests", "Проверки"),
                    _page("reference/screens/causes.md", "Causes", "Причины"),
                    _page("reference/screens/passport.md", "Passport", "Паспорт"),
                    _page("reference/screens/memory.md", "Memory", "Память"),
                    _page("reference/screens/recordings.md", "Recordings", "Записи"),
                    _page("reference/screens/compare.md", "Comparing two", "Сравнение записей"),
                    _page("reference/screens/report.md", "Report", "Отчёт"),
                    _page("reference/screens/connection.md", "Connection", "Связь"),
                ),
            ),
            _page("reference/cli.md", "The command line", "Командная строка"),
            _page("reference/help.md", "Help of every command", "Справка всех команд"),
            _page("reference/guided-tests.md", "Guided tests", "Проверки по шагам"),
            _page("reference/actions.md", "Actions on conditions", "Действия по условиям"),
            _page("reference/causes.md", "How causes are found", "Как ищутся причины"),
            _page("reference/report.md", "Sentences of the report", "Фразы отчёта"),
            _page("reference/exports.md", "Exports", "Экспорт"),
            _page("reference/foreign-logs.md", "Other programs’ logs", "Логи других программ"),
            _page("reference/capture.md", "Captures", "Файлы записей"),
            _page("reference/catalog.md", "Catalog files", "Файлы каталога"),
            _page("reference/evidence.md", "Evidence", "На чём что держится"),
            Section(
                Text("What the program knows", "Что программа знает"),
                (
                    _page("reference/parameters.md", "Parameters", "Параметры"),
                    _page("reference/faults.md", "Fault numbers", "Коды неисправностей"),
                    _page("reference/channels.md", "Derived channels", "Производные каналы"),
                    _page("reference/commands.md", "Commands", "Команды"),
                ),
            ),
            Section(
                Text("Python", "Python"),
                tuple(_page(python.path_of(each), each.name, each.name) for each in python.PAGES),
            ),
            _page("reference/simulator.md", "The simulator", "Виртуальный блок"),
            _page("reference/units-met.md", "Units met", "Блоки, которые встретились"),
            _page("reference/scenarios.md", "Scenarios", "Сценарии"),
            _page("reference/api.md", "The dashboard's interface", "Интерфейс панели"),
            _page("reference/security.md", "Security", "Безопасность"),
            _page("reference/field.md", "In the field", "В полевых условиях"),
            _page("reference/facts.md", "Facts about the car", "Сведения о машине"),
        ),
    ),
    _page("protocol.md", "The protocol", "Протокол"),
    Section(
        Text("Development", "Разработка"),
        (
            _page("development/architecture.md", "Architecture", "Устройство программы"),
            _page("development/where-do-i.md", "Where do I …?", "Где что менять"),
            _page("development/site.md", "The page without installation", "Страница без установки"),
            _page("development/docs.md", "These pages", "Эти страницы"),
            _page("development/cable.md", "Tests on a cable", "Испытания на кабеле"),
            _page("development/chips.md", "USB chips as models", "Модели микросхем USB"),
            _page("development/soak.md", "A million exchanges", "Миллион обменов"),
            _page("development/causes.md", "How causes are ranked", "Как ранжируются причины"),
            _page("development/benchmarks.md", "Figures", "Измерения"),
            _page("development/tasks.md", "Tasks of a new user", "Задачи нового человека"),
        ),
    ),
)


def entries(within: tuple[Entry | Section, ...] = NAVIGATION) -> Iterator[Entry]:
    """Yield every page of the navigation, in its order."""
    for each in within:
        if isinstance(each, Entry):
            yield each
        else:
            yield from entries(each.entries)
