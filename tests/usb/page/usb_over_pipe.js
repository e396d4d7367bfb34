// A USB device that `node_rig.py` plays: each request to it is a line of JSON for that process, and each answer one of it.
import { createInterface } from "node:readline";

const asked = new Map();
let last = 0;

export const say = (message) => process.stdout.write(`${JSON.stringify(message)}\n`);

export const ask = (what, more = {}) =>
  new Promise((keep, fail) => {
    last += 1;
    asked.set(last, { keep, fail });
    say({ ask: last, what, ...more });
  });

/** Call `take` with each message that is no answer. */
export function listen(take) {
  process.stdout.on("error", () => process.exit()); // the test has ended
  const lines = createInterface({ input: process.stdin });
  lines.on("close", () => process.exit());
  lines.on("line", (line) => {
    const message = JSON.parse(line);
    if (!("answer" in message)) return take(message);
    const { keep, fail } = asked.get(message.answer);
    asked.delete(message.answer);
    if (message.error) fail(new DOMException(message.error, message.error));
    else keep(message);
  });
}

const bytesOf = (data) => [...new Uint8Array(data.buffer ?? data, data.byteOffset ?? 0, data.byteLength)];
const incoming = ({ status, data }) => ({ status, data: data && new DataView(Uint8Array.from(data).buffer) });

/** A device as WebUSB has it, of the facts of its descriptors. Once `gone` it refuses all, as one that was pulled. */
export const deviceOf = (facts) => ({
  ...facts,
  gone: false,
  opened: false,
  configuration: null,
  async ask(what, more) {
    if (this.gone) throw new DOMException("The device was disconnected.", "NotFoundError");
    return ask(what, more);
  },
  async open() {
    await this.ask("open");
    this.opened = true;
  },
  async close() {
    await this.ask("close");
    this.opened = false;
  },
  async selectConfiguration() {
    this.configuration = this.configurations[0];
  },
  claimInterface(number) {
    return this.ask("claim", { number });
  },
  async controlTransferIn(setup, length) {
    return incoming(await this.ask("control in", { setup, length }));
  },
  controlTransferOut(setup, data) {
    return this.ask("control out", { setup, data: data ? bytesOf(data) : [] });
  },
  async transferIn(endpoint, length) {
    return incoming(await this.ask("in", { endpoint, length }));
  },
  transferOut(endpoint, data) {
    return this.ask("out", { endpoint, data: bytesOf(data) });
  },
  clearHalt(direction, endpoint) {
    return this.ask("clear halt", { direction, endpoint });
  },
});
