"""`mikas co`: the idle CO set by a gas analyser or a λ meter, one confirmed write after another."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import YES, command, option
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, localized, tr
from mikas.cli.options.parameter_types import positive
from mikas.cli.render.terminal import write_error
from mikas.errors import NotConfirmed, usage_error
from mikas.guided.co_conditions import CHANNEL, NEEDED, idle_problems, not_kept
from mikas.guided.co_setting import (
    BOUNDS,
    WIDEST,
    WITHIN,
    CoOutcome,
    CoSetting,
    CoStep,
    MixtureMeter,
)
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.catalog import Parameter
    from mikas.client import Ecu

_WHAT: Final = Text("set the idle CO by RCOD", "регулировка СО холостого хода через RCOD")


@command(
    en="Sets the idle mixture by the figure of a gas analyser (CO, %) or, with --lambda, of a λ "
    "meter: reads RCOD, asks for the figure, says what to write and why, writes it after a "
    "confirmation, and asks again until the figure is within --within of --target. If it does not "
    "follow, the value that was found is put back. The engine has to be at warm idle. With "
    "--measured it takes that figure, makes one step and ends.",
    ru="Регулирует смесь холостого хода по газоанализатору (СО, %) или, с ключом --lambda, по "
    "лямбда-прибору: читает RCOD, спрашивает показание, говорит, что записать и почему, после "
    "подтверждения записывает и спрашивает снова, пока показание не окажется в пределах --within "
    "от --target. Если оно не меняется, возвращает найденное значение. Двигатель должен быть "
    "прогрет и работать на холостом ходу. С --measured берёт это показание и делает один шаг.",
    examples=(
        "mikas co --target 0.8",
        "mikas co --target 0.98 --lambda",
        "mikas co --target 0.8 --measured 1.6",
    ),
)
@option(
    "--target",
    type=positive,
    required=True,
    metavar="FIGURE",
    en="the figure to reach, by the papers of the car; required",
    ru="какое показание нужно, по документам на машину; обязательно",
)
@option(
    "--within",
    type=positive,
    metavar="FIGURE",
    en="how near is near enough (0.2 % CO, 0.015 λ)",
    ru="насколько близко достаточно (0.2 % СО, 0.015 λ)",
)
@option(
    "--lambda",
    "is_lambda",
    is_flag=True,
    en="the figures are λ",
    ru="показания — λ",
)
@option(
    "--measured",
    type=positive,
    metavar="FIGURE",
    en="what the meter shows now: one step, no questions but the confirmation",
    ru="что прибор показывает сейчас: один шаг без вопросов, кроме подтверждения",
)
@YES
def co(
    context: CommandContext,
    *,
    target: float,
    within: float | None,
    is_lambda: bool,
    measured: float | None,
    yes: bool,
) -> None:
    meter = MixtureMeter.LAMBDA if is_lambda else MixtureMeter.CO
    for name, figure in (("--target", target), ("--measured", measured)):
        if figure is not None and not _is_possible(figure, meter):
            raise _impossible(name, figure, meter)
    if within is not None and within > WIDEST[meter]:
        raise usage_error(
            f"--within {within:g}: near enough is up to {WIDEST[meter]:g}",
            f"--within {within:g}: достаточная точность — до {WIDEST[meter]:g}",
        )
    if measured is None and not sys.stdin.isatty():
        raise usage_error(
            "There is no terminal to ask for the meter's figure at; give it by --measured",
            "Нет терминала, чтобы спросить показание; задайте его ключом --measured",
        )
    parameter = context.options.catalog.parameter(CHANNEL)
    confirm = context.confirm(yes=yes, meaning=partial(_meaning, parameter))
    with context.ecu(confirm) as ecu:
        _check_idle(ecu)
        found = ecu.read(CHANNEL)[CHANNEL].raw[0]
        setting = CoSetting(found, target, within or WITHIN[meter], meter)
        adjusting = _Adjusting(context, ecu, parameter, setting)
        adjusting.run(measured)
    if context.output.json:
        context.output.data(adjusting.as_json())


@dataclass(slots=True)
class _Adjusting:
    """The loop of questions and writes, and what was done."""

    context: CommandContext
    ecu: Ecu
    parameter: Parameter
    setting: CoSetting
    steps: list[tuple[float, CoStep]] = field(default_factory=list)
    has_written: bool = False

    def run(self, measured: float | None) -> None:
        """Go on until the figure is in the band, or a stop; with `measured` for one step."""
        self._say(tr("found", "найдено"))
        try:
            while True:
                figure = self._asked() if measured is None else measured
                if measured is None:  # it may have taken minutes
                    self._check_held()
                    _check_idle(self.ecu)
                step = self.setting.next(figure)
                self.steps.append((figure, step))
                if step.turned:
                    self.context.say(
                        "This unit counts the other way: less is richer.",
                        "Этот блок считает наоборот: меньше — богаче.",
                    )
                self.context.output.print_note(localized(step.why))
                if step.outcome is CoOutcome.SET:
                    break
                self._write(step.raw)
                if step.outcome is CoOutcome.STOP or measured is not None:
                    break
        except BaseException:
            self._say_how_to_put_back()
            raise
        self._say(tr("now", "теперь"))
        if self.steps[-1][1].outcome is not CoOutcome.STOP:
            self._say_how_to_put_back()

    def _write(self, raw: int) -> None:
        """Write the byte, after a confirmation, unless the unit has it."""
        if self._held() != raw:
            self.ecu.write_parameter(CHANNEL, raw=bytes([raw]))
            self.has_written = True

    def _held(self) -> int:
        return self.ecu.read(CHANNEL)[CHANNEL].raw[0]

    def _check_held(self) -> None:
        """Raise if the unit has another value than the written one: it sets that itself."""
        held = self._held()
        if held != self.setting.raw:
            wrote, has = (_value(self.parameter, each) for each in (self.setting.raw, held))
            raise NotConfirmed(
                change=_WHAT,
                how=not_kept(wrote, has),
            )

    def _asked(self) -> float:
        """Ask for the meter's figure until it is one."""
        name = "λ" if self.setting.meter is MixtureMeter.LAMBDA else tr("CO, %", "СО, %")
        while True:
            write_error(
                tr(
                    f"Wait until the meter is steady. {name} = ",
                    f"Дождитесь, пока показание установится. {name} = ",
                )
            )
            line = sys.stdin.readline()
            if not line.endswith("\n"):
                write_error("\n")
                raise KeyboardInterrupt
            try:
                figure = float(line.strip().replace(",", "."))
            except ValueError:
                figure = -1.0
            if _is_possible(figure, self.setting.meter):
                return figure
            low, high = BOUNDS[self.setting.meter]
            self.context.say(
                f"A number from {low:g} to {high:g} is needed; Ctrl-C ends it.",
                f"Нужно число от {low:g} до {high:g}; Ctrl-C — закончить.",
            )

    def _say(self, when: str) -> None:
        if not self.context.output.json:
            held = self.setting.found if not self.steps else self.steps[-1][1].raw
            self.context.output.line(f"RCOD {when}: {_value(self.parameter, held)} ({held:02X})")

    def _say_how_to_put_back(self) -> None:
        if self.has_written:
            found = f"{self.setting.found:02X}"
            self.context.say(
                f"The value that was found comes back by: mikas write RCOD --raw {found}",
                f"Вернуть найденное значение: mikas write RCOD --raw {found}",
            )

    def as_json(self) -> dict[str, object]:
        steps = [
            {"measured": figure, "outcome": step.outcome.value, "raw": f"{step.raw:02X}"}
            for figure, step in self.steps
        ]
        last = self.steps[-1][1]
        return {
            "outcome": last.outcome.value,
            "raw_before": f"{self.setting.found:02X}",
            "raw_after": f"{last.raw:02X}",
            "why": last.why._asdict(),
            "steps": steps,
        }


