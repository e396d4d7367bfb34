"""`mikas dash` and `mikas demo`: the dashboard in the browser, with a car or a virtual one."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlencode

from mikas.cli.advice import ADVICE
from mikas.cli.click_extensions import command, flag, option
from mikas.cli.completion.values import cars, fault_codes, scenarios
from mikas.cli.context import CommandContext
from mikas.cli.desktop import FLAG, open_page
from mikas.cli.language import localized, requested_language, tr
from mikas.cli.options.dashboard import DashboardOptions, dashboard_options
from mikas.cli.options.parameter_types import whole
from mikas.cli.render.terminal import error_drawing
from mikas.errors import BadPortUrl, UsageError, usage_error

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Dashboard
    from mikas.dashboard.security.access import Access
    from mikas.dashboard.security.certificate import Certificate
    from mikas.dashboard.settings import Settings

_FAULTS = "17"  # air temperature: a fault to find and to erase, with the engine running well


@command(
    en="Opens the dashboard in the browser: live values, charts, faults, memory, recordings. "
    "With --port it connects at once, otherwise on request. No data leave this computer "
    "unless you allow phones and other computers to look on: with --lan, or with the switch "
    "on the screen Connection.",
    ru="Открывает панель в браузере: живые значения, графики, ошибки, память, записи. С ключом "
    "--port соединяется сразу, иначе — по нажатию. Данные не покидают этот компьютер, пока "
    "вы не пустите телефоны и другие компьютеры: ключом --lan или переключателем на экране "
    "«Связь».",
    examples=("mikas dash", "mikas dash --port /dev/ttyUSB0", "mikas dash --lan --no-browser"),
)
@flag(
    FLAG,
    en="as its icon starts it: without a terminal. A second start opens the page of the first; "
    "the page ends the program",
    ru="как запускает её значок: без терминала. Второй запуск открывает страницу первого; "
    "завершают программу со страницы",
)
@dashboard_options
def dash(context: CommandContext, options: DashboardOptions, *, desktop: bool) -> None:
    if desktop and options.no_browser:
        raise usage_error(
            "--desktop opens the browser; omit --no-browser",
            "--desktop открывает браузер; уберите --no-browser",
        )
    from mikas.client.connecting import state_folder
    from mikas.dashboard.running import RunningDashboard, starting

    folder = state_folder()
    with ExitStack() as start:
        if desktop:
            start.enter_context(starting(folder))
            if (running := RunningDashboard.find(folder)) is not None:
                context.output.result({"url": running.url}, running.url)
                open_page(running.url)
                return
        show_dashboard(context, options, start, desktop=desktop)


@command(
    en="Opens the dashboard with a virtual car in this process: a cold start and warm-up, with "
    "one stored fault. The same in a terminal: mikas watch --port sim:",
    ru="Открывает панель с виртуальным автомобилем в этом же процессе: холодный пуск и прогрев, "
    "одна ошибка в памяти. То же в терминале: mikas watch --port sim:",
    examples=("mikas demo", "mikas demo --scenario city --lang ru", "mikas demo --no-browser"),
)
@option(
    "--scenario",
    default="cold-start",
    metavar="NAME|FILE",
    shell_complete=scenarios,
    en="driving scenario (cold-start)",
    ru="сценарий поездки (cold-start)",
)
@option(
    "--car",
    metavar="LIST",
    shell_complete=cars,
    en="a car with defects: leak:8,battery, or blind:4711 (mikas sim --help)",
    ru="машина с неисправностями: leak:8,battery или blind:4711 (mikas sim --help)",
)
@option(
    "--seed",
    type=whole(0),
    default="1",
    metavar="N",
    en="seed of the random numbers (1)",
    ru="начальное число случайной последовательности (1)",
)
@option(
    "--faults",
    default=_FAULTS,
    metavar="LIST",
    shell_complete=fault_codes,
    en=f"stored faults, e.g. 13,53 ({_FAULTS})",
    ru=f"ошибки в памяти: 13,53 ({_FAULTS})",
)
@dashboard_options
def demo(
    context: CommandContext,
    options: DashboardOptions,
    *,
    scenario: str,
    car: str | None,
    seed: int,
    faults: str,
) -> None:
    settings = {"scenario": scenario, "seed": str(seed), "faults": faults}
    if car is not None:
        settings["car"] = car
    context.port = f"sim:?{urlencode(settings, safe=':,')}"
    context.output.detail(tr("virtual car:", "виртуальный автомобиль:"), context.port)
    try:
        show_dashboard(context, options)
    except BadPortUrl as error:  # of these options, not of a port that the user has named
        raise UsageError(problem=error.fields["problem"]) from error


def show_dashboard(
    context: CommandContext,
    options: DashboardOptions,
    start: ExitStack | None = None,
    *,
    desktop: bool = False,
) -> None:
    """Print the address, then serve until Ctrl-C.

    `start`: closed as soon as a second start finds this one; None: it is not to be found.
    """
    if context.capture is not None:
        raise usage_error(
            "The dashboard records itself (--record DIR); omit --capture",
            "Панель записывает сама (--record DIR); уберите --capture",
        )
    with ExitStack() as stack:
        # Imports take as long as the handshake listens.
        ahead = None if context.port is None else stack.enter_context(context.open_ahead())
        from mikas.cli.config import own_causes, own_tests
        from mikas.client.connecting import state_folder
        from mikas.dashboard.dashboard import Dashboard
        from mikas.dashboard.network.addresses import is_ipv6, own_addresses
        from mikas.dashboard.network.listening import listen, listen_ipv6
        from mikas.dashboard.running import RunningDashboard
        from mikas.dashboard.security.access import Access
        from mikas.dashboard.settings import Settings, VirtualCars, ensure_folder
        from mikas.home import documents_folder

        if options.record is not None:
            ensure_folder(options.record)
        own = [stack.enter_context(listen(options.host_port, lan=options.lan))]
        port = own[0].getsockname()[1]
        if options.lan:
            own += map(stack.enter_context, listen_ipv6(port))

        def addresses() -> tuple[str, ...]:
            """Leave out what a start with --lan could not open."""
            found = own_addresses()
            return (
                found
                if len(own) > 1 or not options.lan
                else tuple(host for host in found if not is_ipv6(host))
            )

        settings = Settings(
            options.record or documents_folder() / "mikas",
            connection=context.options,
            open_port=(VirtualCars(ahead.open) if ahead else VirtualCars()).open,
            language=requested_language(),
            own=context.own_catalog,
            tests=own_tests(),
            causes=own_causes(),
            desktop=desktop,
            addresses=addresses,
        )
        hosts = addresses() if options.lan else ()
        certificate = _certificate(options, settings, hosts)
        access = Access(
            port,
            lan=options.lan,
            lan_control=options.lan_control,
            hosts=certificate.hosts(hosts) if certificate else hosts,
            fingerprint=certificate.fingerprint if certificate else None,
        )
        if options.lan:
            access.followed = lambda: _show_links_anew(context, access)
        dashboard = Dashboard(settings, port=context.port, lan=options.lan)
        if start is not None:
            running = RunningDashboard(access.port, access.instance)
            stack.enter_context(running.kept(state_folder()))
            start.close()
        try:
            # The unit is found meanwhile: these imports take as long as the handshake.
            dashboard.connection.begin()
            from mikas.dashboard.app import create_app
            from mikas.dashboard.server import serve

            serve(
                create_app(dashboard, access, certificate=certificate, here=hosts),
                own,
                ready=lambda: _show_address(context, access, options, dashboard),
                tls=certificate.context if certificate else None,
            )
        finally:
            dashboard.connection.stop()
            _note_recording(context, dashboard)


def _certificate(
    options: DashboardOptions, settings: Settings, hosts: Sequence[str]
) -> Certificate | None:
    """Return the user's certificate or mikas' own one; None: nothing is encrypted."""
    if not options.lan or options.no_tls:
        return None
    from mikas.dashboard.security.certificate import given_certificate, own_certificate

    if options.tls_cert is not None and options.tls_key is not None:
        return given_certificate(options.tls_cert, options.tls_key)
    return own_certificate(settings.certificate, hosts, datetime.now(UTC))


def _show_address(
    context: CommandContext, access: Access, options: DashboardOptions, dashboard: Dashboard
) -> None:
    from mikas.dashboard.api.catalog import problems

    urls = {"url": access.url, "lan_url": access.lan_url}
    links = [link.url for link in access.lan_links]
    found = {**urls, "lan_urls": links, "fingerprint": access.fingerprint}
    context.output.result(found, "\n".join(filter(None, urls.values())))
    context.say("Ctrl-C ends it.", "Выход: Ctrl-C.")
    _note_unusable_folder(context, dashboard.settings)
    for problem in problems(dashboard):
        context.say(*problem)
    if context.port is not None:
        _note_missing_port(context, context.port)
    if access.lan_url and not context.output.json:
        import segno

        segno.make(access.lan_url, error="m").terminal(error_drawing(), compact=True)
        if links[1:]:
            context.say(
                "If that address does not open on the phone, one of these may:",
                "Если этот адрес на телефоне не открывается, попробуйте другие:",
            )
            for link in links[1:]:
                context.output.print_note(f"  {link}")
    if options.lan:
        _note_encryption(context, access)
    if not options.no_browser:
        # On some systems opening a browser blocks.
        threading.Thread(target=open_page, args=(access.url,), daemon=True).start()


def _show_links_anew(context: CommandContext, access: Access) -> None:
    """Show the links after this computer's addresses have changed."""
    context.say(
        "This computer's addresses have changed. The links for the phone are now:",
        "Адреса этого компьютера изменились. Ссылки для телефона теперь такие:",
    )
    for link in access.lan_links:
        context.output.print_note(f"  {link.url}")


