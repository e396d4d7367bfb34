"""`mikas pull`: power and torque from the pulls of a recording. It needs no port."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import argument, command, option
from mikas.cli.completion.values import RECORDING, files
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, tr
from mikas.cli.options.parameter_types import existing_file, number
from mikas.json_values import picked

if TYPE_CHECKING:
    from mikas.drives.pulls import Pull, PullPoint

_HORSE: Final = 0.73549875  # kW


@command(
    en="Computes power and torque from the pulls of a recording (.pcapng): full throttle in one "
    "gear, and a rise of 1000 rpm or more. It needs the mass of the car, with driver, load and "
    "fuel. The speed is that of a GPS beside the unit, or, with --per-1000, the engine's in a "
    "known gear. The figures are those at the wheels; each has its doubt.",
    ru="Считает мощность и момент по разгонам в записи (.pcapng): полный газ на одной передаче, "
    "обороты растут на 1000 и больше. Нужна масса машины с водителем, грузом и топливом. Скорость "
    "берётся у GPS рядом с блоком, а с ключом --per-1000 — по оборотам на известной передаче. "
    "Числа — на колёсах, у каждого своя погрешность.",
    examples=(
        "mikas pull drive.pcapng --mass 1600",
        "mikas pull drive.pcapng --mass 1600 --per-1000 23 --slope 0.5",
    ),
)
@argument("file", "FILE", type=existing_file, shell_complete=files(*RECORDING))
@option(
    "--mass",
    type=number,
    required=True,
    metavar="KG",
    en="mass of the car as it was driven; required",
    ru="масса машины во время разгона; обязательна",
)
@option(
    "--per-1000",
    type=number,
    metavar="KM/H",
    en="speed at 1000 rpm in the gear of the pull, in place of a GPS",
    ru="скорость при 1000 об/мин на передаче разгона, вместо GPS",
)
@option(
    "--drag-area",
    type=number,
    metavar="M2",
    default="0.9",
    en="drag coefficient by front, m² (0.9)",
    ru="коэффициент сопротивления на площадь спереди, м² (0.9)",
)
@option(
    "--slope",
    type=number,
    metavar="PERCENT",
    default="0",
    en="of the road, up is positive (0)",
    ru="уклон дороги, подъём — плюс (0)",
)
def pull(
    context: CommandContext,
    file: Path,
    *,
    mass: float,
    per_1000: float | None,
    drag_area: float,
    slope: float,
) -> None:
    from mikas.drives.pulls import PullSettings, pulls
    from mikas.recording.recording import Recording

    settings = PullSettings(mass, per_1000, drag_area, slope=slope / 100)
    found = pulls(Recording(file, context.options.catalog), settings)
    if context.output.json:
        context.output.data({"pulls": [_as_json(each) for each in found]})
        return
    if not found:
        context.say(
            "There is no pull in this recording: full throttle (THR) in one gear, for 2.5 s or "
            "more, over 1000 rpm or more.",
            "Разгона в этой записи нет: полный газ (THR) на одной передаче, не меньше 2,5 с и "
            "1000 об/мин.",
        )
    for at, each in enumerate(found):
        if at:
            context.output.line()
        _show(context, each)


def _as_json(pull: Pull) -> dict[str, object]:
    names = ("session", "begin", "end", "speed_from", "per_1000", "slip", "throttle_known")
    columns = ("rpm", "speed", "power", "torque", "doubt", "torque_doubt")
    points = [picked(point, *columns) for point in pull.points]
    return {**picked(pull, *names), "points": points}


def _show(context: CommandContext, pull: Pull) -> None:
    """Print the best figures, then the points."""
    from mikas.drives.pulls import SLIPS

    power, torque = pull.most_power, pull.most_torque
    context.output.paragraph(
        tr(
            f"{pull.from_rpm:.0f} to {pull.to_rpm:.0f} rpm in "
            f"{pull.end - pull.begin:.1f} s, {pull.per_1000:.1f} km/h at 1000 rpm. At the wheels "
            f"{_of(power.power, power.doubt)} kW ({power.power / _HORSE:.0f} hp) at "
            f"{power.rpm:.0f} rpm, {_of(torque.torque, torque.torque_doubt)} Nm at "
            f"{torque.rpm:.0f} rpm; 8 to 15 % more at the engine.",
            f"{pull.from_rpm:.0f}–{pull.to_rpm:.0f} об/мин за "
            f"{decimal(f'{pull.end - pull.begin:.1f}')} с, "
            f"{decimal(f'{pull.per_1000:.1f}')} км/ч при 1000 об/мин. На колёсах "
            f"{_of(power.power, power.doubt)} кВт ({power.power / _HORSE:.0f} л.с.) при "
            f"{power.rpm:.0f} об/мин, {_of(torque.torque, torque.torque_doubt)} Н·м при "
            f"{torque.rpm:.0f} об/мин; у двигателя на 8–15 % больше.",
        )
    )
    columns: dict[str, Callable[[PullPoint], str]] = {
        tr("rpm", "об/мин"): lambda point: f"{point.rpm:.0f}",
        tr("km/h", "км/ч"): lambda point: f"{point.speed:.0f}",
        tr("kW", "кВт"): lambda point: _of(point.power, point.doubt),
        tr("hp", "л.с."): lambda point: f"{point.power / _HORSE:.0f}",
        tr("Nm", "Н·м"): lambda point: _of(point.torque, point.torque_doubt),
    }
    context.output.listing(pull.points, columns, right="01234")
    if pull.slip > SLIPS:
        context.say(
            f"The gear seems to change by {100 * pull.slip:.0f} %: the clutch or a wheel slips, or "
            "the receiver is too slow; these figures are worth little.",
            f"Передача будто меняется на {100 * pull.slip:.0f} %: буксует сцепление или колесо, "
            "или приёмник слишком медленный; этим числам верить нельзя.",
        )

    if not pull.throttle_known:
        context.say(
            "The throttle (THR) was not recorded: whether it was open is not known.",
            "Дроссель (THR) не записан: был ли газ полным, неизвестно.",
        )


def _of(value: float, doubt: float) -> str:
    return f"{value:.0f} ± {doubt:.0f}"
