"""What each change of the unit would do: read before it is asked for, made once it is confirmed.

The client's gate asks at the last moment (`approval`), journals, and reads back.
"""

from __future__ import annotations

from typing import Any

from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.client.ecu import erasing
from mikas.client.gate import hex_or_none
from mikas.client.memory.spaces import last_of, writing
from mikas.client.reading import decode
from mikas.commands.base import check_range
from mikas.dashboard.api.errors import in_hex
from mikas.dashboard.changes_wishes import WriteMemory, WriteParameter
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import BadRequest
from mikas.dashboard.security.confirmations import Prepared
from mikas.errors import NotSupported, ValueDoesNotFit
from mikas.i18n import Text, byte_count


async def erase(hub: Hub) -> Prepared:
    """The stored faults, which would be gone."""
    page = await hub.ask(hub.read_faults)
    codes = [fault.code for fault in page.faults]

    async def make() -> dict[str, Any]:
        def erase(ecu: Ecu) -> list[int]:
            with hub.approval.given(hex_or_none(bytes(codes))):
                erased = ecu.erase_faults()
            hub.fault_history.add(erased.after, ecu.tester.link.now(), erased=True)
            return [fault.code for fault in erased.after]

        return {"before": codes, "after": await hub.ask(erase)}

    return Prepared(
        what=erasing(len(codes)),
        before=codes,
        after=[],
        lost=tuple(
            {"code": fault.code, "en": fault.text.en, "ru": fault.text.ru} for fault in page.faults
        ),
        make=make,
    )


async def write_parameter(hub: Hub, wish: WriteParameter) -> Prepared:
    """One parameter; raises for a value that does not fit it."""
    parameter = hub.catalog.parameter(wish.name)
    reading = hub.settings.connection.interpretation
    datum = _datum(parameter, wish, reading)
    before = await hub.ask(lambda ecu: _read(ecu, parameter))

    async def make() -> dict[str, Any]:
        def write(ecu: Ecu) -> Reading | None:
            with hub.approval.given(hex_or_none(before.raw) if before else None):
                return ecu.write_parameter(parameter.name, raw=datum).after

        return {"before": _told(before), "after": _told(await hub.ask(write))}

    after = decode(parameter, datum, hub.now(), reading)
    return Prepared(
        what=Text(f"write parameter {parameter.name}", f"записать параметр {parameter.name}"),
        before=_told(before),
        after=_told(after),
        make=make,
        meaning=Text(
            f"{parameter.text.en}: {before or 'not readable'} → {after}",
            f"{parameter.text.ru}: {before or 'не читается'} → {after}",
        ),
        needs_unlock=True,
    )


def _datum(parameter: Parameter, wish: WriteParameter, interpretation: str) -> bytes:
    if (wish.value is None) == (wish.raw is None):
        raise BadRequest(
            problem=Text("give a value or raw bytes", "нужно значение или исходные байты")
        )
    if wish.value is not None:
        return parameter.encode(wish.value, interpretation)
    raw = bytes.fromhex(wish.raw or "")
    if len(raw) != parameter.size:
        raise ValueDoesNotFit(
            value=wish.raw,
            name=parameter.name,
            allowed=Text("it has {size}", "в нём {size}").filled(size=byte_count(parameter.size)),
        )
    return raw


def _read(ecu: Ecu, parameter: Parameter) -> Reading | None:
    try:
        return ecu.read(parameter.name)[parameter.name]
    except NotSupported:
        return None


def _told(reading: Reading | None) -> dict[str, Any] | None:
    if reading is None:
        return None
    return {"value": reading.value, "unit": reading.unit, "raw": in_hex(reading.raw)}


async def write_memory(hub: Hub, wish: WriteMemory) -> Prepared:
    """Some bytes; raises for a range that the space does not have."""
    data = bytes.fromhex(wish.data)
    check_range(wish.space, last_of(wish.space), wish.address, len(data))
    before = await hub.ask(lambda ecu: ecu.memory[wish.space].read_block(wish.address, len(data)))

    async def make() -> dict[str, Any]:
        def write(ecu: Ecu) -> bytes:
            with hub.approval.given(hex_or_none(before)):
                return ecu.memory[wish.space].write_block(wish.address, data).after

        return {"before": in_hex(before), "after": in_hex(await hub.ask(write))}

    where = f"{wish.space} {wish.address:04X}"
    danger = wish.space == "code"
    return Prepared(
        what=writing(len(data), where),
        before=in_hex(before),
        after=in_hex(data),
        make=make,
        danger=danger,
        meaning=_PROGRAM if danger else _WORKING,
        needs_unlock=True,
    )


_PROGRAM = Text(
    "This is the unit's program and data: a wrong byte can leave it unable to run the engine.",
    "Это программа и данные блока: с неверным байтом двигатель может больше не завестись.",
)
_WORKING = Text(
    "This is working memory: the engine may stumble or stall; switching the ignition off undoes "
    "it.",
    "Это рабочая память: двигатель может дёрнуться или заглохнуть; выключение зажигания всё "
    "вернёт.",
)
