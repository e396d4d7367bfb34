import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import { channelOf, eachOnItsOwnPage, page, refused } from "../../../test/pageRig";
import WriteParameter from "./WriteParameter.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const value = (value: number, raw: string) => ({ value, unit: "°", raw });
const angle = channelOf("UOZOC", {
  ...{ decimals: 1, unit: words("°"), range: [-10, 20], range_kind: "plausible" },
  limits: { danger_low: null, warning_low: null, warning_high: null, danger_high: 30, hysteresis: 0 },
});
const NOW = { name: "UOZOC", now: value(10, "14"), time: 99, lowest: -40, highest: 87.5, step: 0.5, start: null, start_time: null };
const proposal = { nonce: "n", expires: 1e12, before: value(10, "14"), after: value(11, "16"), danger: false, meaning: words("10 → 11") };

/** The sheet over a unit that holds what `held` says; `confirmation`: what becomes of a confirmed write. */
function sheet({
  held = {},
  confirmation = {},
  unlocked = true,
  proposed = {} as unknown,
  journal = [] as object[],
  cut = { off: false },
  channel = angle,
} = {}) {
  const shown = page({
    "/parameters/UOZOC": () => (cut.off ? refused(502, "LinkLost") : { ...NOW, ...held }),
    "/changes/n": () => (confirmation instanceof Response ? confirmation.clone() : confirmation),
    "/changes": () => (proposed instanceof Response ? proposed.clone() : { ...proposal, ...(proposed as object) }),
    "/journal": { entries: journal },
  });
  shown.say({ unlocked_until: unlocked ? 1e12 : null });
  shown.show(WriteParameter, { channel, onclose: () => undefined });
  const changes = () => shown.asked.filter(({ method, path }) => method === "POST" && path.startsWith("/changes"));
  const reads = () => shown.asked.filter(({ path }) => path.startsWith("/parameters/")).length;
  return { ...shown, changes, reads };
}
const button = (name: string | RegExp) => screen.getByRole<HTMLButtonElement>("button", { name });
const field = () => screen.getByRole<HTMLInputElement>("textbox", { name: /New value/ });
const text = () => screen.getByRole("dialog").textContent.replace(/\s+/g, " ");
const ready = () => vi.waitFor(() => expect(field().value).toBe("10.0"));

it("a parameter without a unit has no comma or blank in its place", async () => {
  sheet({ channel: { ...angle, unit: words("") } });
  await vi.waitFor(() => expect(text()).toContain("−40.0 … 87.5, in steps of 0.5"));
  expect(field().closest("label")!.textContent.trim()).toBe("New value");
});

it("a parameter has its value now, its bytes, what can be written and what is dangerous", async () => {
  sheet();
  await ready();
  expect(text()).toContain("10.0 °");
  expect(text()).toContain("−40.0 … 87.5 °, in steps of 0.5");
  expect(text()).toContain("−10 … 20 °");
  expect(text()).toContain("above 30.0 °");
  expect(text()).toContain("not written in this session");
  expect(screen.queryByRole("button", { name: /^Back to/ })).toBeNull();
});

it("buttons step by the bytes; what does not fit can't be proposed", async () => {
  sheet();
  await ready();
  await fireEvent.click(button("0.5 more"));
  await fireEvent.click(button("5.0 more"));
  await fireEvent.click(button("0.5 less"));
  expect(field().value).toBe("15.0");
  for (const [typed, why] of [
    ["abc", "not a number"],
    ["88", "hold −40.0 … 87.5"],
  ] as const) {
    await fireEvent.input(field(), { target: { value: typed } });
    expect(text()).toContain(why);
    expect(button("Write…").disabled).toBe(true);
  }
});

it("a write is proposed, shown with before and after, and made once it is confirmed", async () => {
  const it = sheet({ confirmation: { before: value(10, "14"), after: value(11, "16") } });
  await ready();
  await fireEvent.input(field(), { target: { value: "11" } });
  await fireEvent.click(button("Write…"));
  await screen.findByText("10 → 11");
  expect(it.changes().map(({ body }) => body)).toEqual([{ kind: "write_parameter", name: "UOZOC", value: 11 }]);
  const reads = it.reads();
  await fireEvent.click(button("Write 11.0 °"));
  await screen.findByText("Written and read back: 10.0 ° → 11.0 °");
  expect(it.changes()).toHaveLength(2);
  await vi.waitFor(() => expect(it.reads()).toBeGreaterThan(reads));
});

it("who does not write sends nothing more", async () => {
  const it = sheet();
  await ready();
  await fireEvent.click(button("0.5 more"));
  await fireEvent.click(button("Write…"));
  await fireEvent.click(await screen.findByRole("button", { name: "Do not write" }));
  expect(field().value).toBe("10.5");
  expect(it.changes()).toHaveLength(1);
});

