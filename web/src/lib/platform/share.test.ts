import { afterEach, expect, it, vi } from "vitest";
import { canShareFiles, share, toShare } from "./share";

/** Chromium's list, from its sources (`FILE_TYPES.md` of its Web Share), without what has to do with sound and films. */
const LISTED = /\.(avif|bmp|css|csv|gif|htm|html|ico|jpeg|jpg|pdf|png|svg|text|tif|tiff|txt|webp)$/;
const TYPES = /^(image\/.*|text\/.*|application\/pdf)$/;

afterEach(() => void vi.unstubAllGlobals());

function browser({ isActive = true, fails = "" } = {}) {
  const shared: File[] = [];
  const navigator = {
    userActivation: { isActive },
    canShare: ({ files }: { files: File[] }) => files.length > 0,
    share({ files }: { files: File[] }): Promise<void> {
      if (fails) return Promise.reject(new DOMException("as the browser says it", fails));
      if (!files.every(({ name, type }) => LISTED.test(name) && TYPES.test(type))) {
        return Promise.reject(new DOMException("Permission denied", "NotAllowedError"));
      }
      shared.push(...files);
      return Promise.resolve();
    },
  };
  vi.stubGlobal("navigator", navigator);
  return shared;
}

it("each file of the program is one that Chromium hands over, with its bytes as they are", async () => {
  const shared = browser();
  const bytes = new Uint8Array([10, 13, 0, 255]);
  const names = ["Поездка 7.1.pcapng", "a.csv", "a.html", "a.png", "a.svg", "a.txt", "dump.bin", "no-suffix"];
  for (const name of names) expect([name, await share(toShare(name, bytes))]).toEqual([name, "shared"]);
  expect(shared.map(({ name }) => name)).toEqual([
    ...["Поездка 7.1.pcapng.txt", "a.csv", "a.html", "a.png", "a.svg", "a.txt", "dump.bin.txt", "no-suffix.txt"],
  ]);
  expect(new Uint8Array(await shared[0]!.arrayBuffer())).toEqual(bytes);
});

it("a sheet that is closed is no error, a refusal is", async () => {
  const outcomes = {
    AbortError: "closed",
    InvalidStateError: "closed",
    NotAllowedError: "refused",
    DataError: "refused",
    TypeError: "refused",
  };
  for (const [fails, outcome] of Object.entries(outcomes)) {
    browser({ fails });
    expect([fails, await share(toShare("a.csv", "a"))]).toEqual([fails, outcome]);
  }
});

it("a touch that is over is not tried, nor is a file that browsers find too large", async () => {
  const shared = browser({ isActive: false });
  expect(await share(toShare("a.csv", "a"))).toBe("late");
  expect(await share(toShare("a.pcapng", new Uint8Array(50 * 1024 * 1024 + 1)))).toBe("large");
  expect(shared).toEqual([]);
});

it("a browser that shares no files is known", () => {
  browser();
  expect(canShareFiles()).toBe(true);
  vi.stubGlobal("navigator", {});
  expect(canShareFiles()).toBe(false);
  vi.stubGlobal("navigator", { canShare: () => false });
  expect(canShareFiles()).toBe(false);
});
