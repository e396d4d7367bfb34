"""Case after case by a seed: `python -m fuzz clients`.

A case is one manner, or a crowd of clients that do anything, with TLS or without, with the token or
without. The clients of case N of seed S do the same everywhere; how it meets the server's turns
differs from run to run.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import traceback
import warnings
from pathlib import Path
from random import Random
from time import monotonic
from typing import Final

from fuzz.campaigns import campaign_parser
from fuzz.clients.manners import MANNERS, Crowd, Network, network_of, run
from fuzz.clients.world import Finding, clients_context, world

_STEPS: Final = 80  # of a crowd
_CROWDS: Final = 0.6  # of the cases
_OF_A_WORLD: Final = 20  # cases
_MEBIBYTES: Final = 1024  # of this process: the server, and its clients


def main() -> int:
    """Run the campaign; return 1 on a finding."""
    given = _arguments()
    warnings.simplefilter("error", ResourceWarning)
    print(f"clients: seed {given.seed}", flush=True)
    campaign = Campaign(given.seed, monotonic() + given.seconds)
    at, last = given.first, given.first + given.cases
    while at < last and not campaign.is_over:
        at = campaign.visit_a_world(range(at, min(at + _OF_A_WORLD, last)))
    found = campaign.found or "nothing"
    print(f"clients: {found} found in {at - given.first} cases of seed {given.seed}")
    return 1 if campaign.found else 0


def _arguments() -> argparse.Namespace:
    parser = campaign_parser("clients", 45)
    parser.add_argument("--first", type=int, default=0, help="the number of the first case")
    return parser.parse_args()


class Campaign:
    """What has been found until `until`."""

    def __init__(self, seed: int, until: float) -> None:
        self.found = 0
        self._seed, self._until, self._context = seed, until, clients_context()

    @property
    def is_over(self) -> bool:
        return monotonic() >= self._until

    def visit_a_world(self, numbers: range) -> int:
        """Run cases until the first finding; return the number of the next case."""
        at = numbers.start
        tls = Random(f"{self._seed}:{at // _OF_A_WORLD}").random() < 0.7
        done: list[str] = []
        try:
            with (
                tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder,
                world(Path(folder), tls=tls) as it,
            ):
                for at in numbers:
                    if self.is_over:
                        return at
                    random = Random(f"{self._seed}:{at}")
                    token = random.random() < 0.5
                    _visit(network_of(it, self._context, random, token=token), done)
        except Exception:  # any: that is the finding
            self.found += 1
            print(f"FOUND in case {at} of seed {self._seed}: {', '.join(done)}")
            print(traceback.format_exc(limit=-4))
            repeat = f"--seed {self._seed} --first {at} --cases 1"
            print(f"  {sys.executable} -m fuzz.clients.campaign {repeat}", flush=True)
        return at + 1


def _visit(network: Network, done: list[str]) -> None:
    done[:] = ["TLS" if network.context else "plain", "token" if network.token else "no token"]
    if network.random.random() < _CROWDS:
        crowd = Crowd(network, done)
        run(network, lambda _: crowd.visit(_STEPS))
    else:
        name = network.random.choice(tuple(MANNERS))
        done.append(name)
        run(network, MANNERS[name])
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    if used > _MEBIBYTES:
        raise Finding(f"{used} MiB of memory")


if __name__ == "__main__":
    sys.exit(main())