def _check_idle(ecu: Ecu) -> None:
    """Raise `NotConfirmed` if the engine is not at warm idle: another mixture would be set."""
    values = {name: float(each.value) for name, each in ecu.read(*NEEDED).items()}
    problems = idle_problems(values)
    if problems:
        how = Text(*("; ".join(texts) for texts in zip(*problems, strict=True)))
        raise NotConfirmed(
            change=_WHAT,
            how=Text(f"It needs warm idle: {how.en}.", f"Нужен прогретый холостой ход: {how.ru}."),
        )


def _is_possible(figure: float, meter: MixtureMeter) -> bool:
    low, high = BOUNDS[meter]
    return low <= figure <= high


def _impossible(name: str, figure: float, meter: MixtureMeter) -> Exception:
    low, high = BOUNDS[meter]
    what = "λ" if meter is MixtureMeter.LAMBDA else "% CO"
    return usage_error(
        f"{name} {figure:g}: a figure of {what} is from {low:g} to {high:g}; λ needs --lambda",
        f"{name} {figure:g}: показание ({what}) бывает от {low:g} до {high:g}; для λ нужен "
        "--lambda",
    )


def _value(parameter: Parameter, raw: int) -> str:
    shown = f"{parameter.decode(bytes([raw])):.{parameter.decimals}f}"
    return decimal(shown.replace("-", "−"))


def _meaning(parameter: Parameter, hexed: str) -> str:
    return f"{_value(parameter, bytes.fromhex(hexed)[0])} ({hexed})"
