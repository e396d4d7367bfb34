import { beforeEach, expect, it, vi } from "vitest";
import { ApiError } from "../../lib/api/http";
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

it("changes of the port go one after another, and of those wanted meanwhile the last one", async () => {
  const sent: (string | undefined)[] = [];
  let end: (() => void) | undefined;
  const answer = (port?: string | null) => {
    sent.push(port ?? undefined);
    return new Promise<State>((resolve) => (end = () => resolve(state)));
  };
  vi.spyOn(api, "disconnect").mockImplementation(() => answer());
  connect.mockImplementation(answer);
  const left = connection.connect();
  const [other, driven] = [connection.connect("/dev/ttyUSB0"), connection.drive("sim:")];
  await Promise.resolve();
  expect([sent, connection.wanted]).toEqual([[undefined], "sim:"]);
  end!();
  await Promise.all([left, other]);
  await vi.waitFor(() => expect(sent).toEqual([undefined, "sim:"]));
  expect([connection.wanted, go.mock.calls]).toEqual(["sim:", []]);
  end!();
  await driven;
  expect([connection.wanted, go.mock.calls]).toEqual([null, [["live"]]]);
});

it("a change that was refused lets the next one go", async () => {
  connect.mockRejectedValueOnce(new ApiError(409, "Busy", { en: "Not now", ru: "" }));
  await Promise.all([connection.connect("/dev/ttyUSB0"), connection.drive("sim:")]);
  expect(connect.mock.calls).toEqual([["/dev/ttyUSB0"], ["sim:"]]);
  expect(go).toHaveBeenCalledWith("live");
});
