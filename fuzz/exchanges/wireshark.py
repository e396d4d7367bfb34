"""tshark with the dissector against `decode`: the cases as sections of one file, for starting
tshark takes longer than reading.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from fuzz.exchanges.cases import Case
from fuzz.exchanges.readers import Disagreement, harness
from fuzz.exchanges.sessions import CATALOG
from mikas.dissectors.wireshark.generator import source

BATCH: Final = 64  # cases a file
_FIELDS: Final = ("time", "direction", "echo", "body", "data", "request", "meaning")


def is_there() -> bool:
    """Return whether tshark is installed."""
    return shutil.which("tshark") is not None


def compare(every: Sequence[Case]) -> None:
    """Raise `Disagreement` with the first case that tshark shows otherwise than `decode`.

    Wireshark ends a file at a damaged block, so cases with a missing part are left out.
    """
    cases = [it for it in every if not any(p.missing for each in it.sections for p in each)]
    tshark = harness("", "dissectors.tshark_harness")
    oracle = harness("", "dissectors.oracle_harness")
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        script, path = Path(folder) / "mikas.lua", Path(folder) / "it.pcapng"
        script.write_text(source(CATALOG, "en", "corrected", "0"), "utf-8")
        path.write_bytes(b"".join(case.data for case in cases))
        found = tshark.decoded(tshark.shown(path, script, check=False))
        wanted: list[dict[str, Any]] = []
        owners: list[int] = []
        for case in cases:  # together they would be recordings of several cars
            path.write_bytes(case.data)
            lines = list(map(oracle.line, oracle.without_ends(path, oracle.parts(path))))
            wanted += lines
            owners += [case.number] * len(lines)
    # Of two cars in a case, `decode` has the lines of one after those of the other.
    shown = sorted(map(_plain, found), key=repr)
    decoded = sorted(zip(map(_plain, wanted), owners, strict=True), key=repr)
    for one, (other, number) in zip(shown, decoded, strict=False):
        if one != other:
            raise Disagreement("tshark", f"case {number}\n  {one}\n  decode: {other}")
    if len(found) != len(wanted):
        raise Disagreement("tshark", f"{len(found)} frames, decode has {len(wanted)}")


def _plain(line: dict[str, Any]) -> dict[str, Any]:
    return {name: line.get(name) for name in _FIELDS}
