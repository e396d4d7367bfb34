"""Case after case: `python -m fuzz exchanges`. Exit status 1 on a finding, which is printed small.

python -m fuzz.exchanges.campaign --seed 2 --seconds 3600
python -m fuzz.exchanges.campaign --case 17      repeats this one; a finding prints the line
python -m fuzz.exchanges.campaign --case 17 --keep FILE     its file as well
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Final

from fuzz.campaigns import campaign_parser
from fuzz.exchanges import inventions, wireshark
from fuzz.exchanges.cases import Case, case
from fuzz.exchanges.readers import READERS, Disagreement, expected

_MOST_SMALL: Final = 3  # findings of one name that are made small


def main() -> int:
    """Run the campaign; return 1 on a finding."""
    given = _arguments()
    if given.case is not None:
        one = case(given.seed, given.case)
        if given.keep:
            given.keep.write_bytes(one.data)
        return _report(given.seed, one, Counter(), every=True)
    print(f"exchanges: seed {given.seed}", flush=True)
    found: Counter[str] = Counter()
    count, until, batch = 0, monotonic() + given.seconds, list[Case]()
    while count < given.cases and monotonic() < until:
        batch.append(case(given.seed, count))
        _report(given.seed, batch[-1], found)
        count += 1
        if len(batch) == wireshark.BATCH:
            _compare_tshark(given.seed, batch, found)
            batch = []
    _compare_tshark(given.seed, batch, found)
    total = sum(found.values()) or "nothing"
    print(f"exchanges: {total} found in {count} cases of seed {given.seed}")
    for name, times in found.most_common():
        print(f"  {times} × {name}")
    return 1 if found else 0


def _arguments() -> argparse.Namespace:
    parser = campaign_parser("exchanges", 60)
    parser.add_argument("--case", type=int, help="this one only, before every reader")
    parser.add_argument("--keep", type=Path, help="where its file is written")
    return parser.parse_args()


def findings(one: Case, *, every: bool = False) -> Iterator[Disagreement]:
    """Yield what is wrong with the readings of a case. `every`: by all readers."""
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        path = Path(folder) / "it.pcapng"
        path.write_bytes(one.data)
        wanted = expected(path)
        checks: list[Callable[[], None]] = [partial(inventions.check, one, wanted)]
        readers = [it for it in READERS if every or one.number % it.each == 0]
        checks += [partial(it.compare, path, wanted) for it in readers]
        for check in checks:
            try:
                check()
            except Disagreement as finding:
                yield finding


def _report(seed: int, one: Case, found: Counter[str], *, every: bool = False) -> int:
    """Print what is wrong with a case; count it. Return 1 if there is anything."""
    status = 0
    for finding in findings(one, every=every):
        status, name = 1, finding.name
        found[name] += 1
        if found[name] <= _MOST_SMALL:
            small = _small(one, name)
            print(f"FOUND {_named(small, name) or finding}\n{small.text()}")
            print(
                f"  {sys.executable} -m fuzz.exchanges.campaign --seed {seed} --case {one.number}"
            )
            sys.stdout.flush()
    return status


def _named(one: Case, name: str) -> Disagreement | None:
    return next((it for it in findings(one, every=True) if it.name == name), None)


def _small(one: Case, name: str) -> Case:
    """Return the case without the packets that the finding does not need.

    What is left out was not recorded either: where that alone is a finding, it has to stay.
    """
    kept = one
    for section in range(len(one.sections)):
        size = max(1, len(one.sections[section]) // 2)
        while size:
            at = 0
            while at < len(packets := kept.sections[section]):
                fewer = kept.without(section, set(packets[at : at + size]))
                if _named(fewer, name) and not _named(fewer.unchanged, name):
                    kept = fewer
                else:
                    at += size
            size //= 2
    return kept


def _compare_tshark(seed: int, batch: list[Case], found: Counter[str]) -> None:
    if not batch or not wireshark.is_there():
        return
    try:
        wireshark.compare(batch)
    except Disagreement as finding:
        found[finding.name] += 1
        if found[finding.name] <= _MOST_SMALL:
            print(f"FOUND {finding} (seed {seed})", flush=True)


if __name__ == "__main__":
    sys.exit(main())
