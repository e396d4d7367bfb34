"""Why a cycle brought nothing, in words that are true of the unit at hand (D10).

A tester can only say that a command was refused. Of a unit that has answered it before, that it
does not know it would be wrong: it refuses a parameter, or this list of them.
"""

from __future__ import annotations

from mikas.client import Ecu
from mikas.client.data import refused
from mikas.client.polling import STREAMS
from mikas.commands import ReadParameters
from mikas.errors import MikasError, NotSupported
from mikas.framing import Decoder, Frame
from mikas.i18n import Text
from mikas.sampling.plan import Plan


def explained(ecu: Ecu, plan: Plan, error: MikasError, *, worked: bool) -> MikasError:
    """What is to be told of `error`. `worked`: `plan` has brought something before."""
    frames = Decoder().feed(error.request or b"") if isinstance(error, NotSupported) else []
    bodies = [frame.body for frame in frames if isinstance(frame, Frame)]
    if not bodies:
        return error
    code, *asked = bodies[0]
    if not (ecu.tester.has_answered(code) or worked):
        return error
    known = _refusal(plan, code, asked)
    known.request, known.received, known.time = error.request, error.received, error.time
    known.__cause__ = error.__cause__
    return known


def _refusal(plan: Plan, code: int, asked: list[int]) -> NotSupported:
    names = [w.parameter.name for w in plan.parameters if w.parameter.code in asked]
    if code in ReadParameters.CODES and len(set(asked)) == 1 and names:
        return refused(", ".join(names), asked[0])
    kind = Text("a stream", "потока") if plan.method in STREAMS else Text("a list", "списка")
    count = len(set(asked)) or len(plan.fast)  # 63 names none
    return NotSupported(
        command=Text(
            f"{kind.en} ({code:02X}) of these parameters ({count})",
            f"{kind.ru} ({code:02X}) из этих параметров ({count})",
        )
    )
