"""`mikas dash`: the dashboard, in the browser."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mikas.cli.click_extensions import command, option
from mikas.cli.context import CommandContext
from mikas.cli.dash_notes import tell_if_missing, tell_if_nothing_can_be_kept, tell_kept
from mikas.cli.language import requested_language, tr
from mikas.cli.parameter_types import Whole
from mikas.errors import UsageError
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.dashboard.security.access import Access
    from mikas.dashboard.settings import Settings


@dataclass(frozen=True, slots=True)
class DashboardOptions:
    """What the command line says about the server. `port` None: the first free one."""

    port: int | None = None
    lan: bool = False
    lan_control: bool = False
    browser: bool = True
    folder: Path | None = None


def dashboard_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options that `dash` and `demo` share; they come as one `DashboardOptions`."""

    @wraps(function)
    def gathered(
        context: CommandContext,
        *,
        host_port: int | None,
        lan: bool,
        lan_control: bool,
        no_browser: bool,
        record: str | None,
        **rest: Any,
    ) -> Any:  # noqa: ANN401  (as the command)
        options = dashboard_options_of(
            host_port=host_port,
            lan=lan,
            lan_control=lan_control,
            no_browser=no_browser,
            record=record,
        )
        return function(context, options, **rest)

    gathered_with: Callable[..., Any] = gathered
    for add in _OPTIONS:
        gathered_with = add(gathered_with)
    return gathered_with


_OPTIONS = (
    option(
        "--record",
        metavar="DIR",
        text=Text(
            "where recordings and dumps are kept (mikas in your documents)",
            "где хранить записи и образы памяти (mikas в «Документах»)",
        ),
    ),
    option(
        "--no-browser",
        is_flag=True,
        text=Text("print the address only", "только напечатать адрес"),
    ),
    option(
        "--lan-control",
        is_flag=True,
        text=Text(
            "others in the network may control as well, not only look",
            "из сети можно не только смотреть, но и управлять",
        ),
    ),
    option(
        "--lan",
        is_flag=True,
        text=Text(
            "let others in the network look on: by a link with a key, shown as a QR code too",
            "пустить зрителей из сети: по ссылке с ключом, она же показана QR-кодом",
        ),
    ),
    option(
        "--host-port",
        type=Whole(1, 65535),
        metavar="N",
        text=Text(
            "the TCP port of the page (8071, or the next that is free)",
            "порт TCP для страницы (8071 или следующий свободный)",
        ),
    ),
)


def dashboard_options_of(
    *, host_port: int | None, lan: bool, lan_control: bool, no_browser: bool, record: str | None
) -> DashboardOptions:
    """Those options together. Raises `UsageError`."""
    folder = Path(record) if record else None
    if folder is not None:
        from mikas.dashboard.settings import check_folder

        check_folder(folder)
    return DashboardOptions(host_port, lan or lan_control, lan_control, not no_browser, folder)


@command(
    "dash",
    Text(
        "Opens the dashboard in the browser: live values, charts, faults, memory, recordings. "
        "With --port it connects at once, otherwise by a click. Nothing leaves this computer, "
        "unless --lan lets others look on.",
        "Открывает панель в браузере: живые значения, графики, ошибки, память, записи. С ключом "
        "--port соединяется сразу, иначе — по щелчку. Наружу не уходит ничего, если только --lan "
        "не пустит зрителей.",
    ),
    examples=("mikas dash", "mikas dash --port /dev/ttyUSB0", "mikas dash --lan --no-browser"),
)
@dashboard_options
def dash(context: CommandContext, options: DashboardOptions) -> None:
    show_dashboard(context, options)


def show_dashboard(context: CommandContext, options: DashboardOptions) -> None:
    """Serves until Ctrl-C; tells the address first."""
    from mikas.dashboard.app import create_app
    from mikas.dashboard.dashboard import Hub
    from mikas.dashboard.security.access import Access
    from mikas.dashboard.server import listening, own_addresses, serve
    from mikas.dashboard.settings import Settings, default_recordings, ensure_folder
    from mikas.dashboard.virtual_cars import VirtualCars

    if context.capture is not None:
        raise UsageError(
            problem=Text(
                "the dashboard records by itself (--record DIR); leave --capture out",
                "Панель записывает сама (--record DIR); уберите --capture",
            )
        )
    if context.port is not None:
        _check(context.port)
    if options.folder is not None:
        ensure_folder(options.folder)
    settings = Settings(
        options.folder or default_recordings(),
        connection=context.options,
        open_port=VirtualCars().open,
        language=requested_language(),
    )
    own = listening(options.port, lan=options.lan)
    with own:
        access = Access(
            own.getsockname()[1],
            lan=options.lan,
            lan_control=options.lan_control,
            hosts=own_addresses() if options.lan else (),
        )
        hub = Hub(settings, begin=context.port, lan=options.lan)
        try:
            serve(
                create_app(hub, access),
                own,
                ready=lambda: _tell(context, access, options, settings),
            )
        finally:
            tell_kept(context, hub)


def _check(url: str) -> None:
    """Raises for an address that makes no sense; a port that is not there will be waited for."""
    from mikas.link import open_link
    from mikas.link.urls import parse

    if parse(url).scheme in ("sim", "replay"):
        open_link(url).close()


def _tell(
    context: CommandContext, access: Access, options: DashboardOptions, settings: Settings
) -> None:
    if context.output.json:
        context.output.data({"url": access.url, "lan_url": access.lan_url})
    else:
        context.output.line(access.url)
        if access.lan_url:
            context.output.line(access.lan_url)
    context.output.note(tr("Ctrl-C ends it.", "Выход: Ctrl-C."))
    tell_if_nothing_can_be_kept(context, settings)
    if context.port is not None:
        tell_if_missing(context, context.port)
    if access.lan_url and not context.output.json:
        import sys

        import segno

        segno.make(access.lan_url, error="m").terminal(sys.stderr, compact=True)
    if options.browser:
        # Some systems' browsers hold on to whoever opens them.
        threading.Thread(target=_open, args=(access.url,), daemon=True).start()


def _open(url: str) -> None:
    import webbrowser

    webbrowser.open(url)
