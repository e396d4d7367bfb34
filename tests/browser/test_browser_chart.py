"""Chart: it moves with the data; a frozen view does not stop what is recorded."""

from __future__ import annotations

from playwright.sync_api import expect

PAINTED = "document.querySelector('.panes canvas')?.toDataURL()"
"""Nothing until the plot is made: that is after the legend, when the pane knows how large it is."""
DRAWN = """() => {
  const line = document.querySelector(".panes .line");
  const canvas = document.querySelector(".panes canvas");
  if (!line || !canvas) return false;
  const [red, green, blue] = getComputedStyle(line).backgroundColor.match(/\\d+/g).map(Number);
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(70, 0, canvas.width - 70, canvas.height);
  let found = 0;
  for (let at = 0; at < data.length; at += 4) {
    found += data[at] === red && data[at + 1] === green && data[at + 2] === blue;
  }
  return found > 5;
}"""
"""Whether the first trace's line is in its pane: its colour, right of its own axis."""
ALL = """() => {
  const spans = [...document.querySelectorAll(".spans button")];
  spans.at(-1).click();
  return spans.at(-1).ariaPressed === "true";
}"""
"""Everything that the page holds is shown; false as long as that is nothing."""
TRACE = "[{id: 0, traces: [{name: 'TWAT', colour: 1, hidden: false}]}]"


def test_new_values_are_drawn(dash, visitor):
    tab = visitor(dash.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    before = tab.until(f"() => {PAINTED}")
    assert tab.until(f"before => {PAINTED} !== before", before)
    dash.garage.set("TWAT", "80")
    expect(tab.traced("TWAT")).to_have_text("88")
    dash.garage.set("TWAT", "7F")
    expect(tab.traced("TWAT")).to_have_text("87")


def test_a_frozen_view_stands_and_the_recording_goes_on(own, visitor):
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("r")
    tab.is_line("recording")
    tab.page.keyboard.press("Space")
    tab.says("View frozen")
    own.garage.set("TWAT", "80")
    began = own.state()["recording"]["samples"]
    own.until(lambda: own.state()["recording"]["samples"] > began + 5)
    expect(tab.traced("TWAT")).to_have_text("87")
    assert _comes_to_rest(own, tab)
    tab.page.keyboard.press("Space")
    expect(tab.traced("TWAT")).to_have_text("88")


def _comes_to_rest(dash, tab):
    """Whether its picture is the same twice, some samples apart. The last drawing may come late."""
    before = None
    for _ in range(10):
        began = dash.state()["samples"]
        dash.until(lambda than=began + 10: dash.state()["samples"] > than)
        before, picture = picture_of(tab), before
        if picture == before:
            return True
    return False


def picture_of(tab):
    return tab.until(f"() => {PAINTED}")


def test_a_marker_is_a_flag_over_the_panes(own, visitor):
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("m")
    expect(tab.find(".flags button.marker")).to_have_count(1)


def test_the_legend_shows_the_values_at_the_cursor(own, visitor):
    """The cursor is put where 8 ms were marked, and a sample to either side."""
    tab = visitor(own.url).show("chart")
    own.garage.set("INJ", "E8 03")
    expect(tab.traced("INJ")).to_have_text("8.00")
    tab.page.keyboard.press("m")
    expect(tab.find(".flags button.marker")).to_have_count(1)
    tab.page.keyboard.press("Escape")  # no name
    marked = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > marked + 5)
    own.garage.set("INJ", "F4 01")
    expect(tab.traced("INJ")).to_have_text("4.00")
    tab.page.keyboard.press("Space")
    tab.says("View frozen")
    assert tab.until(ALL)
    tab.find(".flags button.marker").press("Enter")
    for key in ("ArrowRight", "ArrowLeft"):
        tab.page.keyboard.press(key)
        expect(tab.traced("INJ")).to_have_text("8.00")
    tab.page.keyboard.press("Escape")
    expect(tab.traced("INJ")).to_have_text("4.00")


