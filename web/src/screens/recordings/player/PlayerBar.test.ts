import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import { channelOf, eachOnItsOwnPage, page } from "../../../../test/pageRig";
import PlayerBar from "./PlayerBar.svelte";

eachOnItsOwnPage();
const button = (name: string) => screen.getByRole("button", { name });
const place = () => screen.getByRole("slider").getAttribute("aria-valuetext");

/** Two recordings of ten seconds, a value each second; the first one is shown. */
async function playing(screenName: "live" | "chart" = "chart") {
  const times = Array.from({ length: 11 }, (_, second) => 100 + second);
  const detail = (id: string) => ({
    id,
    first: 100,
    last: 110,
    samples: 11,
    rate: 1,
    events: [],
    channels: ["TWAT"],
    date: null,
    model: null,
  });
  const shown = page({
    "/recordings/a.pcapng/rows": { names: ["TWAT"], times, values: [times], decimated: false },
    "/recordings/b.pcapng/rows": { names: ["TWAT"], times, values: [times], decimated: false },
    "/recordings/a.pcapng": detail("a.pcapng"),
    "/recordings/b.pcapng": detail("b.pcapng"),
  });
  shown.say();
  shown.stores.catalog.use({ version: "1", parameters: [channelOf("TWAT")], derived: [] } as never);
  shown.stores.route.go(screenName);
  await vi.waitFor(() => expect(shown.stores.route.screen).toBe(screenName));
  await shown.stores.player.open("a.pcapng");
  shown.show(PlayerBar, {});
  return shown.stores;
}

it("it is there while a recording is shown, and closes it", async () => {
  const { display } = await playing();
  expect(display.source.kind).toBe("recording");
  await fireEvent.click(button("Close the recording"));
  expect(display.source.kind).toBe("live");
  expect(screen.queryByRole("slider")).toBeNull();
});

it("it steps by samples, and the keys of the rail move the place", async () => {
  const { player } = await playing();
  await fireEvent.click(button("One sample forward"));
  expect(player.position).toBe(101);
  await fireEvent.keyDown(screen.getByRole("slider"), { key: "End" });
  expect(player.position).toBe(110);
  expect(place()).toMatch(/10.* of .*10/);
  await fireEvent.click(button("One sample back"));
  expect(player.position).toBe(109);
});

it("one button plays and pauses", async () => {
  const { player } = await playing();
  await fireEvent.click(button("Play"));
  expect(player.playing).toBe(true);
  await fireEvent.click(button("Pause"));
  expect(player.playing).toBe(false);
});

it("a loop has a beginning, then an end; then it can be removed", async () => {
  const { player } = await playing();
  player.seek(103);
  await fireEvent.click(button("Loop from here"));
  expect(player.loop).toBeNull();
  player.seek(106);
  await fireEvent.click(button("Loop to here"));
  expect(player.loop).toEqual({ from: 103, to: 106 });
  await fireEvent.click(button("End the loop"));
  expect(player.loop).toBeNull();
});

it("a loop has its marks in either order, and none between one moment and itself", async () => {
  const { player } = await playing();
  player.seek(107);
  await fireEvent.click(button("Loop from here"));
  player.seek(103);
  await fireEvent.click(button("Loop to here"));
  expect(player.loop).toEqual({ from: 103, to: 107 });
  await fireEvent.click(button("End the loop"));
  await fireEvent.click(button("Loop from here"));
  await fireEvent.click(button("Loop to here"));
  expect(player.loop).toBeNull();
  expect(button("Loop from here")).toBeTruthy();
});

it("two cursors are the loop", async () => {
  const { cursors, player } = await playing();
  cursors.a = 107;
  cursors.b = 102;
  await Promise.resolve();
  await fireEvent.click(button("Loop between the cursors"));
  expect(player.loop).toEqual({ from: 102, to: 107 });
});

it("the second recording is moved in steps, and back to the start of both", async () => {
  const { comparison } = await playing();
  await comparison.start("b.pcapng", 100);
  await fireEvent.click(button("Second one 1 s to the left"));
  await fireEvent.click(button("Second one 0.1 s to the right"));
  expect(comparison.offset).toBe(-0.9);
  await fireEvent.click(screen.getByRole("button", { name: /moved by −0.9 s/ }));
  expect(comparison.offset).toBe(0);
  await fireEvent.click(button("End the comparison"));
  expect(comparison.active).toBe(false);
});

it("aligning takes the moment on the dashed line first", async () => {
  const { comparison } = await playing();
  await comparison.start("b.pcapng", 100);
  await Promise.resolve();
  await fireEvent.click(button("Align…"));
  comparison.alignAt(104);
  comparison.alignAt(106);
  expect(comparison.offset).toBe(2);
});

it("outside of the chart the comparison is a link to it", async () => {
  const { comparison } = await playing("live");
  await comparison.start("b.pcapng", 100);
  await Promise.resolve();
  expect(screen.getByRole("link", { name: "The comparison is in the chart" }).getAttribute("href")).toBe("#/chart");
  expect(screen.queryByRole("button", { name: "Align…" })).toBeNull();
});
