import { expect, test } from "vitest";
import { COPY, decode, encode, LONGEST_PATH, VERSION } from "./header";

const header = { generation: 2 ** 40 + 3, id: 7, mtime: 1_700_000_000_123.5, path: "записи/а (2).pcapng" };

test("a header is read as it was written", () => {
  expect(decode(encode(header))).toEqual(header);
  const longest = { ...header, path: "я".repeat(LONGEST_PATH / 2) };
  expect(decode(encode(longest))).toEqual(longest);
});

test("a header with any other byte, or cut off anywhere, does not count", () => {
  const bytes = encode(header);
  const other = encode({ ...header, generation: 4, path: "x" });
  for (let at = 0; at < 42 + new TextEncoder().encode(header.path).length; at++) {
    const damaged = bytes.slice();
    damaged[at]! ^= 1;
    // A version of 0, or a later one, is another format.
    expect([null, "newer"], `byte ${at}`).toContain(decode(damaged));
    const torn = other.slice();
    torn.set(bytes.subarray(0, at));
    if (at > 0 && decode(torn) !== null) expect([header, decode(other)]).toContainEqual(decode(torn));
    expect(decode(bytes.subarray(0, at))).toBe(null);
  }
  expect(decode(new Uint8Array(COPY))).toBe(null);
});

test("a later format is known as one, whatever it holds", () => {
  const bytes = encode(header);
  bytes[8] = VERSION + 1;
  expect(decode(bytes)).toBe("newer");
});
