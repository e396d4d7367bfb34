"""The greatest number that a unit takes: of codes in a list (D11), of bytes in a block.

Numbers go up by doubling, never straight to the largest: a unit without a check of its own has then
been asked for little more than it takes. What failed is asked for again before it counts: a foreign
frame, or a byte that the line has lost, must not pass for the unit's limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Self

from mikas.tester import Reply

MOST: Final = 255
_FIRST: Final = (2, 4, 8, 16, 32, 64, 128, MOST)
_AGAIN: Final = 3  # more requests for one number, at most, until two fail alike


@dataclass(frozen=True, slots=True)
class CountedResponse:
    """The response to a request for a number of things.

    `count`: of those that came; `form`: None if all, else `short`, `01`, `silent` or `other`.
    """

    count: int
    form: str | None

    @classmethod
    def of(cls, reply: Reply | None, count: int, *, size: int = 1, overhead: int = 0) -> Self:
        """Return what came, of a response with `overhead` bytes repeated, then `size` bytes each.

        None is silence.
        """
        if reply is None:
            return cls(0, "silent")
        came, rest = divmod(len(reply.body) - overhead, size)
        if came == count and not rest:
            return cls(count, None)
        if reply.body == b"\x01":
            return cls(0, "01")
        return cls(came, "short") if 0 < came < count and not rest else cls(0, "other")


def greatest(
    ask: Callable[[int], CountedResponse], progress: Callable[[int], None] = lambda _: None
) -> dict[str, Any]:
    """Return the greatest number that comes whole, and the form of the response to a greater one.

    `limit` None: not even two come; `beyond` None: the most that can be asked for comes.
    """
    good, bad, beyond = 0, MOST + 1, None
    tried = 0
    while bad - good > 1:
        following = next((number for number in _FIRST if number > good), MOST)
        number = following if bad > MOST else (good + bad) // 2
        response = _asked(ask, number)
        tried += 1
        progress(tried)
        if response.form is None:
            good = number
            continue
        bad, beyond = number, response.form
        if response.form == "short" and response.count > good and _comes(ask, response.count):
            good, bad = response.count, response.count + 1
    return {"limit": good or None, "beyond": beyond}


def _asked(ask: Callable[[int], CountedResponse], number: int) -> CountedResponse:
    """Return the response; one that fails counts if the next one fails alike.

    Silence counts at once: who asks has waited for two requests (`SurveyedUnit.ask`).
    """
    response = ask(number)
    for _ in range(_AGAIN):
        if response.form in (None, "silent"):
            break
        before, response = response, ask(number)
        if response.form == before.form:
            break
    return response


def _comes(ask: Callable[[int], CountedResponse], number: int) -> bool:
    return ask(number).form is None
