"""`mikas completion`: the script by which a shell completes command lines of mikas."""

from __future__ import annotations

from mikas.cli.click_extensions import argument, command
from mikas.cli.completion import SHELLS, script
from mikas.cli.context import CommandContext
from mikas.cli.options.parameter_types import OneOf


@command(
    en="Prints the script of SHELL by which the Tab key completes commands, options and values: "
    "names of channels, ports, files. The .deb brings the scripts of bash, zsh and fish. Else, in "
    '~/.bashrc or ~/.zshrc: `eval "$(mikas completion bash)"`; in PowerShell\'s $PROFILE: '
    "`mikas completion powershell | Out-String | Invoke-Expression`",
    ru="Печатает скрипт для оболочки SHELL: после него клавиша Tab дополняет команды, ключи и "
    "значения — имена каналов, порты, файлы. Для bash, zsh и fish скрипты ставит пакет .deb. Без "
    'него в ~/.bashrc или ~/.zshrc: `eval "$(mikas completion bash)"`; в $PROFILE для '
    "PowerShell: `mikas completion powershell | Out-String | Invoke-Expression`",
    examples=(
        "mikas completion bash",
        "mikas completion fish > ~/.config/fish/completions/mikas.fish",
        "mikas completion powershell",
    ),
)
@argument("shell", metavar="SHELL", type=OneOf(SHELLS))
def completion(context: CommandContext, shell: str) -> None:
    text = script(shell)
    context.output.result({"shell": shell, "script": text}, text.rstrip("\n"))
