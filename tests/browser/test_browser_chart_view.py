"""Chart: what can be seen of each line, and where the window is."""

from __future__ import annotations

from playwright.sync_api import expect

HEIGHT_OF = """name => {
  const row = document.querySelector(`[data-trace="${name}"]`)?.closest("button");
  const canvas = row?.closest(".pane").querySelector("canvas");
  if (!canvas) return null;
  const colour = getComputedStyle(row.querySelector(".line")).backgroundColor;
  const [red, green, blue] = colour.match(/\\d+/g).map(Number);
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const left = 70;
  const width = canvas.width - 140;
  const { data } = context.getImageData(left, 0, width, canvas.height);
  let best = null;
  let most = 20;
  for (let row = 0; row < canvas.height; row += 1) {
    let found = 0;
    for (let at = row * width * 4; at < (row + 1) * width * 4; at += 4) {
      found += data[at] === red && data[at + 1] === green && data[at + 2] === blue;
    }
    if (found > most) [best, most] = [row, found];
  }
  return best && { row: best, height: canvas.height };
}"""
"""The row of pixels that has most of the trace's colour; null while it has none."""


def height_of(tab, name):
    found = tab.until(HEIGHT_OF, name)
    return found["row"], found["height"]


def test_two_constant_traces_are_both_seen(own, visitor):
    """Coolant in alarm and voltage, and a standing engine with its throttle closed."""
    own.garage.set("TWAT", "9D")
    own.garage.set("FREQ", "00")
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("117")
    expect(tab.traced("FREQ")).to_have_text("0")
    began = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > began + 20)
    for one, other in (("TWAT", "UACC"), ("FREQ", "THR")):
        (above, height), (below, _) = height_of(tab, one), height_of(tab, other)
        assert abs(above - below) > 0.04 * height
        assert 0 < min(above, below) < max(above, below) < height - 2
