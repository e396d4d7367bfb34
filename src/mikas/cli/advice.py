"""What to try in a terminal after an error: the commands and options that help, by its class."""

from __future__ import annotations

from typing import Final

from mikas.errors import (
    AdviceTable,
    AnswersLate,
    BrokerNotTrusted,
    BrokerRefused,
    DiskFull,
    EchoDiffers,
    EchoOnly,
    LineError,
    LinkLost,
    ListLost,
    NoEcho,
    NoPortGiven,
    NoResponse,
    NotSupported,
    PortDenied,
    PortNotFound,
    PortProbed,
    RecordingOver,
    TakenByBrltty,
    UnknownParameter,
    WrongEchoSetting,
)
from mikas.i18n import Text

_DOCTOR = Text(
    "`mikas doctor` checks the connection step by step.", "`mikas doctor` проверит связь по шагам."
)
_HINTS = {
    PortNotFound: Text(
        "`mikas ports` lists the ports; `--port sim:` needs no adapter at all.",
        "Список портов: `mikas ports`; без адаптера работает `--port sim:`.",
    ),
    NoPortGiven: Text(
        "For example: --port {example}. `mikas ports` lists the ports; `--port sim:` needs no "
        "adapter at all.",
        "Например: --port {example}. Список портов: `mikas ports`; без адаптера работает "
        "`--port sim:`.",
    ),
    DiskFull: Text("Or choose another disk.", "Или выберите другой диск."),
    TakenByBrltty: Text(
        "`mikas ports --install-rules` installs the rules; or: sudo apt remove brltty.",
        "Правила ставит `mikas ports --install-rules`; удалить brltty: sudo apt remove brltty.",
    ),
    PortDenied: Text(
        "Or install the udev rules of mikas: `mikas ports --install-rules`.",
        "Или поставьте правила udev от mikas: `mikas ports --install-rules`.",
    ),
    PortProbed: Text(
        "`mikas ports --install-rules` installs the rules.",
        "Правила ставит `mikas ports --install-rules`.",
    ),
    LinkLost: Text("Then run the command again.", "Затем повторите команду."),
    RecordingOver: Text(
        "With replay:FILE?loop=1 it repeats, with replay:FILE?seek=60 it starts 60 s later.",
        "replay:FILE?loop=1 повторяет её по кругу, replay:FILE?seek=60 начинает с 60-й секунды.",
    ),
    NoEcho: Text(
        "`mikas ports` lists the ports, `mikas doctor` checks the connection step by step.",
        "Список портов: `mikas ports`; проверка связи по шагам: `mikas doctor`.",
    ),
    NoResponse: Text(
        "`mikas info` shows the commands that the unit knows, `mikas doctor` checks the line; "
        "`--timeout` sets a longer wait.",
        "Какие команды знает блок: `mikas info`; проверка линии: `mikas doctor`; ждать дольше: "
        "`--timeout`.",
    ),
    WrongEchoSetting: Text(
        "That is `--echo auto`, or no `--echo` at all.",
        "Это `--echo auto` или команда без ключа `--echo`.",
    ),
    AnswersLate: Text("The option is `--timeout {wanted:g}`.", "Ключ: `--timeout {wanted:g}`."),
    EchoOnly: Text(
        "For a slow unit, `--timeout 2` waits longer.",
        "Если блок медленный, `--timeout 2` ждёт дольше.",
    ),
    EchoDiffers: Text(
        "The option is `--echo`; `mikas doctor` checks the connection step by step.",
        "Эхо настраивает ключ `--echo`; `mikas doctor` проверит связь по шагам.",
    ),
    LineError: _DOCTOR,
    NotSupported: Text(
        "`mikas info` shows the commands of this one.",
        "Команды этого блока показывает `mikas info`.",
    ),
    BrokerRefused: Text(
        "Name and password are given by `--user` and `--password-file`, or by MIKAS_MQTT_USER and "
        "MIKAS_MQTT_PASSWORD.",
        "Имя и пароль задают ключи `--user` и `--password-file` или переменные MIKAS_MQTT_USER и "
        "MIKAS_MQTT_PASSWORD.",
    ),
    BrokerNotTrusted: Text(
        "`--tls-ca FILE` names the certificate of your own authority.",
        "Сертификат своего центра указывает `--tls-ca FILE`.",
    ),
    ListLost: Text("`mikas list set` does that.", "Это делает `mikas list set`."),
    UnknownParameter: Text(
        "`mikas params` lists all parameters.", "Все параметры: `mikas params`."
    ),
}

ADVICE: Final = AdviceTable(_HINTS)
_IN_DOCTOR = (
    *(PortNotFound, NoPortGiven, TakenByBrltty, PortProbed, PortDenied),
    *(AnswersLate, EchoOnly, WrongEchoSetting),
)
DOCTOR_ADVICE: Final = AdviceTable({kind: _HINTS[kind] for kind in _IN_DOCTOR})
"""While `mikas doctor` runs, it is not advised."""
