import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import type { ActionRule } from "../../lib/api/types";
import { channelOf, eachOnItsOwnPage, page, refused } from "../../../test/pageRig";
import ActionsSheet from "./ActionsSheet.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const HOT: ActionRule = {
  ...{ name: "hot", when: "TWAT > 105", hold: 3, until: "", again: 0, once: false, mark: null, record: null },
  ...{ sound: true, speak: null, mqtt: false, webhook: "" },
};

function sheet({
  rules = [HOT],
  problem = null as object | null,
  network = true,
  waits = {},
  tried = {} as object,
  written = {} as unknown,
} = {}) {
  const kept = { rules, broker: "", topic: "", problem, network, waits, file: "actions.toml" };
  let now: object = kept;
  const shown = page({
    "/actions/try": { problem: null, waits: null, value: 0, times: [], count: 0, seconds: 600, ...tried },
    "/actions/hot/perform": () => now,
    "/actions": (body: unknown) => {
      if (body === undefined) return now;
      if (written instanceof Response) return written.clone();
      return (now = { ...kept, ...(body as object) });
    },
  });
  shown.say();
  shown.stores.catalog.use({ version: "1", parameters: [channelOf("TWAT")], derived: [], faults: [] } as never);
  shown.show(ActionsSheet, { onclose: () => undefined });
  const writes = () => shown.asked.filter(({ method }) => method === "PUT").map(({ body }) => body);
  return { ...shown, writes };
}
const button = (name: string) => screen.getByRole<HTMLButtonElement>("button", { name });
const text = () => document.body.textContent.replace(/\s+/g, " ");

it("each action says when it acts and what it does", async () => {
  sheet();
  await screen.findByText("TWAT > 105");
  expect(text()).toContain("for 3 s");
  expect(document.querySelector("[data-action=hot] .badge")!.textContent).toBe("Sound");
});

it("a new action is tried while it is typed, and saved with the others", async () => {
  const { asked, writes } = sheet({ tried: { value: 1, count: 2, times: [10, 20] } });
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("New action…"));
  await fireEvent.input(screen.getByLabelText("Name"), { target: { value: "cold" } });
  await fireEvent.input(screen.getByLabelText("When"), { target: { value: "TWAT < 10" } });
  await fireEvent.input(screen.getByLabelText("Holds for, s"), { target: { value: "0,5" } });
  await fireEvent.click(screen.getByLabelText("Sound"));
  await vi.waitFor(() => expect(text()).toContain("it would have acted 2 times"));
  expect(asked.find(({ path }) => path === "/actions/try")!.body).toMatchObject({ when: "TWAT < 10" });
  await fireEvent.click(button("Save"));
  await vi.waitFor(() => expect(writes()).toHaveLength(1));
  expect(writes()[0]).toMatchObject({ rules: [{ name: "hot" }, { name: "cold", hold: 0.5, sound: true }] });
  await vi.waitFor(() => expect(document.querySelector("[data-action=cold]")).not.toBeNull());
});

it("a mistake in the condition is shown, and is not saved", async () => {
  sheet({ tried: { problem: words("names TWOT, which does not exist") } });
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("Edit…"));
  await screen.findByText(/names TWOT/);
  expect(button("Save").disabled).toBe(true);
});

it("an action whose instrument is away says so in the list and in the form", async () => {
  const waits = words("No instrument beside the unit gives LAMBDA: add one that does on Connection.");
  sheet({ waits: { hot: waits }, tried: { waits, value: null } });
  await screen.findByText(waits.en);
  await fireEvent.click(button("Edit…"));
  await vi.waitFor(() => expect(document.querySelector("[data-trial]")?.textContent).toContain(waits.en));
  expect(text()).not.toContain("are not being read");
});

it("a mistake in what is said stands at its field, without the file's key", async () => {
  sheet({ tried: { problem: words("`action.trial.speak`: there is no NOSUCH") } });
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("Edit…"));
  const said = await screen.findByText("there is no NOSUCH");
  expect(said.previousElementSibling!.textContent).toContain("Say");
  expect(button("Save").disabled).toBe(true);
});

it("an action that does nothing is not saved, and says what to choose", async () => {
  sheet();
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("Edit…"));
  expect(text()).not.toContain("Choose at least one thing");
  await fireEvent.click(screen.getByLabelText("Sound"));
  expect(text()).toContain("Choose at least one thing");
  expect(button("Save").disabled).toBe(true);
});

it("a name stands for one action", async () => {
  sheet();
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("New action…"));
  await fireEvent.input(screen.getByLabelText("Name"), { target: { value: "hot" } });
  expect(text()).toContain("There is an action of this name already.");
  await fireEvent.input(screen.getByLabelText("Name"), { target: { value: "a b" } });
  expect(text()).toContain("no spaces");
  expect(button("Save").disabled).toBe(true);
});

it("what the program refuses stays in the form", async () => {
  const { writes } = sheet({ written: refused(403, "OnlyHere") });
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("Edit…"));
  await fireEvent.click(button("Save"));
  await vi.waitFor(() => expect(writes()).toHaveLength(1));
  const form = screen.getByRole("heading", { name: "Action hot" }).closest("dialog")!;
  await vi.waitFor(() => expect(form.querySelector("[role=alert]")).not.toBeNull()); // a toast would be covered
});

it("an action is deleted after a question, and done now as a trial", async () => {
  const { asked, writes } = sheet();
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("Do it now"));
  expect(asked.some(({ method, path }) => method === "POST" && path === "/actions/hot/perform")).toBe(true);
  await screen.findByText("Done as a trial: hot. A recording is not touched.");
  await fireEvent.click(button("Delete"));
  await fireEvent.click(screen.getAllByRole("button", { name: "Delete" }).at(-1)!);
  await vi.waitFor(() => expect(writes()).toEqual([{ rules: [], broker: "", topic: "" }]));
});

it("a page without a network offers no MQTT and no webhook", async () => {
  sheet({ network: false });
  await screen.findByText("TWAT > 105");
  await fireEvent.click(button("Edit…"));
  expect(screen.queryByLabelText("Webhook on this computer")).toBeNull();
  expect(screen.queryByLabelText("Publish by MQTT")).toBeNull();
});

it("a file with a mistake is named", async () => {
  sheet({ rules: [], problem: words("actions.toml:2: `when` is not a formula") });
  await screen.findByText("actions.toml:2: `when` is not a formula");
  expect(text()).toContain("actions.toml.broken");
});
