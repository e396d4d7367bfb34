"""What a person does to write a parameter, and to put it back."""

from __future__ import annotations

from .on_live import CLOSE
from .steps import CLOSED, SHEET, Shot, gone, press, row, says, shows

WRITING = (
    row(
        "live",
        "a parameter is written, and put back",
        press("live/tiles/Opener button", css='[data-opens="RCOD"]'),
        press("channelCard/ChannelCard write"),
        press("writing/Lock unlock"),
        press("writing/Lock unlock_yes"),
        press("writing/WriteParameter less"),
        press("writing/WriteParameter more"),
        press("writing/WriteParameter review"),
        shows(f"{SHEET} [data-after]", "[0-9]"),
        Shot("proposed"),
        press("writing/WriteParameter no"),
        press("writing/WriteParameter review"),
        press("writing/WriteParameter confirm"),
        says("Written and read back"),
        press("faults/Journal journal"),
        press("writing/WriteParameter back"),
        gone(f"{SHEET} button:has-text('Back to')"),
        press("writing/Lock lock"),
        says("Writing is locked"),
        press("writing/WriteParameter close"),
        CLOSE,
        CLOSED,
    ),
)
