"""The options that every command has (docs/reference/cli.md, Everywhere).

They may stand before or after the command's name: the group and every command have them; the last
one on the line wins. The config file sets the same, but `capture`, `json` and `verbose`. RELEARN is
an option of some commands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import click

from mikas.cli.completion.values import files, ports
from mikas.cli.config import CHECKSUMS, ECHO, INTERPRETATIONS, LANGUAGES, MAX_RETRIES
from mikas.cli.language import localized
from mikas.cli.options.parameter_types import (
    METAVARS,
    OFFERED,
    OneOf,
    any_file,
    pause,
    timeout,
    whole,
)
from mikas.i18n import Text


class LocalizedOption(click.Option):
    """An option whose help is in both languages; some types have a metavar.

    `listed`: returns the words for `{listed}` in the help, which is not called before it is shown.
    """

    def __init__(
        self,
        *args: Any,
        en: str,
        ru: str,
        words: Iterable[str] = (),
        listed: Callable[[], Iterable[str]] | None = None,
        **kwargs: Any,
    ) -> None:
        if words:
            kwargs |= {"type": OneOf(words), "metavar": f"[{'|'.join(words)}]"}
        kwargs.setdefault("metavar", METAVARS.get(kwargs.get("type")))
        kwargs.setdefault("shell_complete", OFFERED.get(kwargs.get("type")))
        super().__init__(*args, **kwargs)
        self._text = Text(en, ru)
        self._listed = listed

    @property
    def text(self) -> Text:
        """The help."""
        if self._listed is None:
            return self._text
        return self._text.filled(listed=", ".join(self._listed()))

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        record = super().get_help_record(ctx)
        # click's notes in brackets are English only; our texts contain limits and "required".
        return (record[0], localized(self.text)) if record else None


class CommonOption(LocalizedOption):
    """An option that every command has, before or after its name."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, expose_value=False, callback=_keep, **kwargs)


def _keep(ctx: click.Context, option: click.Parameter, value: object) -> object:
    """Store the value in the settings of this command; the last one on the line wins."""
    given = ctx.get_parameter_source(option.name or "")
    if given is click.core.ParameterSource.COMMANDLINE:
        ctx.find_root().ensure_object(dict)[option.name] = value
    return value


RELEARN = click.option(
    "--relearn",
    cls=LocalizedOption,
    is_flag=True,
    expose_value=False,
    callback=_keep,
    en="forget what was learnt of this unit (the fastest method, sizes of lists and blocks, "
    "refused codes) and find it out again",
    ru="забыть всё, что узнано об этом блоке (самый быстрый способ, размеры списков и блоков, "
    "неизвестные ему коды), и выяснить заново",
)
"""An option of the commands that use what was learnt of the unit (D10, D11)."""


def common_options() -> list[click.Parameter]:
    """Return new instances of the common options, for one command."""
    return [
        CommonOption(
            ["--port"],
            metavar="URL",
            shell_complete=ports,
            en="/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: (a virtual "
            "ECU), replay:FILE (a recorded one)",
            ru="/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: (виртуальный "
            "блок), replay:FILE (записанный)",
        ),
        CommonOption(
            ["--echo"],
            words=ECHO,
            en="whether the adapter echoes what it sends (auto: detect)",
            ru="возвращает ли адаптер эхо (auto: определить)",
        ),
        CommonOption(
            ["--timeout"],
            type=timeout,
            en="how long to wait for the first byte of a response (0.5)",
            ru="сколько ждать первого байта ответа, секунд (0.5)",
        ),
        CommonOption(
            ["--inter-byte"],
            type=timeout,
            en="longest pause inside a response (0.2); longer for a slow network or a busy "
            "computer: --inter-byte 0.5",
            ru="наибольшая пауза внутри ответа, секунд (0.2); для медленной сети или занятого "
            "компьютера больше: --inter-byte 0.5",
        ),
        CommonOption(
            ["--pause"],
            type=pause,
            en="least time from a response to the next request, for a unit that ignores one that "
            "comes sooner (auto: 0, or what this unit is found to need)",
            ru="наименьшая пауза между ответом и следующим запросом, секунд, для блока, который не "
            "слышит более ранний (auto: 0 или столько, сколько нужно этому блоку)",
        ),
        CommonOption(
            ["--retries"],
            type=whole(0, MAX_RETRIES),
            metavar="N",
            en="how often to repeat a failed request, if that is safe (2)",
            ru="сколько раз повторять неудачный запрос, если это безопасно (2)",
        ),
        CommonOption(
            ["--checksum"],
            words=CHECKSUMS,
            en="how a request's checksum of 0D or 40 is sent: stuffed as 40 CD, 40 00, or raw; "
            "responses are accepted in both forms (stuffed)",
            ru="как посылать контрольную сумму 0D или 40: stuffed — заменять на 40 CD, 40 00, "
            "raw — как есть; ответы принимаются в обоих видах (stuffed)",
        ),
        CommonOption(
            ["--strict/--no-strict"],
            default=None,
            en="treat a response with an escape other than 40 CD, 40 00 as damaged",
            ru="считать повреждённым ответ, где после 40 стоит не CD и не 00",
        ),
        CommonOption(
            ["--capture"],
            type=any_file,
            shell_complete=files("pcapng"),
            en="record everything on the line (.pcapng)",
            ru="записать весь обмен на линии (.pcapng)",
        ),
        CommonOption(
            ["--interpretation"],
            words=INTERPRETATIONS,
            en="how the doubtful places of the protocol's source are interpreted (corrected)",
            ru="как толковать сомнительные места описания протокола (corrected)",
        ),
        CommonOption(
            ["--catalog"],
            type=any_file,
            multiple=True,
            shell_complete=files("toml"),
            en="your own parameters and faults, added to the shipped ones",
            ru="свои параметры и ошибки в дополнение к встроенным",
        ),
        CommonOption(
            ["--lang"],
            words=LANGUAGES,
            en="language",
            ru="язык: en или ru",
        ),
        CommonOption(["--json"], is_flag=True, en="JSON on stdout", ru="вывод в виде JSON"),
        CommonOption(
            ["-v", "--verbose"],
            count=True,
            en="more details (on stderr); -vv: the log too, with every frame",
            ru="больше подробностей (в stderr); -vv — ещё и журнал с каждым кадром",
        ),
    ]