def _note_encryption(context: CommandContext, access: Access) -> None:
    """Show the certificate's fingerprint, or warn that nothing is encrypted."""
    if access.fingerprint is None:
        context.say(
            "Warning: --no-tls sends the key of the link and all data in the clear. Whoever is in "
            "this network can read the key and use it.",
            "Внимание: с --no-tls ключ из ссылки и все данные идут без шифрования. Любой в этой "
            "сети может прочитать ключ и воспользоваться им.",
        )
        return
    context.say(
        "If the browser there warns of the certificate (mikas makes it itself), compare its "
        "SHA-256 fingerprint with this one, and continue only if it is the same:",
        "Если браузер предупредит о сертификате (его делает mikas), сверьте его отпечаток "
        "SHA-256 с этим и продолжайте, только если они совпадают:",
    )
    half = len(access.fingerprint) // 2
    for line in (access.fingerprint[:half], access.fingerprint[half + 1 :]):
        context.output.print_note(f"  {line}")


def _note_recording(context: CommandContext, dashboard: Dashboard) -> None:
    """Say where the recording that was under way is kept, or why it stopped."""
    kept = dashboard.recorder.last
    if kept is None:
        return
    if kept.failure is None:
        context.say(
            f"Recording stopped and saved: {kept.path}",
            f"Запись остановлена и сохранена: {kept.path}",
        )
    else:
        context.output.print_note(localized(ADVICE.text(kept.failure)))


def _note_unusable_folder(context: CommandContext, settings: Settings) -> None:
    """Say if the default folder can't be used; a folder given by `--record` is refused instead."""
    from mikas.dashboard.settings import folder_error

    if (error := folder_error(settings.recordings)) is not None:
        context.output.print_note(localized(ADVICE.text(error)))


def _note_missing_port(context: CommandContext, url: str) -> None:
    """Say that the port is absent: the page, which shows it too, may not be open yet."""
    from mikas.link import find_ports
    from mikas.link.ports import listed
    from mikas.link.urls import parse

    named = parse(url)
    if named.scheme != "serial" or Path(named.address).exists():
        return
    ports = find_ports()
    if named.address in (port.url for port in ports):
        return  # on Windows a port is no path
    found = listed(ports)
    context.say(
        f"There is no port {named.address} yet; the page connects as soon as it appears. "
        f"Found: {found.en}.",
        f"Порта {named.address} пока нет; страница соединится, как только он появится. "
        f"Найдены: {found.ru}.",
    )
