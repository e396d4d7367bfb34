"""Errors of the server itself: access, control, confirmations, missing resources.

They belong to the one tree of errors: texts in both languages, with advice. `status` is the HTTP
status of the response. `ADVICE` names the dashboard's screens after errors of the lower packages.
"""

from __future__ import annotations

from typing import ClassVar, Final

from mikas import errors
from mikas.i18n import Text


class ApiRefusal(errors.MikasError):
    """The server refused the request; nothing was sent to the unit."""

    status: ClassVar[int] = 400

    def __init_subclass__(cls, *, status: int | None = None) -> None:
        super().__init_subclass__()
        cls.status = cls.status if status is None else status


class BadRequest(ApiRefusal):
    """Invalid request."""

    what: ClassVar[Text] = Text("Invalid request: {problem}", "Неверный запрос: {problem}")
    advice: Text = Text(
        "The requests are described at /api/docs.", "Запросы описаны на странице /api/docs."
    )


class TooLarge(BadRequest, status=413):
    """The body is larger than any request of the API."""


class TokenRequired(ApiRefusal, status=401):
    """A request from the network without the token."""

    what: ClassVar[Text] = Text(
        "Access from the network needs the token",
        "Из сети панель доступна только по ссылке с ключом",
    )
    advice: Text = Text(
        "Open the link that the laptop shows, or scan its QR code.",
        "Откройте ссылку с экрана ноутбука или отсканируйте QR-код.",
    )


class Forbidden(ApiRefusal, status=403):
    """A foreign host, or the page of another site."""

    what: ClassVar[Text] = Text("Refused: {problem}", "Отказано: {problem}")
    advice: Text = Text(
        "Open the dashboard at the address that it printed at its start.",
        "Откройте панель по адресу, который она вывела при запуске.",
    )


class NotAllowed(ApiRefusal, status=403):
    """The client has view rights only."""

    what: ClassVar[Text] = Text(
        "This client may view but not control", "Этому клиенту доступен только просмотр"
    )
    advice: Text = Text(
        "Use the laptop itself, or allow control on its Connection screen.",
        "Управляйте с самого ноутбука или разрешите управление на его экране «Связь».",
    )


class NotFromNetwork(ApiRefusal, status=403):
    """A port that only this computer's own user may choose."""

    what: ClassVar[Text] = Text(
        "“{url}” can't be chosen from the network", "Из сети нельзя выбрать «{url}»"
    )
    advice: Text = Text(
        "Available from here: the adapters that the laptop lists, and its virtual cars. Choose "
        "anything else on the laptop itself.",
        "Отсюда можно выбрать адаптеры из списка ноутбука и его виртуальные автомобили. Всё "
        "остальное выбирают на самом ноутбуке.",
    )


class OnlyHere(ApiRefusal, status=403):
    """A client in the network wants to open or close the dashboard to the network."""

    what: ClassVar[Text] = Text(
        "Access from the network is switched on the computer itself",
        "Доступ из сети включают только на самом компьютере",
    )
    advice: Text = Text(
        "Use the Connection screen of the computer with the cable.",
        "Откройте экран «Связь» на компьютере с кабелем.",
    )


class Locked(ApiRefusal, status=403):
    """Writing has not been unlocked."""

    what: ClassVar[Text] = Text("Writing is locked", "Запись заблокирована")
    advice: Text = Text(
        "Unlock writing first. It is locked again automatically after some minutes.",
        "Сначала разблокируйте запись. Через несколько минут она снова заблокируется.",
    )


_AT_HOME = Text(
    "The dashboard is at /, the API is described at /api/docs.",
    "Панель открывается по адресу /, API описан на странице /api/docs.",
)


class NotFound(ApiRefusal, status=404):
    """The resource does not exist."""

    what: ClassVar[Text] = Text("Not found: {name}", "Не найдено: {name}")
    advice: Text = Text("Reload the list.", "Обновите список.")

    @classmethod
    def at(cls, path: str) -> NotFound:
        """Return the error for an address without a resource."""
        return cls(name=path, advice=_AT_HOME)


class NotController(ApiRefusal, status=409):
    """Another client has control."""

    what: ClassVar[Text] = Text("{holder} has control", "Управляет {holder}")
    advice: Text = Text(
        "View only, ask the other client to release control, or take control over.",
        "Можно смотреть, попросить передать управление или взять его на себя.",
    )


_CHANGED_SINCE = Text(
    "The content of the unit has changed since it was shown",
    "Содержимое блока изменилось после показа",
)


