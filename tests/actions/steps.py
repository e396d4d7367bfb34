"""What rows of the tables consist of: a press, a word typed, and what is there afterwards."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass

from playwright.sync_api import Error, Locator, expect

from browser.rig import UNTIL, Tab

from .controls import controls
from .routes import Home

Step = Callable[[Tab], object]
PROBLEMS = "#screen .notice.signal-danger, dialog .notice.signal-danger, .toasts .signal-warning"
"""What the page shows of an error."""
BODY = "body"
MOST = 20
"""Times that a step is repeated."""


def front(tab: Tab) -> Locator:
    """Return the sheet in front, or the page."""
    sheets = tab.find("dialog[open]")
    return sheets.last if sheets.count() else tab.find(BODY)


@dataclass(frozen=True)
class Press:
    """Press a control of the sources: `live/Screen edit`.

    `name`: its name, where the data give it; `css`: where it has no name of its own; `within`: in
    which part of the page, else in the sheet in front.
    """

    control: str
    name: str = ""
    within: str = ""
    css: str = ""

    def __call__(self, tab: Tab) -> None:
        self.found(tab).click()

    def found(self, tab: Tab) -> Locator:
        if self.css:
            return tab.find(f"{self.css} >> visible=true").first
        place = tab.find(self.within).first if self.within else front(tab)
        control = controls()[self.control]
        name = re.compile(self.name) if self.name else control.name
        assert name, f"{self.control}: the data name it, so the row has to"
        if control.role == "":
            return place.locator("summary").filter(has_text=re.compile(name.pattern.rstrip("$")))
        found = place.get_by_role(control.role, name=name)
        return found.locator("visible=true").first


@dataclass(frozen=True)
class Saves(Press):
    """Press it, and a file is saved that is not empty."""

    def __call__(self, tab: Tab) -> None:
        with tab.page.expect_download() as saved:
            super().__call__(tab)
        assert saved.value.path().stat().st_size > 0


@dataclass(frozen=True)
class Shot:
    """The page shows no error, and is photographed under this name."""

    name: str

    def __call__(self, tab: Tab) -> None:
        expect(tab.find("#screen [aria-busy=true]")).to_have_count(0)
        expect(tab.find(PROBLEMS)).to_have_count(0)


def press(control: str, name: str = "", within: str = "", css: str = "") -> Press:
    return Press(control, name, within, css)


def saves(control: str, name: str = "", within: str = "") -> Saves:
    return Saves(control, name, within)


def key(name: str) -> Step:
    return lambda tab: tab.page.keyboard.press(name)


def fill(label: str, text: str, *, exact: bool = False) -> Step:
    return lambda tab: front(tab).get_by_label(label, exact=exact).first.fill(text)


def choose(label: str, option: str) -> Step:
    return lambda tab: front(tab).get_by_label(label).first.select_option(label=option)


def tick(label: str) -> Step:
    return lambda tab: front(tab).get_by_label(label).first.click()


def shows(css: str, text: str = "") -> Step:
    """Wait for it, and for the text in it."""

    def wait(tab: Tab) -> None:
        expect(tab.find(css).first).to_be_visible()
        if text:
            expect(tab.find(css).first).to_contain_text(re.compile(text))

    return wait


def gone(css: str) -> Step:
    return lambda tab: expect(tab.find(css)).to_have_count(0)


def on_screen(name: str) -> Step:
    """Wait for what leads to a screen."""
    return lambda tab: expect(tab.find(f'nav a[data-screen="{name}"]')).to_have_attribute(
        "aria-current", "page"
    )


def says(text: str) -> Step:
    return lambda tab: expect(front(tab).get_by_text(re.compile(text)).first).to_be_visible()


def go(screen: str) -> Step:
    return lambda tab: tab.show(screen)


@dataclass(frozen=True)
class Repeats(Press):
    """Press it again and again until `until` is there."""

    until: str = ""

    def __call__(self, tab: Tab) -> None:
        ready = self.found(tab).and_(tab.find(":enabled"))
        for _ in range(MOST):
            expect(tab.find(self.until).or_(ready).first).to_be_visible()
            if tab.find(self.until).count():
                return
            with suppress(Error):  # it may be gone just now, as what it leads to comes
                ready.click(timeout=1000)
        raise AssertionError(f"after {MOST} times there is no {self.until}")


def phone(tab: Tab) -> None:
    tab.page.set_viewport_size({"width": 390, "height": 844})


def laptop(tab: Tab) -> None:
    tab.page.set_viewport_size({"width": 1280, "height": 800})


SHEET = "dialog[open]"
CLOSED = gone(SHEET)
ESCAPE = key("Escape")


@dataclass(frozen=True)
class Row:
    """What a person does on a screen, and sees. It leaves the screen as it was."""

    screen: str
    name: str
    steps: tuple[Step, ...]
    homes: tuple[Home, ...] = ("desktop", "site")

    def pressed(self) -> Iterator[str]:
        return (step.control for step in self.steps if isinstance(step, Press))


def _nothing(_: Row, __: Shot) -> None:
    """Look on."""


def row(screen: str, name: str, *steps: Step, **more) -> Row:
    return Row(screen, name, steps, **more)


def do(
    tab: Tab, rows: Iterable[Row], home: Home, look: Callable[[Row, Shot], object] = _nothing
) -> list[str]:
    """Do what each row says; return a line for each that could not be done.

    `look`: what is done with what the page shows then.
    """
    found = []
    for each in rows:
        if home not in each.homes:
            continue
        done = 0
        try:
            tab.show(each.screen)
            for step in each.steps:
                step(tab)
                if isinstance(step, Shot):
                    look(each, step)
                done += 1
        except (AssertionError, Error) as error:
            found.append(f"{each.screen}: {each.name}, step {done + 1}: {str(error)[:1500]}")
            begin_again(tab)
            if home == "site":  # the program has ended with its page
                return [*found, "the rows after it were not done"]
    return found


def begin_again(tab: Tab) -> None:
    """Reload the page: what a row left open is closed."""
    laptop(tab)
    tab.page.once("dialog", lambda dialog: dialog.accept())  # amid a recording it asks first
    tab.page.reload()
    expect(tab.find("header[data-line]")).to_be_visible(timeout=UNTIL)
