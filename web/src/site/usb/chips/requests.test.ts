import { afterEach, describe, expect, it, vi } from "vitest";
import { refuses } from "../../../../test/chipRig";
import { ch340, ftdi } from "../../../../test/scriptedUsb";

afterEach(() => void vi.useRealTimers());

describe("a chip that refuses a request", () => {
  it.each(["stall", "babble"] as const)("by a %s is an error", async (answer) => {
    const it = ftdi();
    it.answers = [["40 03", answer]];
    await refuses(it).toMatchObject({ name: "ChipError", message: expect.stringContaining("0x3") as string });
  });

  it("is one that answers too few bytes, or nothing", async () => {
    const short = ch340();
    short.answers.push(["c0 5f", [0x31]]);
    await refuses(short).toMatchObject({ name: "ChipError" });
    vi.useFakeTimers();
    const mute = ch340();
    mute.answers.push(["c0 5f", "hang"]);
    const refused = refuses(mute).toMatchObject({ name: "TimeoutError" });
    await vi.advanceTimersByTimeAsync(1000);
    await refused;
  });
});