class ConfirmationOutdated(ApiRefusal, status=409):
    """The content that was shown before the change is no longer the same."""

    what: ClassVar[Text] = Text("{found}; nothing was changed", "{found}; ничего не изменено")
    advice: Text = Text(
        "Check it again, then confirm again.", "Проверьте ещё раз и подтвердите снова."
    )

    def __init__(self, found: Text = _CHANGED_SINCE) -> None:
        super().__init__(found=found)


class CatalogOutdated(ApiRefusal, status=409):
    """The catalog was changed since the client has loaded it."""

    what: ClassVar[Text] = Text(
        "The catalog was changed meanwhile, on another page or in its file",
        "Каталог тем временем изменили на другой странице или в его файле",
    )
    advice: Text = Text(
        "Nothing was saved. Look at the present values, then change them again.",
        "Ничего не сохранено. Посмотрите на нынешние значения и измените их снова.",
    )


class Busy(ApiRefusal, status=409):
    """Another request is in the way."""

    what: ClassVar[Text] = Text("Not now: {problem}", "Не сейчас: {problem}")


class TookTooLong(ApiRefusal, status=504):
    """Reading a recording, a report or an export passed its deadline; it was cancelled."""

    what: ClassVar[Text] = Text(
        "This took longer than {seconds} s and was cancelled",
        "Это заняло больше {seconds} с и прервано",
    )
    advice: Text = Text(
        "The file is very long or damaged. The command line has no such limit: "
        "mikas report FILE -o OUT.html, mikas export FILE -o OUT.csv.",
        "Файл очень большой или повреждён. В командной строке такого предела нет: "
        "mikas report ФАЙЛ -o ОТЧЁТ.html, mikas export ФАЙЛ -o ТАБЛИЦА.csv.",
    )


class AnswerTookTooLong(TookTooLong):
    """A request that reads no recording passed its deadline; it was cancelled."""

    advice: Text = Text(
        "Ask for a shorter time, for fewer channels, or by a shorter formula.",
        "Запросите меньшее время, меньше каналов или формулу короче.",
    )


class ConfirmationExpired(ApiRefusal, status=410):
    """An unknown, expired or used confirmation, or that of another client."""

    what: ClassVar[Text] = Text(
        "This confirmation has expired or was already used",
        "Подтверждение истекло или уже использовано",
    )
    advice: Text = Text("Start the change again.", "Начните изменение заново.")


class NotConnected(ApiRefusal, status=503):
    """No unit answers at the moment."""

    what: ClassVar[Text] = Text("There is no connection to a unit", "Нет связи с блоком")
    advice: Text = Text(
        "Connect first; the state line shows how far the connection has come.",
        "Сначала установите связь; на каком она этапе, показывает строка состояния.",
    )


class InternalError(ApiRefusal, status=500):
    """A bug in mikas. `url`: the port's, whose password no text may have."""

    more_fields: ClassVar[frozenset[str]] = frozenset({"url"})

    what: ClassVar[Text] = Text(
        "Internal error in mikas ({kind})", "Внутренняя ошибка mikas ({kind})"
    )
    advice: Text = Text("Please report it.", "Сообщите о ней разработчикам.")


ADVICE: Final = errors.AdviceTable(
    {
        errors.PortNotFound: Text(
            "Connect it again and sampling resumes. For another adapter, or a virtual car, open "
            "the Connection screen.",
            "Подключите его — и опрос продолжится. Другой адаптер или виртуальный автомобиль "
            "выбирается на экране «Связь».",
        ),
        errors.NoPortGiven: Text(
            "Choose an adapter, or a virtual car, on the Connection screen.",
            "Выберите адаптер или виртуальный автомобиль на экране «Связь».",
        ),
        errors.DiskFull: Text(
            "On the Recordings screen old recordings can be downloaded and deleted; other files "
            "of this computer take room, too.",
            "Старые записи можно скачать и удалить на экране «Записи»; место занимают и другие "
            "файлы этого компьютера.",
        ),
        errors.LinkLost: Text(
            "The connection is restored automatically.", "Соединение восстановится автоматически."
        ),
        errors.NoEcho: Text(
            "The Connection screen lists the ports.", "Порты перечислены на экране «Связь»."
        ),
        errors.NoResponse: Text(
            "The Passport screen shows the commands that the unit knows.",
            "Какие команды знает блок, показывает экран «Паспорт».",
        ),
        errors.NotSupported: Text(
            "The Passport screen shows the commands of this one.",
            "Команды этого блока показывает экран «Паспорт».",
        ),
    },
    over_network={
        errors.NoEcho: Text(
            "The Connection screen checks the connection step by step.",
            "Связь проверяется по шагам на экране «Связь».",
        ),
    },
)


def api_hex(data: bytes | None) -> str | None:
    """Return bytes as the API shows them: upper-case hex without spaces."""
    return None if data is None else data.hex().upper()
