"""The secrets in what a run was given: command line, environment, config file.

An address may have a user's password or a signature in it. The words of a failure are foreign
code's, too, those of a bug any code's: they pass through `hider_of`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache

from mikas.cleaning import SECRET_VARIABLES, secrets_of, without
from mikas.errors import UsageError
from mikas.preferences import config_path, parsed_config


def hider_of(argv: Sequence[str]) -> Callable[[str], str]:
    """Return what leaves these secrets out of a text."""

    @cache
    def secrets() -> frozenset[bytes]:  # most runs say nothing for which they are looked up
        places, ports = _addresses(argv)
        found = [secrets_of(*(os.environ.get(name, "") for name in SECRET_VARIABLES))]
        found += [secrets_of(place=place, port=place) for place in places]
        return frozenset().union(*found, *(secrets_of(port=port) for port in ports))

    return lambda text: without(text, secrets())


def _addresses(argv: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the words that may be places, and those that are ports."""
    places: list[str] = []
    ports = [os.environ.get("MIKAS_PORT", "")]
    with suppress(UsageError, RuntimeError):  # reported by who reads the whole file
        ports.append(str(parsed_config(config_path()).get("port", "")))
    option = ""
    for word in argv:
        if (joined := re.match("(--[^=]+)=", word)) is not None:
            option = joined[1]
        (ports if option == "--port" else places).append(word[joined.end() if joined else 0 :])
        option = word
    return places, ports
