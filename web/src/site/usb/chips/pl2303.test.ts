import { describe, expect, it } from "vitest";
import { SEVEN_E_TWO, asksFor, atTheRates, chipOf, refuses, started, unsupported } from "../../../../test/chipRig";
import { pl2303, type ScriptedUsb } from "../../../../test/scriptedUsb";

describe("a PL2303", () => {
  const WAKES = [
    "c0 01 8484 0000",
    "40 01 0404 0000",
    "c0 01 8484 0000",
    "c0 01 8383 0000",
    "c0 01 8484 0000",
    "40 01 0404 0001",
    "c0 01 8484 0000",
    "c0 01 8383 0000",
    "40 01 0000 0001",
    "40 01 0001 0000",
  ];
  const RATE = "21 20 0000 0000";

  it("of type HX is woken, and has no flow control", async () => {
    const [asked, rate] = await started(pl2303());
    expect(asked).toEqual([
      "80 06 0100 0000",
      ...WAKES,
      "40 01 0002 0044",
      "40 01 0008 0000",
      "40 01 0009 0000",
      `${RATE} 80 25 00 00 00 00 08`,
      "c0 01 0080 0000",
      "40 01 0000 0004",
    ]);
    expect(rate).toBe(9600);
  });

  it("of type H ends its start otherwise, and resets the endpoints", async () => {
    const old = pl2303(0x0300, 1, 8);
    const [asked] = await started(old);
    expect(asked[11]).toBe("40 01 0002 0024");
    expect(old.halted).toEqual(["out 2", "in 3"]);
  });

  it("of type HXN has requests of its own", async () => {
    const newest = pl2303(0x0100, 2);
    newest.answers.push(["c0 01", "stall"], ["40 01", "stall"], ["c0 81", [0]]);
    const [asked] = await started(newest, { baudRate: 10_400 });
    expect(asked).toEqual(["80 06 0100 0000", "40 80 0007 0003", `${RATE} a0 28 00 00 00 00 08`, "c0 81 000a 0000", "40 80 000a 001c"]);
  });

  it("is known by a request, where two types share a version", async () => {
    const rate = async (device: ScriptedUsb) => (await started(device, { baudRate: 10_400 }))[0].find((it) => it.startsWith(RATE));
    expect(await rate(pl2303(0x0300, 2))).toBe(`${RATE} 81 44 01 80 00 00 08`); // TA
    expect(await rate(pl2303(0x0500, 2))).toBe(`${RATE} 81 44 01 80 00 00 08`); // TB
    for (const version of [0x0300, 0x0500, 0x0705]) {
      const newest = pl2303(version, 2);
      newest.answers.push(["c0 01 8080", "stall"]);
      expect(await rate(newest)).toBe(`${RATE} a0 28 00 00 00 00 08`);
    }
  });

  it("of an unknown version is refused", async () => {
    await refuses(pl2303(0x0999, 2)).toMatchObject(unsupported);
  });

  it("has the rates of pl2303", async () => {
    const hx = await atTheRates(pl2303, RATE);
    const [low, usual, odd, high] = hx[0].map((it) => it.slice(RATE.length + 1));
    expect([low, usual, odd, high]).toEqual([
      "c0 12 00 00 00 00 08",
      "80 25 00 00 00 00 08",
      "90 08 00 80 00 00 08",
      "00 c2 01 00 00 00 08",
    ]);
    expect(hx[1]).toEqual([4800, 9600, 10417, 115200]);
    const [, rates] = await atTheRates(() => pl2303(0x0500, 2), RATE);
    expect(rates).toEqual([4800, 9600, 10408, 115200]);
    await refuses(pl2303(), { baudRate: 7_000_000 }).toMatchObject(unsupported);
    await refuses(pl2303(), { baudRate: 20 }).toMatchObject(unsupported);
  });

  it("that is a copy may refuse its start", async () => {
    const copy = pl2303(0x0400);
    copy.answers.push(["c0 01", "stall"], ["40 01 0404", "stall"]);
    expect((await started(copy))[0]).toContain(`${RATE} 80 25 00 00 00 00 08`);
  });

  it("has other lines, signals and a break", async () => {
    const [asked] = await started(pl2303(), SEVEN_E_TWO);
    expect(asked).toContain(`${RATE} 80 25 00 00 02 02 07`);
    expect(await asksFor(pl2303(), (chip) => chip.setSignals(true, false))).toEqual(["21 22 0001 0000"]);
    const pulled = await asksFor(pl2303(), async (chip) => (await chip.setBreak(true), await chip.setBreak(false)));
    expect(pulled).toEqual(["21 23 ffff 0000", "21 23 0000 0000"]);
  });

  it("reports errors of the wire beside the bytes", () => {
    const notice = (state: number) => chipOf(pl2303()).readNotice!(Uint8Array.from([0xa1, 0x20, 0, 0, 0, 0, 2, 0, state, 0]));
    expect([notice(0x80), notice(0x14), notice(0x10), notice(0x20), notice(0x40)]).toEqual([
      null,
      "BreakError",
      "FramingError",
      "ParityError",
      "BufferOverrunError",
    ]);
  });
});
