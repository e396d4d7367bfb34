"""Nobody to talk to: no port, no echo, no ECU (D1)."""

from __future__ import annotations

from mikas.errors.base import MikasError
from mikas.i18n import Text


class NoConnection(MikasError, ConnectionError):
    """Nobody to talk to."""


class PortNotFound(NoConnection):
    """No such port, or no adapter at all."""

    what = Text("There is no port {url}", "Порта {url} нет")
    advice = Text(
        "Found: {found}. Is the adapter plugged in? `mikas ports` lists what the system sees; "
        "`--port sim:` works with no adapter at all.",
        "Найдены: {found}. Воткнут ли адаптер? Что видит система, показывает `mikas ports`; "
        "без адаптера работает `--port sim:`.",
    )
    advice_on_screen = Text(
        "Found: {found}. Plug the adapter in: the one in use goes on by itself, another has to be "
        "chosen on the Cable screen; a virtual car there works with no adapter at all.",
        "Найдены: {found}. Воткните адаптер: тот, что был в работе, продолжит сам, другой нужно "
        "выбрать на экране «Связь»; виртуальный автомобиль там работает и без адаптера.",
    )


class NoPortGiven(PortNotFound):
    """No port was named and not exactly one likely adapter is plugged in."""

    what = Text(
        "No port was named, and there is not exactly one likely adapter",
        "Порт не указан, а подходящих адаптеров нет или больше одного",
    )
    advice = Text(
        "Found: {found}. Plug the adapter in; if it is in, say which one it is: --port and its "
        "name. `mikas ports` lists what the system sees; `--port sim:` works with no adapter at "
        "all.",
        "Найдены: {found}. Воткните адаптер; если он уже воткнут, укажите его: --port и имя. Что "
        "видит система, показывает `mikas ports`; без адаптера работает `--port sim:`.",
    )
    advice_on_screen = Text(
        "Found: {found}. Choose the adapter, or a virtual car, on the Cable screen; plug it in "
        "first if it is not among them.",
        "Найдены: {found}. Выберите адаптер или виртуальный автомобиль на экране «Связь»; если "
        "адаптера там нет, сначала воткните его.",
    )


class PortBusy(NoConnection):
    """Another program holds the port."""

    what = Text("Port {url} is in use by another program", "Порт {url} занят другой программой")
    advice = Text(
        "Likely: another window of mikas or its dashboard, another diagnostics program, a terminal "
        "or ModemManager. Close it, then try again.",
        "Скорее всего, это другое окно mikas или его панель, другая программа диагностики, "
        "терминал или ModemManager. Закройте и повторите.",
    )


class PortDenied(NoConnection):
    """The system does not let this user open the port."""

    what = Text("The system does not let you open {url}", "Система не даёт открыть {url}")
    advice = Text(
        "On Linux: sudo usermod -aG dialout $USER, then log out and in again.",
        "В Linux: sudo usermod -aG dialout $USER, затем выйти из системы и войти снова.",
    )


class PortFailed(NoConnection):
    """The port could not be opened for another reason, given in the system's own words."""

    what = Text("Port {url} could not be opened: {problem}", "Порт {url} не открылся: {problem}")
    advice = Text(
        "Unplug the adapter and plug it in again; for an address, check host and port.",
        "Выньте и снова вставьте адаптер; для сетевого адреса проверьте имя и порт.",
    )


class LinkLost(NoConnection):
    """The adapter went away while in use."""

    what = Text("The adapter on {url} is gone: {problem}", "Адаптер на {url} пропал: {problem}")
    advice = Text(
        "Check the USB plug and its cable, then run the command again.",
        "Проверьте разъём USB и кабель, затем повторите команду.",
    )
    advice_on_screen = Text(
        "Check the USB plug and its cable; the connection comes back by itself.",
        "Проверьте разъём USB и кабель; соединение восстановится само.",
    )


class RecordingOver(LinkLost):
    """What was played through `replay:` has come to its end; there is nothing to wait for."""

    what = Text("The recording {file} is over", "Запись {file} закончилась")
    advice = Text(
        "Connect again, and it begins anew; replay:FILE?loop=1 goes round and round, "
        "replay:FILE?seek=60 begins 60 s from its beginning.",
        "Соединитесь снова, и она начнётся заново; replay:FILE?loop=1 — по кругу, "
        "replay:FILE?seek=60 — с 60-й секунды.",
    )
    advice_on_screen = Text(
        "Connect again, and it begins anew.", "Соединитесь снова, и она начнётся заново."
    )


class NoEcho(NoConnection):
    """Nothing came back, not even the adapter's echo (D1)."""

    what = Text(
        "Nothing came back, not even the echo of what was sent",
        "Не пришло ничего, даже эха посланного",
    )
    advice = Text(
        "Likely, in order: the adapter has no 12 V (it is fed from the car's plug); K-Line or "
        "ground is not connected; this is another port (`mikas ports`). With an adapter that "
        "keeps the echo to itself: the ignition is off. Then try `mikas doctor`.",
        "Скорее всего, по порядку: на адаптере нет 12 В (он питается от разъёма машины); не "
        "подключены K-Line или масса; это другой порт (`mikas ports`). Если адаптер не даёт эха: "
        "выключено зажигание. Затем попробуйте `mikas doctor`.",
    )
    advice_on_screen = Text(
        "Likely, in order: the adapter has no 12 V (it is fed from the car's plug); K-Line or "
        "ground is not connected; this is another port (the Cable screen lists them). With an "
        "adapter that keeps the echo to itself: the ignition is off.",
        "Скорее всего, по порядку: на адаптере нет 12 В (он питается от разъёма машины); не "
        "подключены K-Line или масса; это другой порт (они перечислены на экране «Связь»). Если "
        "адаптер не даёт эха: выключено зажигание.",
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
    """An ELM327, or another thing with a mind of its own, answered."""

    what = Text(
        "Behind this port is an ELM327 (or alike), not a plain K-Line adapter",
        "За этим портом ELM327 (или подобный), а не простой адаптер K-Line",
    )
    advice = Text(
        "An ELM327 interprets what it is sent and can't carry this protocol. Use a KKL adapter "
        "(a “VAG-COM 409” cable with FT232 or CH340).",
        "ELM327 сам толкует посылаемое и этот протокол передать не может. Нужен адаптер KKL "
        "(кабель «VAG-COM 409» на FT232 или CH340).",
    )
