"""`mikas split`: a file for each car of a recording that holds several. It needs no port."""

from __future__ import annotations

from pathlib import Path

from mikas.cli.click_extensions import argument, command
from mikas.cli.completion.values import RECORDING, files
from mikas.cli.context import CommandContext
from mikas.cli.language import localized
from mikas.cli.options.parameter_types import existing_file


@command(
    en="Makes a file of each car from a recording (.pcapng) that holds several, as one merged by "
    "mergecap or joined by cat: FILE-1.pcapng, FILE-2.pcapng … beside it. FILE stays as it is.",
    ru="Делает из записи (.pcapng) с несколькими машинами, например слитой программой mergecap "
    "или командой cat, по файлу на каждую машину: FILE-1.pcapng, FILE-2.pcapng … рядом с ней. "
    "Сам FILE не меняется.",
    examples=("mikas split merged.pcapng",),
)
@argument("file", "FILE", type=existing_file, shell_complete=files(*RECORDING))
def split(context: CommandContext, file: Path) -> None:
    from mikas.recording.splitting import cars_in
    from mikas.recording.splitting import split as write

    if len(cars_in(file)) < 2:
        context.say(
            f"{file} holds recordings of one car: nothing to split.",
            f"{file}: все записи одной машины, делить нечего.",
        )
        return
    for car, part in write(file, file):
        if context.output.json:
            context.output.data({"car": car.name._asdict(), "out": str(part)})
        else:
            context.output.line(f"{part}: {localized(car.name)}")
