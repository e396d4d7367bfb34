import { cleanup, fireEvent, screen } from "@testing-library/svelte";
import { expect, it } from "vitest";
import { eachOnItsOwnPage, page, type Answers } from "../../../test/pageRig";
import MomentsBar from "../../screens/chart/time/moments/MomentsBar.svelte";
import MarkerName from "./MarkerName.svelte";

eachOnItsOwnPage();

const detail = { id: "drive.pcapng", first: 100, last: 200, events: [], samples: 2, channels: [] };

function shown(answers: Answers = {}) {
  const rig = page({ "/recordings/drive.pcapng/markers": (body: unknown) => body, "/recording/marker": { time: 7 }, ...answers });
  rig.say();
  const { player, display } = rig.stores;
  player.detail = detail as never;
  player.position = 142.5;
  display.play(player);
  rig.asked.length = 0;
  return rig;
}

it("marks the recording that is open, where it stands", async () => {
  const { asked, stores } = shown();
  await stores.naming.here();
  const marks = [{ time: 142.5, label: "" }];
  expect(asked).toEqual([{ method: "POST", path: "/recordings/drive.pcapng/markers", body: { markers: marks } }]);
  expect(stores.player.events).toEqual([{ kind: "marker", time: 142.5, label: "" }]);
  expect(stores.naming.marker).toEqual({ time: 142.5, recorded: true, id: "drive.pcapng" });
});

it("marks where the chart's cursor stands, while nothing is played", async () => {
  const { stores } = shown();
  stores.cursors.a = 120.25;
  await stores.naming.here();
  location.hash = "#/chart";
  stores.route.screen = "chart";
  await stores.naming.here();
  expect(stores.player.events.map(({ time }) => time)).toEqual([120.25, 142.5]);
});

it("marks live data where no recording is open, and with the button of the one in progress", async () => {
  const { asked, stores } = shown();
  await stores.naming.now();
  stores.player.close();
  await stores.naming.here();
  expect(asked.filter(({ method }) => method === "POST").map(({ path }) => path)).toEqual(["/recording/marker", "/recording/marker"]);
  expect(stores.naming.marker).toEqual({ time: 7, recorded: false, id: null });
});

it("sets no marker that the program has refused, and says why", async () => {
  const refused = { error: { code: "CaptureError", en: "it may only be read", ru: "только для чтения", sent: null, received: null } };
  const { stores } = shown({ "/recordings/drive.pcapng/markers": () => new Response(JSON.stringify(refused), { status: 400 }) });
  await stores.naming.here();
  expect([stores.player.events, stores.naming.marker]).toEqual([[], null]);
  expect(stores.toasts.shown.map(({ text }) => text()).join()).toContain("it may only be read");
});

it("the name that is typed goes to the recording", async () => {
  const { asked, show } = shown();
  show(MarkerName, { marker: { time: 142.5, recorded: true, id: "drive.pcapng" } });
  expect(screen.getByRole("status").textContent).toContain("drive.pcapng");
  await fireEvent.input(screen.getByRole("textbox"), { target: { value: "knock" } });
  await fireEvent.submit(document.querySelector("form")!);
  cleanup();
  const named = { time: 142.5, label: "knock" };
  expect(asked.at(-1)).toEqual({ method: "PUT", path: "/recordings/drive.pcapng/marker", body: named });
});

it("found moments become markers, all at once", async () => {
  const { asked, show, stores } = shown();
  stores.moments.mark(
    () => "FREQ 3000, DET",
    [110, 120, 130].map((from) => ({ from, to: from + 1 })),
  );
  show(MomentsBar, {});
  await fireEvent.click(screen.getByRole("button", { name: "Set markers (3)" }));
  await expect.poll(() => stores.player.events.map(({ time }) => time)).toEqual([110, 120, 130]);
  expect(asked.filter(({ method }) => method === "POST")).toHaveLength(1);
  expect(stores.toasts.shown.map(({ text }) => text())).toEqual(["3 markers set"]);
});
