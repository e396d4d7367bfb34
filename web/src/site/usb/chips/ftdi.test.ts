import { describe, expect, it } from "vitest";
import { EIGHT_N_ONE, SEVEN_E_TWO, asksFor, atTheRates, chipOf, refuses, started, unsupported } from "../../../../test/chipRig";
import { ftdi } from "../../../../test/scriptedUsb";

describe("an FTDI", () => {
  it("is reset, and hands a message over at its end, without a packet for each byte", async () => {
    const chip = chipOf(ftdi());
    expect(chip.granularity).toBe(0.016);
    const [asked, rate] = await started(ftdi());
    expect(asked).toEqual([
      "40 00 0000 0000",
      "40 03 4138 0000",
      "40 04 0008 0000",
      "40 02 0000 0000",
      "40 06 010d 0000",
      "40 09 0010 0000",
    ]);
    expect(rate).toBe(9600);
    await chip.start(EIGHT_N_ONE);
    expect(chip.granularity).toBe(0.016);
  });

  it("has its latency timer lowered where it knows no event character", async () => {
    const copy = ftdi();
    copy.answers = [["40 06", "stall"]];
    const chip = chipOf(copy);
    await chip.start(EIGHT_N_ONE);
    expect([chip.granularity, copy.asked.at(-1)]).toEqual([0.001, "40 09 0001 0000"]);
  });

  it("has its latency timer lowered where it takes the event character and waits behind it", async () => {
    const copy = ftdi();
    const chip = chipOf(copy);
    await chip.start(EIGHT_N_ONE);
    copy.asked = [];
    const waits = [1, 0x60, 0x61, 0x0d, 0x54];
    const others = [
      [1, 0x60],
      [1, 0x60, 0x0d],
      [1, 0x60, 0x54, 0xac, 0x0d],
      [1, 0x60, 0x0d, ...Array.from({ length: 61 }, () => 0)],
    ];
    for (const packet of [...others, waits, waits, ...others, waits, waits]) chip.unpack(Uint8Array.from(packet));
    expect(copy.asked).toEqual([]);
    for (const packet of [waits, ...others, waits, waits, waits]) chip.unpack(Uint8Array.from(packet));
    expect(copy.asked).toEqual(["40 09 0001 0000"]);
    await chip.start(EIGHT_N_ONE);
    expect(copy.asked.at(-1)).toBe("40 09 0010 0000");
  });

  it("has the divisors of ftdi_sio", async () => {
    const rates = [4800, 9600, 10399, 115385];
    expect(await atTheRates(ftdi, "40 03")).toEqual([["40 03 0271 0000", "40 03 4138 0000", "40 03 4120 0000", "40 03 001a 0000"], rates]);
    // The first chips have fewer fractions.
    expect(await atTheRates(() => ftdi(0x0200), "40 03")).toEqual([
      ["40 03 0271 0000", "40 03 4138 0000", "40 03 4120 0000", "40 03 001a 0000"],
      rates,
    ]);
    // FT-X: the port's number; the fast ones: 120 MHz.
    expect((await atTheRates(() => ftdi(0x1000), "40 03"))[0]).toEqual([
      "40 03 0271 0001",
      "40 03 4138 0001",
      "40 03 4120 0001",
      "40 03 001a 0001",
    ]);
    expect(await atTheRates(() => ftdi(0x0900, 512), "40 03")).toEqual([
      ["40 03 09c4 0201", "40 03 04e2 0201", "40 03 c481 0301", "40 03 c068 0201"],
      [4800, 9600, 10400, 115246],
    ]);
  });

  it("has the fractions that its kind can", async () => {
    const baud = async (version: number, baudRate: number) => (await started(ftdi(version), { baudRate }))[0][1];
    // 24 MHz / 14000 = 1714.3 eighths: 214 2/8; 13000: 1846 = 230 6/8, which an AM makes 230 4/8; 12990: 1847.6 = 231.
    expect(await baud(0x0600, 14_000)).toBe("40 03 80d6 0000");
    expect(await baud(0x0600, 13_000)).toBe("40 03 80e6 0001");
    expect(await baud(0x1000, 13_000)).toBe("40 03 80e6 0101");
    expect(await baud(0x0200, 13_000)).toBe("40 03 40e6 0000");
    expect(await baud(0x0200, 12_995)).toBe("40 03 00e7 0000");
    expect(await baud(0x0600, 3_000_000)).toBe("40 03 0000 0000");
    expect(await baud(0x0600, 2_000_000)).toBe("40 03 0001 0000");
    await refuses(ftdi(), { baudRate: 2_500_000 }).toMatchObject(unsupported);
    await refuses(ftdi(), { baudRate: 100 }).toMatchObject(unsupported);
  });

  it("has its own latency where the timer can't be set", async () => {
    const am = ftdi(0x0200);
    const chip = chipOf(am);
    await chip.start(EIGHT_N_ONE);
    expect([chip.granularity, am.asked.some((it) => it.startsWith("40 09"))]).toEqual([0.016, false]);
    const copy = ftdi();
    copy.answers = [["40 09", "stall"]];
    copy.answers.push(["40 06", "stall"]);
    const other = chipOf(copy);
    await other.start(EIGHT_N_ONE);
    expect(other.granularity).toBe(0.016);
  });

  it("of the kind BM without a serial number is known by its timer", async () => {
    const bm = ftdi(0x0200);
    bm.serialNumber = null;
    const [asked] = await started(bm, { baudRate: 13_000 });
    expect([asked[0], asked[2]]).toEqual(["c0 0a 0000 0000", "40 03 80e6 0001"]);
  });

  it("of an unknown version is refused", async () => {
    await refuses(ftdi(0x4200)).toMatchObject(unsupported);
  });

  it("has other lines, signals and a break", async () => {
    const [asked] = await started(ftdi(), SEVEN_E_TWO);
    expect(asked[2]).toBe("40 04 1207 0000");
    await refuses(ftdi(), { dataBits: 6 }).toMatchObject(unsupported);
    expect(await asksFor(ftdi(), (chip) => chip.setSignals(true, false))).toEqual(["40 01 0101 0000", "40 01 0200 0000"]);
    const pulled = await asksFor(ftdi(0x1000), async (chip) => (await chip.setBreak(true), await chip.setBreak(false)));
    expect(pulled).toEqual(["40 04 4008 0001", "40 04 0008 0001"]);
  });

  it("has two bytes of status at the head of each packet", () => {
    const chip = chipOf(ftdi());
    const full = [1, 0x60, ...Array.from({ length: 62 }, (_, i) => i)];
    expect([...chip.unpack(Uint8Array.from(full)).bytes]).toEqual(full.slice(2));
    const { bytes } = chip.unpack(Uint8Array.from([...full, 1, 0x60, 200, 201]));
    expect([...bytes]).toEqual([...full.slice(2), 200, 201]);
    expect(chip.unpack(Uint8Array.from([1, 0x60])).bytes).toHaveLength(0);
  });

  it("reports errors of the wire with the bytes, not without", () => {
    const error = (...packet: number[]) => chipOf(ftdi()).unpack(Uint8Array.from(packet)).error;
    expect([error(1, 0x78, 0), error(1, 0x68, 7), error(1, 0x64, 7), error(1, 0x62, 7), error(1, 0x60, 7)]).toEqual([
      "BreakError",
      "FramingError",
      "ParityError",
      "BufferOverrunError",
      null,
    ]);
    expect(error(1, 0x7e)).toBeNull();
  });
});
