import { fireEvent, screen, within } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it } from "vitest";
import type { Port } from "../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import Ports from "./Ports.svelte";

eachOnItsOwnPage();
const port = (url: string, likely: boolean): Port =>
  ({ url, chip: likely ? "FT232R" : "", description: `Port ${url}`, likely, quirks: [] }) as Port;

async function ports(line: "off" | "sampling", allowed = true) {
  const shown = page({ "/ports": { ports: [port("COM3", true), port("COM1", false)] } });
  shown.say({ line, port: line === "off" ? null : "COM3" });
  await shown.stores.connection.ports.reload();
  shown.show(Ports, { allowed });
  flushSync();
  return shown;
}
const sent = ({ asked }: Awaited<ReturnType<typeof ports>>) =>
  asked.filter(({ method }) => method === "POST").map(({ path, body }) => [path, (body as { port?: string }).port]);

it("the best guess is marked and connected to by one click", async () => {
  const shown = await ports("off");
  const card = screen.getByText("FT232R").closest("li")!;
  expect(card.textContent).toContain("★");
  await fireEvent.click(within(card).getByRole("button"));
  expect(sent(shown)).toEqual([["/connect", "COM3"]]);
});

it("a port without an adapter's chip stands below", async () => {
  await ports("off");
  expect(screen.getByText("Port COM1").closest("details")).not.toBeNull();
});

it("without an adapter the list says so, and leaves the advice to the situation above", async () => {
  const shown = page({ "/ports": { ports: [] } });
  shown.say({ line: "off", port: null });
  await shown.stores.connection.ports.reload();
  shown.show(Ports, { allowed: true });
  flushSync();
  expect(document.body.textContent).toContain("None so far.");
  expect(document.body.textContent).not.toContain("Plug the KKL cable");
});

it("the port in use can be left, and by nobody who may not", async () => {
  const shown = await ports("sampling");
  await fireEvent.click(screen.getByRole("button", { name: "Disconnect" }));
  expect(sent(shown)).toEqual([["/disconnect", undefined]]);
});

it("without control nothing can be pressed", async () => {
  await ports("off", false);
  expect(screen.getByRole<HTMLButtonElement>("button", { name: /COM3/ }).disabled).toBe(true);
});

it("while recording, another port is asked about first", async () => {
  const shown = await ports("sampling");
  shown.say({ recording: { file: "a.pcapng", failure: null } as never });
  await shown.stores.connection.connect("COM1");
  expect(shown.stores.connection.leaving).toEqual({ file: "a.pcapng", port: "COM1", driven: false });
  expect(sent(shown)).toEqual([]);
});

it("the pause's field stays open while its own reconnection closes the port", async () => {
  const shown = await ports("sampling");
  const field = () => document.querySelector<HTMLDetailsElement>("[data-pause]");
  const before = field()!;
  before.open = true;
  void shown.stores.connection.pausing.run(() => new Promise(() => undefined));
  shown.say({ line: "off", port: null });
  flushSync();
  expect(field()).toBe(before);
});
