import { fireEvent, screen, waitFor } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it, vi } from "vitest";
import type { CoStep } from "../../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../../test/pageRig";
import Screen from "./Screen.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const byte = (raw: string) => ({ raw, value: (parseInt(raw, 16) - 256) / 256 });
const meters = [
  { meter: "co", lowest: 0, highest: 15, within: 0.2 },
  { meter: "lambda", lowest: 0.5, highest: 2, within: 0.015 },
];
const step = (more: Partial<CoStep> = {}): CoStep => ({
  ...{ outcome: "write", next: byte("80"), why: words("The mixture has to be leaner."), turned: false, now: byte("88"), problems: [] },
  ...more,
});

/** The screen over a unit whose RCOD is what was written; `steps`: what each figure leads to. */
function setting({ steps = [step()], problems = [] as object[], unlocked = true } = {}) {
  let raw = "88";
  let wanted = "";
  let at = 0;
  const shown = page({
    "/co/step": () => steps[at++],
    "/co": () => ({ now: byte(raw), values: { FREQ: 840, TWAT: 88, THR: 0 }, problems, meters }),
    "/changes/n": () => {
      const before = byte(raw);
      raw = wanted;
      return { before: { ...before, unit: "" }, after: { ...byte(raw), unit: "" } };
    },
    "/changes": (body: unknown) => {
      wanted = (body as { raw: string }).raw;
      return {
        nonce: "n",
        expires: 1e12,
        before: { ...byte(raw), unit: "" },
        after: { ...byte(wanted), unit: "" },
        danger: false,
        meaning: null,
      };
    },
  });
  shown.say({ unlocked_until: unlocked ? 1e12 : null });
  shown.show(Screen, {});
  const bodies = (path: string) => shown.asked.filter((it) => it.method === "POST" && it.path === path).map((it) => it.body);
  return { ...shown, bodies, raw: () => raw };
}
const button = (name: string | RegExp) => screen.getByRole<HTMLButtonElement>("button", { name });
const press = async (name: string | RegExp) => {
  await waitFor(() => expect(button(name).disabled).toBe(false));
  await fireEvent.click(button(name));
};
const type = (label: RegExp, text: string) => fireEvent.input(screen.getByLabelText(label), { target: { value: text } });

async function begun(how: Parameters<typeof setting>[0] = {}) {
  const it = setting(how);
  await screen.findByText(/Warm idle: 840 rpm, 88 °C/);
  await type(/Figure to reach/, "0,8");
  await press("Begin");
  return it;
}
async function measured(figure: string) {
  await screen.findByLabelText(/CO, % on the meter/);
  await type(/CO, % on the meter/, figure);
  await press("Next step");
}

it("a step is asked for with all figures, shown with before and after, written once confirmed, and put back by one touch", async () => {
  const { bodies, raw } = await begun({
    steps: [step(), step({ outcome: "set", next: byte("80"), now: byte("80"), why: words("In the band.") })],
  });
  await measured("2.0");
  await screen.findByText("Write to RCOD: −0.469 → −0.500");
  expect(raw()).toBe("88");
  await press("Write −0.500");
  await waitFor(() => expect(raw()).toBe("80"));
  await measured("0.9");
  await screen.findByText("Done: the figure is in the band");
  expect(bodies("/co/step")).toEqual([
    { meter: "co", target: 0.8, within: 0.2, found: "88", figures: [2] },
    { meter: "co", target: 0.8, within: 0.2, found: "88", figures: [2, 0.9] },
  ]);
  await press("Back to −0.469, as found");
  await waitFor(() => expect(raw()).toBe("88"));
  await waitFor(() => expect(screen.queryByRole("button", { name: /^Back to/ })).toBeNull());
});

it("a step that is declined writes nothing, and its figure does not count", async () => {
  const { bodies, raw } = await begun({ steps: [step(), step()] });
  await measured("2");
  await press("Don't write");
  await measured("1.9");
  await screen.findByText("Write to RCOD: −0.469 → −0.500");
  expect(raw()).toBe("88");
  expect(bodies("/co/step").at(-1)).toMatchObject({ figures: [1.9] });
});

it("a stop says why, and offers what was found first", async () => {
  await begun({ steps: [step(), step({ outcome: "stop", next: byte("88"), why: words("The figure does not follow RCOD.") })] });
  await measured("3");
  await press("Write −0.500");
  await waitFor(() => expect(screen.queryByText(/Write to RCOD/)).toBeNull());
  await measured("3");
  await screen.findByText("The figure does not follow RCOD.");
  expect(button("Back to −0.469, as found").className).toContain("primary");
});

it("away from warm idle nothing begins, and a figure does not count", async () => {
  const cold = [words("the coolant has 20 °C, 70 are needed")];
  const { bodies } = setting({ problems: cold });
  await screen.findByText("the coolant has 20 °C, 70 are needed");
  await type(/Figure to reach/, "0.8");
  expect(button("Begin").disabled).toBe(true);
  expect(bodies("/co/step")).toEqual([]);
});

it("an engine that leaves idle meanwhile is said, and the same figure is given again", async () => {
  const { bodies } = await begun({ steps: [step({ problems: [words("the throttle is open by 20 %")] }), step()] });
  await measured("2");
  await screen.findByText("the throttle is open by 20 %");
  expect(bodies("/changes")).toEqual([]);
  await measured("2");
  await screen.findByText("Write to RCOD: −0.469 → −0.500");
  expect(bodies("/co/step").at(-1)).toMatchObject({ figures: [2] });
});

it("locked writing begins nothing; a figure that no meter shows is refused", async () => {
  setting({ unlocked: false });
  await screen.findByText(/Warm idle/);
  await type(/Figure to reach/, "20");
  await screen.findByText("A number from 0 to 15.");
  await type(/Figure to reach/, "0.8");
  expect(button("Begin").disabled).toBe(true);
});

it("a λ meter beside the unit gives its figure by one touch", async () => {
  const { stores, bodies } = setting();
  await screen.findByText(/Warm idle/);
  vi.spyOn(stores.display, "value").mockImplementation((name) => (name === "LAMBDA" ? { kind: "fresh", value: 1.02 } : { kind: "none" }));
  await fireEvent.change(screen.getByLabelText("Meter"), { target: { value: "lambda" } });
  await type(/Figure to reach/, "0.98");
  await press("Begin");
  await press(/^Take 1.* from the meter beside the unit$/);
  await press("Next step");
  await waitFor(() => expect(bodies("/co/step")).toEqual([{ meter: "lambda", target: 0.98, within: 0.015, found: "88", figures: [1.02] }]));
});

it("what a person has typed stays while the unit is away", async () => {
  const it = setting();
  const away = () => {
    for (const line of ["no-echo", "sampling"] as const) {
      it.say({ line, unlocked_until: 1e12 });
      flushSync();
    }
  };
  await screen.findByText(/Warm idle/);
  await type(/Figure to reach/, "0.8");
  await type(/Near enough/, "0.3");
  away();
  await press("Begin");
  await screen.findByLabelText(/CO, % on the meter/);
  await type(/CO, % on the meter/, "2.0");
  away();
  await press("Next step");
  await waitFor(() => expect(it.bodies("/co/step")).toEqual([{ meter: "co", target: 0.8, within: 0.3, found: "88", figures: [2] }]));
});
