"""`--actions FILE.toml` of `watch` and `log`: the actions when a condition holds.

Nothing heavy is imported here: the port is opened first.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mikas.cli.click_extensions import grouped, optional_field
from mikas.cli.options.parameter_types import any_file


@dataclass(frozen=True, slots=True)
class ActionOptions:
    """The option; None: not given."""

    actions: Path | None = optional_field(
        "--actions",
        parse=any_file,
        metavar="FILE.toml",
        en="do what this file says when a condition holds: mark, stop the recording, ring, MQTT, "
        "webhook",
        ru="делать то, что сказано в файле, когда выполнится условие: отметка, конец записи, "
        "звонок, MQTT, вебхук",
    )


action_options: Final = grouped(ActionOptions)
"""The option of `watch` and `log`."""
