import { expect, it, vi } from "vitest";
import type { Dump, Dumps, FreezeFrames, Recording, Recordings } from "../lib/api/types";
import { served } from "../lib/platform/host";
import { Stores } from "../stores";

const { api, faults, live, memory, recordings } = new Stores(served);
const never = () => new Promise<never>(() => undefined);

it("a deleted recording is in the list no more, however long the next list takes", async () => {
  live.link = "open";
  const list = [{ id: "a.pcapng" }, { id: "b.pcapng" }] as Recording[];
  vi.spyOn(api, "references").mockImplementation(never);
  vi.spyOn(api, "recordings")
    .mockResolvedValueOnce({ recordings: list, problem: null, left_out: [] } as unknown as Recordings)
    .mockImplementation(never);
  await recordings.list.reload();
  recordings.dropDeleted("a.pcapng");
  expect(recordings.list.value?.map((it) => it.id)).toEqual(["b.pcapng"]);
});

it("a deleted dump is in the list no more, however long the next list takes", async () => {
  const list = [{ id: "1" }, { id: "2" }] as Dump[];
  vi.spyOn(api, "dumps")
    .mockResolvedValueOnce({ dumps: list, left_out: [] } as unknown as Dumps)
    .mockImplementation(never);
  await memory.dumps.reload();
  memory.dropDeleted("2");
  expect(memory.dumps.value?.map((it) => it.id)).toEqual(["1"]);
});

it("a deleted freeze frame is in the list no more, with what the program says is left", async () => {
  const left = { frames: [] } as unknown as FreezeFrames;
  vi.spyOn(api, "freezeFrames").mockImplementation(never);
  vi.spyOn(api, "deleteFreezeFrame").mockResolvedValue(left);
  faults.frames.value = { frames: [{ id: "1" }] } as unknown as FreezeFrames;
  await faults.deleteFrame("1");
  expect(faults.frames.value).toBe(left);
});
