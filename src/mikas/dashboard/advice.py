"""What to try in the dashboard after an error: its screens, by the error's class."""

from __future__ import annotations

from typing import Final

from mikas.errors import (
    AdviceTable,
    LinkLost,
    NoEcho,
    NoPortGiven,
    NoResponse,
    NotSupported,
    PortNotFound,
)
from mikas.i18n import Text

ADVICE: Final = AdviceTable(
    {
        PortNotFound: Text(
            "Plug it back in and sampling resumes. For another adapter, or a virtual car, open the "
            "Connection screen.",
            "Подключите его — и опрос продолжится. Другой адаптер или виртуальный автомобиль "
            "выбирается на экране «Связь».",
        ),
        NoPortGiven: Text(
            "Choose an adapter, or a virtual car, on the Connection screen.",
            "Выберите адаптер или виртуальный автомобиль на экране «Связь».",
        ),
        LinkLost: Text(
            "The connection is restored automatically.", "Соединение восстановится автоматически."
        ),
        NoEcho: Text(
            "The Connection screen lists the ports.", "Порты перечислены на экране «Связь»."
        ),
        NoResponse: Text(
            "The Passport screen shows the commands that the unit knows.",
            "Какие команды знает блок, показывает экран «Паспорт».",
        ),
        NotSupported: Text(
            "The Passport screen shows the commands of this one.",
            "Команды этого блока показывает экран «Паспорт».",
        ),
    }
)
