"""Finding out how fast a method is, while whoever wants something else gets it: what comes are
samples, other threads' requests go in between two cycles, and `stop` is heard.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing

from mikas.client import Ecu
from mikas.errors import MikasError
from mikas.sampling.choosing import measure
from mikas.sampling.doubt import Doubt
from mikas.sampling.events import Event, Gap
from mikas.sampling.plan import Plan
from mikas.sampling.session import Session, Wish


class Measuring:
    """Measures methods and tells `session.learning`."""

    def __init__(self, session: Session, doubt: Doubt) -> None:
        self._session = session
        self._doubt = doubt

    def learn(self, ecu: Ecu, plan: Plan, wish: Wish) -> Iterator[Event]:
        """Learns how fast `plan` is, unless something else than `wish` is wanted meanwhile."""
        session, link = self._session, ecu.tester.link

        def aside(pause: Callable[[], None]) -> bool:
            if not session.jobs:
                return False
            pause()
            session.jobs.run(ecu)
            return True

        with closing(measure(ecu, plan, self._doubt, aside)) as found:
            while session.still(wish):
                try:
                    came = next(found)
                except StopIteration as end:
                    session.learning.learn(end.value, plan, link.baud)
                    return
                if isinstance(came, MikasError):
                    yield Gap(link.now(), came)
                elif came and session.in_time(sampled := session.sampled(came)):
                    yield sampled
