import { afterEach, describe, expect, it, vi } from "vitest";
import { EIGHT_N_ONE, SEVEN_E_TWO, asksFor, atTheRates, chipOf, refuses, started, unsupported } from "../../../../test/chipRig";
import { ch340, type ScriptedUsb } from "../../../../test/scriptedUsb";

afterEach(() => void vi.useRealTimers());

describe("a CH34x", () => {
  it("resets the chip, and hands bytes over at once", async () => {
    const [asked, rate] = await started(ch340());
    expect(asked).toEqual(["c0 5f 0000 0000", "40 a1 0000 0000", "c0 95 0005 0000", "40 9a 1312 b282", "40 9a 2518 00c3"]);
    expect(Math.round(rate)).toBe(9615);
  });

  it("has the divisors of ch341", async () => {
    expect(await atTheRates(ch340, "40 9a 1312")).toEqual([
      ["40 9a 1312 6482", "40 9a 1312 b282", "40 9a 1312 b882", "40 9a 1312 cc83"],
      [4808, 9615, 10417, 115385],
    ]);
    const limited = () => {
      const it = ch340();
      it.answers.push(["c0 95 0005", "stall"]);
      return it;
    };
    expect((await atTheRates(limited, "40 9a 1312"))[0]).toEqual([
      "40 9a 1312 6482",
      "40 9a 1312 b282",
      "40 9a 1312 b882",
      "40 9a 1312 cc83",
    ]);
    const odd = async (device: ScriptedUsb) => (await started(device, { baudRate: 13_000 }))[0][3];
    expect([await odd(ch340()), await odd(limited())]).toEqual(["40 9a 1312 8d86", "40 9a 1312 c682"]);
    await refuses(ch340(), { baudRate: 45 }).toMatchObject(unsupported);
  });

  it("of an old version has neither the bit nor the register of the line", async () => {
    const [asked] = await started(ch340(0x27));
    expect(asked.slice(-1)).toEqual(["40 9a 1312 b202"]);
    await refuses(ch340(0x27), SEVEN_E_TWO).toMatchObject(unsupported);
  });

  it("has other lines, signals and a break", async () => {
    const [asked] = await started(ch340(), SEVEN_E_TWO);
    expect(asked.at(-1)).toBe("40 9a 2518 00de");
    expect(await asksFor(ch340(), (chip) => chip.setSignals(true, false))).toEqual(["40 a4 ffdf 0000"]);
    const pulled = await asksFor(ch340(), async (chip) => (await chip.setBreak(true), await chip.setBreak(false)));
    expect(pulled).toEqual(["c0 95 1805 0000", "40 9a 1805 8300", "c0 95 1805 0000", "40 9a 1805 c301"]);
  });

  it("without a break sends a zero at the lowest rate", async () => {
    vi.useFakeTimers();
    const it = ch340();
    it.answers.push(["c0 95 0005", "stall"]);
    const chip = chipOf(it);
    await chip.start(EIGHT_N_ONE);
    it.asked = [];
    await chip.setBreak(true);
    expect([it.asked, it.written]).toEqual([["40 9a 1312 0180", "40 9a 2518 00c3"], [[0]]]);
    it.asked = [];
    const over = chip.setBreak(false);
    await vi.advanceTimersByTimeAsync(238);
    expect(it.asked).toEqual([]);
    await vi.advanceTimersByTimeAsync(2);
    await over;
    expect(it.asked).toEqual(["40 9a 1312 b282", "40 9a 2518 00c3"]);
  });
});
