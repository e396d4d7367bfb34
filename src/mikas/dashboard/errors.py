"""What the API refuses by itself, before or beside the line: rights, seats, nonces, what is not
there.

They are branches of the one tree of errors, so they are told as every other error: both languages,
and what to try. `status` is the HTTP status that says the same.
"""

from __future__ import annotations

from typing import ClassVar

from mikas.errors import MikasError
from mikas.i18n import Text


class ApiRefusal(MikasError):
    """The server said no; nothing was sent to the unit."""

    status: ClassVar[int] = 400


class BadRequest(ApiRefusal):
    """The request itself makes no sense."""

    what = Text("The request makes no sense: {problem}", "Запрос не понят: {problem}")
    advice = Text("What is understood: /api/docs.", "Что понимается: /api/docs.")


class TooLarge(BadRequest):
    """More bytes than anything that the API takes."""

    status = 413


class TokenRequired(ApiRefusal):
    """From the network nobody is let in without the token."""

    status = 401
    what = Text(
        "From the network this needs the token", "Из сети сюда можно только по ссылке с ключом"
    )
    advice = Text(
        "Open the link, or scan the QR code, that the laptop shows.",
        "Откройте ссылку или снимите QR-код, которые показывает ноутбук.",
    )


class Forbidden(ApiRefusal):
    """Not from this host or page."""

    status = 403
    what = Text("Refused: {problem}", "Отказано: {problem}")
    advice = Text(
        "Open the dashboard by the address that it printed when it started.",
        "Откройте панель по тому адресу, который она назвала при запуске.",
    )


class NotAllowed(ApiRefusal):
    """This client may look, not touch."""

    status = 403
    what = Text("This viewer may look, not touch", "Этому зрителю можно смотреть, но не управлять")
    advice = Text(
        "Use the laptop itself, or start it with --lan-control.",
        "Управляйте с самого ноутбука или запустите его с --lan-control.",
    )


class NotFromNetwork(ApiRefusal):
    """A port that is for this computer's own user to choose."""

    status = 403
    what = Text("From the network “{url}” can't be chosen", "Из сети нельзя выбрать «{url}»")
    advice = Text(
        "From here: the adapters that the laptop lists, and its virtual cars. Anything else is "
        "chosen on the laptop itself.",
        "Отсюда можно выбрать адаптеры из списка ноутбука и его виртуальные автомобили. Всё "
        "остальное выбирают на самом ноутбуке.",
    )


class Locked(ApiRefusal):
    """Writing has not been unlocked."""

    status = 403
    what = Text("Writing is locked", "Запись заблокирована")
    advice = Text(
        "Unlock writing first; it locks itself again after some minutes.",
        "Сначала разблокируйте запись; через несколько минут она заблокируется сама.",
    )


_AT_HOME = Text(
    "The dashboard is at /, what the API answers stands at /api/docs.",
    "Панель — по адресу /, а что умеет API, написано в /api/docs.",
)


class NotFound(ApiRefusal):
    """No such thing."""

    status = 404
    what = Text("There is no {name}", "Нет такого: {name}")
    advice = Text("Reload the list.", "Обновите список.")

    @classmethod
    def at(cls, path: str) -> NotFound:
        """Nothing is at that address."""
        return cls(name=path, advice=_AT_HOME)


class NotController(ApiRefusal):
    """Somebody else decides what the line does."""

    status = 409
    what = Text("{holder} has control", "Управляет {holder}")
    advice = Text(
        "Watch along, ask them to let go, or take control over.",
        "Можно смотреть, попросить отпустить управление или взять его себе.",
    )


_NOT_AS_SHOWN = Text(
    "What stands in the unit is no longer what was shown",
    "В блоке уже не то, что было показано",
)


class ConfirmationOutdated(ApiRefusal):
    """What was shown before the change is no longer so."""

    status = 409
    what = Text("{found}, so nothing was changed", "{found}, поэтому ничего не изменено")
    advice = Text("Look at it again, then confirm again.", "Посмотрите и подтвердите заново.")

    def __init__(self, found: Text = _NOT_AS_SHOWN) -> None:
        super().__init__(found=found)


class Busy(ApiRefusal):
    """Not now."""

    status = 409
    what = Text("Not now: {problem}", "Не сейчас: {problem}")


class NonceUnknown(ApiRefusal):
    """A confirmation that is over, used, or somebody else's."""

    status = 410
    what = Text(
        "This confirmation is over, was used, or belongs to another client",
        "Это подтверждение истекло, уже использовано или чужое",
    )
    advice = Text("Begin the change again.", "Начните изменение заново.")


class NotConnected(ApiRefusal):
    """There is nobody to ask at the moment."""

    status = 503
    what = Text("There is no connection to a unit", "Нет связи с блоком")
    advice = Text(
        "Connect first; the state says how far the way to the unit is open.",
        "Сначала установите связь; докуда она есть, говорит строка состояния.",
    )


class InternalError(ApiRefusal):
    """Our own mistake, said as such."""

    status = 500
    what = Text("This is a bug in mikas ({kind})", "Это ошибка в самой программе mikas ({kind})")
    advice = Text("Please report it.", "Сообщите о ней.")
