import { describe, expect, it } from "vitest";
import { SEVEN_E_TWO, asksFor, atTheRates, chipOf, refuses, started, unsupported } from "../../../../test/chipRig";
import { cp210x } from "../../../../test/scriptedUsb";

describe("a CP210x", () => {
  it("is enabled again, and has no flow control", async () => {
    const [asked, rate] = await started(cp210x());
    const zeros = " 00".repeat(16);
    expect(asked).toEqual([
      "c0 ff 370b 0000",
      "41 00 0000 0000",
      "41 00 0001 0000",
      "41 1e 0000 0000 80 25 00 00",
      "41 03 0800 0000",
      `41 13 0000 0000${zeros}`,
    ]);
    expect(rate).toBe(9600);
  });

  it("has the rates of cp210x: a CP2102 makes 14400 of 10400", async () => {
    expect(await atTheRates(cp210x, "41 1e")).toEqual([
      ["41 1e 0000 0000 c0 12 00 00", "41 1e 0000 0000 80 25 00 00", "41 1e 0000 0000 40 38 00 00", "41 1e 0000 0000 00 c2 01 00"],
      [4800, 9600, 14400, 115200],
    ]);
    expect(await atTheRates(() => cp210x(0x04), "41 1e")).toEqual([
      ["41 1e 0000 0000 c0 12 00 00", "41 1e 0000 0000 80 25 00 00", "41 1e 0000 0000 9e 28 00 00", "41 1e 0000 0000 b8 c2 01 00"],
      [4800, 9600, 10399, 115385],
    ]);
    expect((await started(cp210x(0x01), { baudRate: 16_000 }))[1]).toBe(19_200);
    expect((await started(cp210x(0x20), { baudRate: 300 }))[1]).toBe(300);
    await refuses(cp210x(), { baudRate: 110 }).toMatchObject(unsupported);
    const mute = cp210x();
    mute.answers = [["c0 ff", "stall"]];
    expect((await started(mute, { baudRate: 10_400 }))[1]).toBe(14_400);
  });

  it("has other lines, signals, a break and an end", async () => {
    const [asked] = await started(cp210x(), SEVEN_E_TWO);
    expect(asked[4]).toBe("41 03 0722 0000");
    expect(await asksFor(cp210x(), (chip) => chip.setSignals(true, false))).toEqual(["41 07 0301 0000"]);
    const pulled = await asksFor(cp210x(), async (chip) => (await chip.setBreak(true), await chip.setBreak(false)));
    expect(pulled).toEqual(["41 05 0001 0000", "41 05 0000 0000"]);
    expect(await asksFor(cp210x(), (chip) => chip.stop!())).toEqual(["41 12 000f 0000", "41 00 0000 0000"]);
  });

  it("is asked for errors of the wire, and reports each once", async () => {
    const it = cp210x();
    const chip = chipOf(it);
    const status = (errors: number) => it.answers.push(["c1 10", [errors, ...new Array<number>(18).fill(0)]]);
    status(0);
    expect(await chip.askError!()).toBeNull();
    status(0x02);
    expect([await chip.askError!(), await chip.askError!()]).toEqual(["FramingError", null]);
    status(0x0a);
    expect(await chip.askError!()).toBe("BufferOverrunError");
    it.answers.push(["c1 10", "stall"]);
    expect(await chip.askError!()).toBeNull();
  });
});
