"""What to try in a terminal after an error: the commands and options that help, by its class."""

from __future__ import annotations

from typing import Final

from mikas import errors
from mikas.i18n import Text

_DOCTOR = Text(
    "`mikas doctor` checks the connection step by step.", "`mikas doctor` проверит связь по шагам."
)
_HINTS = {
    errors.PortNotFound: Text(
        "`mikas ports` lists the ports; `--port sim:` needs no adapter at all.",
        "Список портов: `mikas ports`; без адаптера работает `--port sim:`.",
    ),
    errors.NoPortGiven: Text(
        "For example: --port {example}. `mikas ports` lists the ports; `--port sim:` needs no "
        "adapter at all.",
        "Например: --port {example}. Список портов: `mikas ports`; без адаптера работает "
        "`--port sim:`.",
    ),
    errors.DiskFull: Text("Or choose another disk.", "Или выберите другой диск."),
    errors.TakenByBrltty: Text(
        "`mikas ports --install-rules` installs the rules; or: sudo apt remove brltty.",
        "Правила ставит `mikas ports --install-rules`; удалить brltty: sudo apt remove brltty.",
    ),
    errors.PortDenied: Text(
        "Or install the udev rules of mikas: `mikas ports --install-rules`.",
        "Или поставьте правила udev от mikas: `mikas ports --install-rules`.",
    ),
    errors.PortProbed: Text(
        "`mikas ports --install-rules` installs the rules.",
        "Правила ставит `mikas ports --install-rules`.",
    ),
    errors.LinkLost: Text("Then run the command again.", "Затем повторите команду."),
    errors.RecordingOver: Text(
        "With replay:FILE?loop=1 it repeats, with replay:FILE?seek=60 it starts 60 s later.",
        "replay:FILE?loop=1 повторяет её по кругу, replay:FILE?seek=60 начинает с 60-й секунды.",
    ),
    errors.NoEcho: Text(
        "`mikas ports` lists the ports, `mikas doctor` checks the connection step by step.",
        "Список портов: `mikas ports`; проверка связи по шагам: `mikas doctor`.",
    ),
    errors.NoResponse: Text(
        "`mikas info` shows the commands that the unit knows, `mikas doctor` checks the line; "
        "`--timeout` sets a longer wait.",
        "Какие команды знает блок: `mikas info`; проверка линии: `mikas doctor`; ждать дольше: "
        "`--timeout`.",
    ),
    errors.WrongEchoSetting: Text(
        "That is `--echo auto`, or no `--echo` at all.",
        "Это `--echo auto` или команда без ключа `--echo`.",
    ),
    errors.AnswersLate: Text(
        "The option is `--timeout {wanted:g}`.", "Ключ: `--timeout {wanted:g}`."
    ),
    errors.EchoOnly: Text(
        "For a slow unit, `--timeout 2` waits longer; `mikas doctor --other-units` looks for "
        "another kind of unit.",
        "Если блок медленный, `--timeout 2` ждёт дольше; `mikas doctor --other-units` ищет блок "
        "другого рода.",
    ),
    errors.EchoDiffers: Text(
        "The option is `--echo`; `mikas doctor` checks the connection step by step.",
        "Эхо настраивает ключ `--echo`; `mikas doctor` проверит связь по шагам.",
    ),
    errors.EchoTwice: _DOCTOR,
    errors.LineError: _DOCTOR,
    errors.NotSupported: Text(
        "`mikas info` shows the commands of this one.",
        "Команды этого блока показывает `mikas info`.",
    ),
    errors.BrokerRefused: Text(
        "Name and password are given by `--user` and `--password-file`, or by MIKAS_MQTT_USER and "
        "MIKAS_MQTT_PASSWORD.",
        "Имя и пароль задают ключи `--user` и `--password-file` или переменные MIKAS_MQTT_USER и "
        "MIKAS_MQTT_PASSWORD.",
    ),
    errors.BrokerNotTrusted: Text(
        "`--tls-ca FILE` names the certificate of your own authority.",
        "Сертификат своего центра указывает `--tls-ca FILE`.",
    ),
    errors.ListLost: Text("`mikas list set` does that.", "Это делает `mikas list set`."),
    errors.NeedsSamples: Text(
        "`mikas watch {name}` does that.", "Это делает `mikas watch {name}`."
    ),
    errors.UnknownParameter: Text(
        "`mikas params` lists all parameters.", "Все параметры: `mikas params`."
    ),
}

_OVER_NETWORK: dict[type[errors.MikasError], Text] = {
    errors.NoEcho: Text(
        "Over a slow network, `--timeout 5` waits longer; `mikas doctor` checks the connection "
        "step by step.",
        "В медленной сети `--timeout 5` ждёт дольше; проверка связи по шагам: `mikas doctor`.",
    ),
}

ADVICE: Final = errors.AdviceTable(_HINTS, _OVER_NETWORK)
_IN_DOCTOR = (
    *(
        errors.PortNotFound,
        errors.NoPortGiven,
        errors.TakenByBrltty,
        errors.PortProbed,
        errors.PortDenied,
    ),
    *(errors.AnswersLate, errors.EchoOnly, errors.WrongEchoSetting),
)
DOCTOR_ADVICE: Final = errors.AdviceTable({kind: _HINTS[kind] for kind in _IN_DOCTOR})
"""While `mikas doctor` runs, it is not advised."""
