"""Examples are written for a cable; here they are run on the virtual unit, on simulated time."""

from __future__ import annotations

import re

PORT = "sim:?clock=simulated"
_REAL = re.compile(r"/dev/tty\w+|\bCOM\d+|\b(?:socket|rfc2217)://[\w.:]+")
_SIM = re.compile(r"\bsim:(?!\?[^\s'\"]*clock=)(\?)?")


def on_virtual_unit(text: str) -> str:
    """Return `text` with other ports: simulated time in place of real time, no cable."""
    return _SIM.sub(lambda match: f"{PORT}&" if match[1] else PORT, _REAL.sub("sim:", text))


def as_written(output: str) -> str:
    """Return what was printed with the ports of the example."""
    return output.replace(f"{PORT}&", "sim:?").replace(PORT, "sim:")
