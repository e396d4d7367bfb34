// Whether an answer has come whole, so that the next request may go out without a turn of Python (`Answer` of `mikas.link.base`).

const TERMINATOR = 0x0d;
const ESCAPE = 0x40;
/** What may follow an escape (§2.2). */
const ESCAPED = [0xcd, 0x00];

/** Bytes of the longest echo and response; what is longer is a stream, and no answer. */
const LONGEST = 2200;

/** What is heard since the latest request was written. */
export class Heard {
  private bytes = new Uint8Array(64);
  private length = 0;

  /** A request is written; `chunks` have come before, and spoil its echo. */
  begin(chunks: readonly Uint8Array[]): void {
    this.length = 0;
    for (const chunk of chunks) this.add(chunk);
  }

  add(chunk: Uint8Array): void {
    const end = this.length + chunk.length;
    if (end <= LONGEST) {
      if (end > this.bytes.length) this.bytes = grown(this.bytes, 2 * end);
      this.bytes.set(chunk, this.length);
    }
    this.length = end;
  }

  /**
   * Whether it is `echo`, and then one frame of a right checksum with a body of `length` bytes (§2), and nothing behind it. A frame in another form
   * than the usual one (D3, D4) is for Python to judge.
   */
  isAnswer(echo: Uint8Array, length: number): boolean {
    const { bytes, length: end } = this;
    const begin = echo.length;
    if (end > LONGEST || end < begin + length + 2 || bytes[end - 1] !== TERMINATOR) return false;
    for (let at = 0; at < begin; at += 1) if (bytes[at] !== echo[at]) return false;
    let [sum, count] = [0, 0];
    for (let at = begin; at < end - 1; at += 1) {
      const value = bytes[at]!;
      if (value === TERMINATOR) return false;
      sum += value;
      count += 1;
      if (value !== ESCAPE) continue;
      at += 1;
      if (!ESCAPED.includes(bytes[at]!)) return false;
      sum += bytes[at]!;
    }
    return sum % 256 === 0 && count === length + 1;
  }
}

function grown(bytes: Uint8Array<ArrayBuffer>, length: number): Uint8Array<ArrayBuffer> {
  const whole = new Uint8Array(length);
  whole.set(bytes);
  return whole;
}