it("the start value is written back at one touch, by its bytes", async () => {
  const held = { now: value(12, "18"), start: value(10, "14"), start_time: 90 };
  const it = sheet({ held, confirmation: { before: value(12, "18"), after: value(10, "14") } });
  await fireEvent.click(await screen.findByRole("button", { name: "Back to 10.0 °" }));
  await screen.findByText("Written and read back: 12.0 ° → 10.0 °");
  expect(it.changes().map(({ path, body }) => [path, body])).toEqual([
    ["/changes", { kind: "write_parameter", name: "UOZOC", raw: "14" }],
    ["/changes/n", {}],
  ]);
});

it("the way back that was outdated is shown, not made unseen", async () => {
  const held = { now: value(12, "18"), start: value(10, "14"), start_time: 90 };
  const it = sheet({ held, confirmation: refused(410, "ConfirmationExpired") });
  await fireEvent.click(await screen.findByRole("button", { name: "Back to 10.0 °" }));
  await screen.findByText(/nothing was written/);
  expect(button("Write 11.0 °")).toBeTruthy();
  expect(it.changes().map(({ path }) => path)).toEqual(["/changes", "/changes/n", "/changes"]);
});

it.each(["WriteRefused", "NoResponse", "ReadBackDiffers"])("%s is shown with its advice, and the unit is read again", async (code) => {
  const it = sheet({ confirmation: refused(502, code) });
  await ready();
  await fireEvent.click(button("0.5 more"));
  await fireEvent.click(button("Write…"));
  const reads = it.reads();
  await fireEvent.click(await screen.findByRole("button", { name: "Write 11.0 °" }));
  await screen.findByText(`Advice on ${code}`);
  await vi.waitFor(() => expect(it.reads()).toBeGreaterThan(reads));
  expect(button("Write…")).toBeTruthy();
});

it("a lost connection is said until it is back; then what the unit holds", async () => {
  const cut = { off: false };
  const it = sheet({ confirmation: refused(502, "LinkLost"), cut });
  await ready();
  await fireEvent.click(button("0.5 more"));
  await fireEvent.click(button("Write…"));
  await screen.findByRole("button", { name: "Write 11.0 °" });
  cut.off = true;
  await fireEvent.click(button("Write 11.0 °"));
  await vi.waitFor(() => expect(screen.queryAllByText("Advice on LinkLost").length).toBeGreaterThan(0));
  it.say({ line: "no-port" });
  await screen.findByText("A parameter is written to the unit itself.");
  cut.off = false;
  it.say({ line: "sampling", unlocked_until: 1e12 });
  await screen.findByText("The connection was lost during the write, and is back. The unit holds 10.0 ° now.");
  expect(text()).not.toContain("Advice on LinkLost");
  await fireEvent.click(button("Write…"));
  await screen.findByText("10 → 11");
  expect(text()).not.toContain("The connection was lost");
});

it("a proposal that the lost connection prevented gives way to the form when it is back", async () => {
  const it = sheet({ proposed: refused(502, "LinkLost") });
  await ready();
  await fireEvent.click(button("0.5 more"));
  await fireEvent.click(button("Write…"));
  await screen.findByText("Advice on LinkLost");
  it.say({ line: "no-port" });
  await screen.findByText("A parameter is written to the unit itself.");
  it.say({ line: "sampling" });
  await vi.waitFor(() => expect(field().value).toBe("10.5"));
  await vi.waitFor(() => expect(text()).not.toContain("Advice on LinkLost"));
  expect(text()).not.toContain("during the write");
});

it("another tab that took control is named, and control can be taken", async () => {
  sheet({ proposed: refused(409, "NotController") });
  await ready();
  await fireEvent.click(button("0.5 more"));
  await fireEvent.click(button("Write…"));
  await screen.findByText("Advice on NotController");
  expect(button("Take control")).toBeTruthy();
});

it("behind the lock nothing can be written, and it can be unlocked here", async () => {
  sheet({ unlocked: false, held: { now: value(12, "18"), start: value(10, "14"), start_time: 90 } });
  await screen.findByRole("button", { name: "Back to 10.0 °" });
  expect([button("Back to 10.0 °").disabled, button("Write…").disabled]).toEqual([true, true]);
  expect(button("Unlock writing for 5 minutes…").disabled).toBe(false);
});

it("without the unit there is nothing to write to", () => {
  const it = sheet();
  it.say({ line: "no-port" });
  return screen.findByText("A parameter is written to the unit itself.");
});

it("its journal has the writes of this parameter only", async () => {
  const entry = (en: string) => ({ time: 1, change: words(en), state: "done", before: "14", after: "16", outcome: "16" });
  sheet({ journal: [entry("write parameter UOZOC"), entry("write parameter SSM"), entry("erase 1 stored fault")] });
  await screen.findByText(/Journal.* · 1$/);
});