def test_values_received_before_the_plot_was_made_are_drawn_with_it(own, visitor):
    """The catalog, without which there is no plot, comes late, to a view that was frozen."""
    tab = visitor(own.url).show("live")
    expect(tab.value("TWAT")).to_have_text("87")
    tab.page.evaluate(
        "localStorage.setItem('mikas.chart', JSON.stringify(ASKED))".replace("ASKED", TRACE)
    )
    began = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > began + 30)
    late = []

    def hold(route):
        late.append(route)

    tab.page.route("**/api/catalog", hold)
    tab.page.reload()
    tab.show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    assert tab.until(ALL)  # the page has them: of the program's memory, none is left out there
    tab.page.keyboard.press("Space")
    tab.says("View frozen")
    expect(tab.find(".panes canvas")).to_have_count(0)
    for answer in late:
        answer.continue_()
    assert tab.until(DRAWN)


def test_the_past_that_comes_to_a_frozen_view_is_drawn(own, visitor):
    tab = visitor(own.url).show("live")
    expect(tab.value("TWAT")).to_have_text("87")
    began = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > began + 30)
    late, holding = [], True

    def hold(route):
        if holding:
            late.append(route)
        else:
            route.continue_()  # a second question follows the first

    tab.page.route("**/api/history**", hold)
    tab.page.reload()
    tab.show("chart")
    expect(tab.find(".panes canvas")).to_have_count(4)
    tab.page.keyboard.press("Space")
    tab.says("View frozen")
    assert not tab.page.evaluate(DRAWN)
    holding = False
    for answer in late:
        answer.continue_()
    assert tab.until(DRAWN)


def test_a_frozen_view_is_drawn_again_when_one_comes_back_to_it(dash, visitor):
    tab = visitor(dash.url).show("chart")
    assert tab.until(DRAWN)
    tab.page.keyboard.press("Space")
    tab.says("View frozen")
    tab.show("passport").show("chart")
    assert tab.until(DRAWN)
    assert _comes_to_rest(dash, tab)
    before = picture_of(tab)
    tab.page.keyboard.press("s")
    assert tab.until(f"before => {PAINTED} !== before", before)
    assert tab.until(DRAWN)


def _stand(tab, *panes):
    """Waits until that stands in the panes; None: whatever there is."""
    tab.until(
        """asked => {
          const panes = [...document.querySelectorAll(".panes .legend")];
          const names = panes.map((it) => [...it.querySelectorAll("[data-trace]")]
            .map(({ dataset }) => dataset.trace).join());
          return names.length === asked.length
            && names.every((it, at) => asked[at] === null || asked[at] === it);
        }""",
        list(panes),
    )


def _carry(tab, name, to):
    """By the mouse, from its row in the legend."""
    mouse = tab.page.mouse
    begin = tab.find(f'button:has([data-trace="{name}"])').bounding_box()
    mouse.move(begin["x"] + 60, begin["y"] + 10)
    mouse.down()
    mouse.move(begin["x"] + 80, begin["y"] + 20)
    end = to().bounding_box()
    mouse.move(end["x"] + end["width"] / 2, end["y"] + end["height"] / 2)
    mouse.up()


def test_a_trace_is_carried_to_another_pane(dash, visitor):
    tab = visitor(dash.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    _stand(tab, "FREQ,THR", "INJ,JAIR", "UOZ", "TWAT,UACC")
    _carry(tab, "TWAT", lambda: tab.find(".panes .plot").first)
    _stand(tab, "FREQ,THR,TWAT", "INJ,JAIR", "UOZ", "UACC")
    pressed = tab.find('button:has([data-trace="TWAT"])')
    expect(pressed).to_have_attribute("aria-pressed", "true")
    _carry(tab, "TWAT", lambda: tab.page.get_by_text("New pane"))
    _stand(tab, "FREQ,THR", "INJ,JAIR", "UOZ", "UACC", "TWAT")
    _carry(tab, "TWAT", lambda: tab.find(".spans"))
    expect(tab.find(".ghost")).to_have_count(0)  # it was let go of
    _stand(tab, "FREQ,THR", "INJ,JAIR", "UOZ", "UACC", "TWAT")
    expect(pressed).to_have_attribute("aria-pressed", "true")
    pressed.press("Shift+ArrowUp")
    _stand(tab, "FREQ,THR", "INJ,JAIR", "UOZ", "UACC,TWAT")
    pressed.click()
    expect(pressed).to_have_attribute("aria-pressed", "false")
