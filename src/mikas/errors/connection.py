"""No connection: no port, no echo, no ECU (D1)."""

from __future__ import annotations

from mikas.errors.base import MikasError
from mikas.i18n import Text


class NoConnection(MikasError, ConnectionError):
    """No port, no adapter or no ECU."""


class PortNotFound(NoConnection):
    """No such port, or no adapter at all."""

    what = Text("There is no port {url}", "Порта {url} нет")
    advice = Text(
        "Found: {found}. Is the adapter plugged in?", "Найдены: {found}. Адаптер подключён?"
    )


class NoPortGiven(PortNotFound):
    """No port was named and not exactly one likely adapter is plugged in. `example`: a port."""

    what = Text(
        "No port was named, and there is not exactly one likely adapter",
        "Порт не указан, а подходящих адаптеров нет или больше одного",
    )
    advice = Text(
        "Found: {found}. Plug the adapter in, or name its port.",
        "Найдены: {found}. Подключите адаптер или укажите его порт.",
    )

    def __init__(self, *, example: str = "/dev/ttyUSB0", **given: object) -> None:
        super().__init__(example=example, **given)  # type: ignore[arg-type]  # as MikasError's


class AnotherAdapter(PortNotFound):
    """The adapter is away, and its port's name or its kind is another adapter's."""

    what = Text("The adapter is gone: {problem}", "Адаптера нет: {problem}")
    advice = Text(
        "Plug the right one in again, into the same USB socket if you can: it is found under any "
        "name. To use another one, connect anew.",
        "Подключите прежний адаптер, лучше в то же гнездо USB: он найдётся под любым именем. Чтобы "
        "работать с другим, соединитесь заново.",
    )


class PortBusy(NoConnection):
    """Another program has the port open."""

    what = Text("Port {url} is in use by another program", "Порт {url} занят другой программой")
    advice = Text(
        "Likely: another window of mikas or its dashboard, another diagnostics program, a terminal "
        "or ModemManager. Close it, then try again.",
        "Скорее всего, это другое окно mikas или его панель, другая программа диагностики, "
        "терминал или ModemManager. Закройте и повторите.",
    )


class PortDenied(NoConnection):
    """The user has no permission to open the port."""

    what = Text("No permission to open {url}", "Нет прав на открытие {url}")
    advice = Text(
        "On Linux: sudo usermod -aG dialout $USER, then log out and in again.",
        "В Linux: sudo usermod -aG dialout $USER, затем выйти из системы и войти снова.",
    )


class PortFailed(NoConnection):
    """The port could not be opened for another reason, given in the system's own words."""

    what = Text("Port {url} could not be opened: {problem}", "Порт {url} не открылся: {problem}")
    advice = Text(
        "Unplug the adapter and plug it in again; for an address, check host and port.",
        "Отключите и снова подключите адаптер; для сетевого адреса проверьте имя и порт.",
    )


class LinkLost(NoConnection):
    """The adapter disconnected while in use."""

    what = Text("The adapter on {url} is gone: {problem}", "Адаптер на {url} пропал: {problem}")
    advice = Text("Check the USB plug and its cable.", "Проверьте разъём USB и кабель.")


class RecordingOver(LinkLost):
    """The recording played through `replay:` has ended; waiting is useless."""

    what = Text("The recording {file} is over", "Запись {file} закончилась")
    advice = Text(
        "Connect again to play it from the beginning.",
        "Чтобы воспроизвести её сначала, соединитесь снова.",
    )


class NoEcho(NoConnection):
    """Nothing came back, not even the adapter's echo (D1)."""

    what = Text(
        "Nothing came back, not even the echo of what was sent",
        "Не принято ничего, даже эха посланного",
    )
    advice = Text(
        "Likely, in order: the adapter has no 12 V (it is fed from the car's diagnostic socket); "
        "K-Line or ground is not connected; this is another port. With an adapter that returns no "
        "echo: the ignition is off.",
        "Скорее всего, по порядку: на адаптере нет 12 В (он питается от диагностической колодки); "
        "не подключены K-Line или масса; это другой порт. Если адаптер не возвращает эхо: "
        "выключено зажигание.",
    )


class EchoOnly(NoConnection):
    """The echo came back, the ECU did not answer (D1)."""

    what = Text(
        "The adapter works (its echo came back), but the ECU does not answer",
        "Адаптер работает (эхо пришло), но блок не отвечает",
    )
    advice = Text(
        "Likely, in order: the ignition is off; the K-Line wire goes to another unit or pin; the "
        "unit has no supply; it is not a Mikas 5.4 / 7.1. Switch the ignition on and try again.",
        "Скорее всего, по порядку: выключено зажигание; провод K-Line идёт к другому блоку или "
        "выводу; нет питания блока; это не Микас 5.4 / 7.1. Включите зажигание и повторите.",
    )


class NotAKLineAdapter(NoConnection):
    """An ELM327, or another adapter with a command interpreter, answered."""

    what = Text(
        "The adapter on this port is an ELM327 (or similar), not a plain K-Line adapter",
        "На этом порту ELM327 (или подобный), а не простой адаптер K-Line",
    )
    advice = Text(
        "An ELM327 interprets the bytes it gets and can't carry this protocol. Use a KKL adapter "
        "(a “VAG-COM 409” cable with FT232 or CH340).",
        "ELM327 сам обрабатывает посланные байты и этот протокол передать не может. Нужен адаптер "
        "KKL (кабель «VAG-COM 409» на FT232 или CH340).",
    )
