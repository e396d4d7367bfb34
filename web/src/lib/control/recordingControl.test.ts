import { expect, it, vi } from "vitest";
import type { State } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { live, recordingControl, recordings, toasts } = new Stores(served);

it("a recording can be asked for as soon as the port is being opened, and not while there is none", () => {
  live.link = "open";
  const refused = (line: State["line"], reason_code: string | null = null) => {
    live.state = { line, reason_code, rights: "control" } as State;
    return recordingControl.refusal !== null;
  };
  expect([refused("no-port"), refused("ecu-alive"), refused("sampling")]).toEqual([false, false, false]);
  expect([refused("off"), refused("no-port", "PortNotFound"), refused("no-echo", "NoEcho"), refused("echo-only", "EchoOnly")]).toEqual([
    true,
    true,
    true,
    true,
  ]);
});

it("a recording that has ended can be opened at once", () => {
  const show = vi.spyOn(recordings, "show").mockResolvedValue();
  recordingControl.announceSaved("drive.pcapng");
  const { text, action } = toasts.shown.at(-1)!;
  expect([text(), action?.text()]).toEqual(["Recording saved: drive.pcapng", "Open"]);
  action!.run();
  expect(show).toHaveBeenCalledWith("drive.pcapng");
});
