import { afterEach, expect, it, vi } from "vitest";
import type { RecordingDetail } from "../../../lib/api/types";
import { served } from "../../../lib/platform/host";
import { Stores } from "../../../stores";

const { comparing, comparison, player, route } = new Stores(served);

afterEach(() => {
  player.detail = null;
});

it("a comparison that was cancelled while it was opened does not come", async () => {
  player.detail = { id: "a.pcapng" } as RecordingDetail;
  let done = (_: boolean) => {};
  vi.spyOn(comparison, "start").mockImplementation(() => new Promise((resolve) => (done = resolve)));
  const ended = vi.spyOn(comparison, "end");
  const gone = vi.spyOn(route, "go").mockReturnValue();
  comparing.choose("a.pcapng");
  const opened = comparing.begin("a.pcapng", "virtual:warm-idle:7.1");
  comparing.stop();
  expect(ended).toHaveBeenCalledOnce();
  done(true);
  await opened;
  expect([gone.mock.calls.length, comparing.first, comparing.busy]).toEqual([0, null, null]);
  comparing.choose("a.pcapng");
  const again = comparing.begin("a.pcapng", "b.pcapng");
  done(true);
  await again;
  expect([gone.mock.lastCall, comparing.busy]).toEqual([["chart"], null]);
});
