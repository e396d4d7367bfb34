import { describe, expect, it } from "vitest";
import { SEVEN_E_TWO, THE_RATES, asksFor, atTheRates, chipOf, started } from "../../../../test/chipRig";
import { cdcAcm } from "../../../../test/scriptedUsb";

describe("a CDC-ACM device", () => {
  it("takes the line as it is asked", async () => {
    const [asked, rate] = await started(cdcAcm(), { baudRate: 10_400 });
    expect([asked, rate]).toEqual([["21 20 0000 0000 a0 28 00 00 00 00 08"], 10_400]);
    expect(await atTheRates(cdcAcm, "21 20")).toMatchObject([{}, THE_RATES]);
    expect((await started(cdcAcm(), SEVEN_E_TWO))[0]).toEqual(["21 20 0000 0000 80 25 00 00 02 02 07"]);
  });

  it("has signals and a break", async () => {
    expect(await asksFor(cdcAcm(), (chip) => chip.setSignals(true, false))).toEqual(["21 22 0001 0000"]);
    const pulled = await asksFor(cdcAcm(), async (chip) => (await chip.setBreak(true), await chip.setBreak(false)));
    expect(pulled).toEqual(["21 23 ffff 0000", "21 23 0000 0000"]);
  });

  it("reports errors of the wire in its notifications", () => {
    const notice = (...packet: number[]) => chipOf(cdcAcm()).readNotice!(Uint8Array.from(packet));
    expect(notice(0xa1, 0x20, 0, 0, 0, 0, 2, 0, 0x10, 0)).toBe("FramingError");
    expect(notice(0xa1, 0x20, 0, 0, 0, 0, 2, 0, 0x03, 0)).toBeNull();
    expect(notice(0xa1, 0x00, 0, 0, 0, 0, 0, 0)).toBeNull();
  });
});
