"""Actions on conditions of the running connection: followed in the sampling thread, done at once.

The rules are those of `actions.toml` in the state folder, which a person may edit, too: a file with
a mistake is not used, and `problem` has file and line. A rule on a channel that does not exist
rests until an instrument gives it; the others act. Sounds and words go to the pages as events
(`ActionDone`); what takes time or the line, a recording's begin and end, to the event loop.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mikas.catalog import Catalog
from mikas.conditions import (
    ActionRule,
    ConditionWatch,
    Fired,
    LoadedActions,
    actions_toml,
    load_actions,
)
from mikas.conditions.performing import ActionRunner, Hands
from mikas.dashboard.errors import ADVICE
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.history import ActionDone
from mikas.dashboard.session.recorder import SessionRecorder
from mikas.errors import CatalogError, MikasError, naming_file
from mikas.files import ABSENT
from mikas.i18n import Language, Text
from mikas.sampling.events import Event
from mikas.saving import save


@dataclass(eq=False)
class SessionActions:
    """The rules in use. `_catalog` returns the catalog in use; `network`: as of `Hands`.

    `_language`: of the markers; None: English.
    """

    path: Path
    network: bool
    _connection: Connection
    _recorder: SessionRecorder
    _catalog: Callable[[], Catalog]
    _language: Language | None

    def __post_init__(self) -> None:
        self.problem: Text | None = None
        """Why the file is not used; None: it is, or there is none."""
        self.loaded: LoadedActions = LoadedActions()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._recording = asyncio.Lock()  # a begin and an end of the same instant: one by one
        self._saving = threading.Lock()
        self._following = threading.Lock()  # a trial looks at the values, too
        self._watch: ConditionWatch | None = None
        self._runner: ActionRunner | None = None

    def start(self) -> None:
        """Take requests of the event loop that runs."""
        self._loop = asyncio.get_running_loop()

    def load(self) -> None:
        """Use the file; called at the start, and when the catalog has changed."""
        before = self._watch
        try:
            self._use(load_actions(self.path, self._catalog(), lambda _: True), before)
            self.problem = None
        except CatalogError as error:
            absent = isinstance(error.__cause__, ABSENT)
            self.problem = None if absent else error.text
            self._use(LoadedActions())
        except MikasError as error:  # a webhook elsewhere, no library for MQTT
            self.problem = error.text
            self._use(LoadedActions())

    def instruments_changed(self) -> None:
        """Use the file if it names an instrument that is only now there.

        Rules of an instrument that is gone stay: they have no value until it is back.
        """
        if self.problem is not None or self.loaded.resting:
            self.load()

    def may_rest(self, channel: str) -> bool:
        """Return whether a rule in use names that channel: it may, while its instrument is away."""
        return any(channel in rule.channels for rule in self.loaded.rules)

    def replace(self, actions: LoadedActions) -> None:
        """Use these rules, and keep them. Raises `UsageError`; then those before stay.

        A file with a mistake, whose rules are not in use, is kept as `actions.toml.broken`.
        """
        with self._saving:
            watch, runner = self._made(actions)
            try:
                self._keep(actions)
            except BaseException:
                runner.close()
                raise
            self._change(actions, watch, runner)
            self.problem = None

    def _keep(self, actions: LoadedActions) -> None:
        with naming_file(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if self.problem is not None and self.path.exists():
                self.path.replace(self.path.with_name(f"{self.path.name}.broken"))
            save(self.path, actions_toml(actions))

    def close(self) -> None:
        """End the connections to a broker and to webhooks; may take seconds."""
        self._use(LoadedActions())

    def _use(self, actions: LoadedActions, acted: ConditionWatch | None = None) -> None:
        """Use these rules; those of `acted` don't act once more."""
        watch, runner = self._made(actions)
        self._change(actions, watch, runner, acted)

    def _made(self, actions: LoadedActions) -> tuple[ConditionWatch | None, ActionRunner]:
        catalog = self._catalog()
        watch = ConditionWatch(actions.acting, catalog) if actions.acting else None
        return watch, ActionRunner(actions, catalog, self.hands, self._failed, self._later)

    def _change(
        self,
        actions: LoadedActions,
        watch: ConditionWatch | None,
        runner: ActionRunner,
        acted: ConditionWatch | None = None,
    ) -> None:
        with self._following:  # a rule is done by the runner that has its address
            if watch is not None and acted is not None:
                watch.take_over(acted)
            before, self._runner = self._runner, runner
            self._watch, self.loaded = watch, actions
        if before is not None:
            before.close()

    def _later(self) -> float:
        return self._connection.later

    @property
    def hands(self) -> Hands:
        """What this program can do; sound and words are done by its pages."""
        return Hands(
            mark=self._mark,
            start=partial(self._soon, self._start),
            stop=partial(self._soon, self._stop),
            sound=lambda: None,
            speak=lambda _: None,
            network=self.network,
        )

    def add_event(self, event: Event) -> None:
        """Follow an event of the session; in the sampling thread."""
        with self._following:
            runner = self._runner
            if self._watch is None or runner is None:
                return
            acting = self._watch.follow(event)
        for fired in acting:
            self._perform(fired, runner)

    def perform(self, rule: ActionRule) -> None:
        """Do what a rule in use says, now, as a trial: but for the recording."""
        now = self._connection.now()
        with self._following:
            runner = self._runner
            values = self._watch.values(rule) if self._watch else {}
            is_used = rule in self.loaded.rules
        if runner is not None and is_used:
            self._perform(Fired(rule, now, now, values), runner, trial=True)

    def _perform(self, fired: Fired, runner: ActionRunner, *, trial: bool = False) -> None:
        rule = fired.rule
        spoken = runner.filled(rule.speak, fired) if rule.speak else None
        text = Text(f"Action {rule.name}: {rule.when}", f"Действие {rule.name}: {rule.when}")
        self._log(ActionDone(fired.time, rule.name, text, sound=rule.sound, speak=spoken))
        runner.perform(fired, recording=not trial)

    def _mark(self, text: Text) -> None:
        self._recorder.marker(text.to(self._language or "en"))

    async def _start(self) -> None:
        async with self._recording:
            if self._recorder.file_name is None:
                await self._recorder.start(None)

    async def _stop(self) -> None:
        async with self._recording:
            if self._recorder.file_name is not None:
                await self._recorder.read_last()
                self._recorder.stop()

    def _soon(self, work: Callable[[], object]) -> None:
        if (loop := self._loop) is not None:
            loop.call_soon_threadsafe(self._begin, work)

    def _begin(self, work: Callable[[], object]) -> None:
        async def done() -> None:
            try:
                result = work()
                if asyncio.iscoroutine(result):
                    await result
            except MikasError as error:
                self._failed(ADVICE.text(error))

        task = asyncio.create_task(done())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _failed(self, failure: Text) -> None:
        self._log(ActionDone(self._connection.now(), "", failure, failed=True))

    def _log(self, event: ActionDone) -> None:
        self._connection.monitor.log(event)
