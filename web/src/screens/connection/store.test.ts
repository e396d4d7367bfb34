import { beforeEach, expect, it, vi } from "vitest";
import type { State } from "../../lib/api/types";
import { served } from "../../lib/platform/host";
import { Stores } from "../../stores";

const { api, connection, live, recordingControl, route } = new Stores(served);
const state = { line: "off", port: null, recording: null } as unknown as State;

const spies = () => ({ connect: vi.spyOn(api, "connect").mockResolvedValue(state), go: vi.spyOn(route, "go").mockReturnValue() });
let { connect, go } = spies();

beforeEach(() => {
  ({ connect, go } = spies());
  live.state = state;
});

it("a virtual car leads to its gauges, an adapter does not", async () => {
  await connection.connect("/dev/ttyUSB0");
  expect(go).not.toHaveBeenCalled();
  await connection.drive("sim:");
  expect(connect).toHaveBeenLastCalledWith("sim:");
  expect(go).toHaveBeenCalledWith("live");
});

it("a virtual car that can't be started leads nowhere", async () => {
  connect.mockRejectedValue(new DOMException("gone", "AbortError"));
  await connection.drive("sim:?scenario=");
  expect(go).not.toHaveBeenCalled();
});

it("amid a recording the gauges are shown once the recording may end", async () => {
  vi.spyOn(recordingControl, "announceSaved").mockReturnValue();
  live.state = { ...state, port: "sim:", recording: { file: "a.pcapng", failure: null } } as unknown as State;
  await connection.drive("sim:?scenario=city");
  expect([connect, go].map((it) => it.mock.calls.length)).toEqual([0, 0]);
  await connection.leave();
  expect(go).toHaveBeenCalledWith("live");
});
