// The page's drivers (web/src/site/usb) in Node, over a USB device that `drivers_rig.py` plays: a line of JSON for each request to it, and for
// each answer. What the test wants comes as lines as well.
import { createInterface } from "node:readline";
import { familyOf } from "../../web/src/site/usb/identify";
import { UsbSerialPort } from "../../web/src/site/usb/usbSerialPort";

const say = (message) => process.stdout.write(`${JSON.stringify(message)}\n`);
const asked = new Map();
let last = 0;

const ask = (what, more = {}) =>
  new Promise((keep, fail) => {
    last += 1;
    asked.set(last, { keep, fail });
    say({ ask: last, what, ...more });
  });

const bytesOf = (data) => [...new Uint8Array(data.buffer ?? data, data.byteOffset ?? 0, data.byteLength)];
const incoming = ({ status, data }) => ({ status, data: data && new DataView(Uint8Array.from(data).buffer) });

/** As WebUSB has it, of the facts of a device's descriptors. */
const deviceOf = (facts) => ({
  ...facts,
  opened: false,
  configuration: null,
  async open() {
    this.opened = true;
  },
  async close() {
    this.opened = false;
    await ask("close");
  },
  async selectConfiguration() {
    this.configuration = this.configurations[0];
  },
  async claimInterface() {},
  controlTransferIn: async (setup, length) => incoming(await ask("control in", { setup, length })),
  controlTransferOut: (setup, data) => ask("control out", { setup, data: data ? bytesOf(data) : [] }),
  transferIn: async (endpoint, length) => incoming(await ask("in", { endpoint, length })),
  transferOut: (endpoint, data) => ask("out", { endpoint, data: bytesOf(data) }),
  clearHalt: (direction, endpoint) => ask("clear halt", { direction, endpoint }),
});

let port;
let received = [];
let errors = [];
let wake = () => {};

async function listen(from) {
  for (let stream = from.readable; stream; stream = from.readable) {
    const reader = stream.getReader();
    try {
      for (let read = await reader.read(); !read.done; read = await reader.read()) {
        received.push(...read.value);
        wake();
      }
      return;
    } catch (error) {
      errors.push(error.name);
      wake();
    } finally {
      reader.releaseLock();
    }
  }
}

const COMMANDS = {
  plug({ facts }) {
    const device = deviceOf(facts);
    port = new UsbSerialPort(device);
    return familyOf(device);
  },
  async open({ options }) {
    received = [];
    errors = [];
    await port.open(options);
    void listen(port);
    return [port.rate, port.granularity];
  },
  async write({ data }) {
    const writer = port.writable.getWriter();
    await writer.write(Uint8Array.from(data)).finally(() => writer.releaseLock());
  },
  async received({ count }) {
    while (received.length < count) await new Promise((woken) => (wake = woken));
    return received.splice(0, count);
  },
  async error() {
    while (!errors.length) await new Promise((woken) => (wake = woken));
    return errors.shift();
  },
  signals: ({ signals }) => port.setSignals(signals),
  close: () => port.close(),
};

process.stdout.on("error", () => process.exit()); // the test has ended
createInterface({ input: process.stdin }).on("line", async (line) => {
  const message = JSON.parse(line);
  if ("answer" in message) {
    const { keep, fail } = asked.get(message.answer);
    asked.delete(message.answer);
    if (message.error) fail(new DOMException(message.error, message.error));
    else keep(message);
    return;
  }
  try {
    say({ done: (await COMMANDS[message.command](message)) ?? null });
  } catch (error) {
    say({ failed: error.name, message: error.message });
  }
});
say({ done: "ready" });
