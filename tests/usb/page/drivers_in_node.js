// The page's drivers (web/src/site/usb) by commands of `node_rig.py`.
import { familyOf } from "../../../web/src/site/usb/identify";
import { UsbSerialPort } from "../../../web/src/site/usb/usbSerialPort";
import { deviceOf, listen, say } from "./usb_over_pipe";

let port;
let received = [];
let errors = [];
let wake = () => {};

async function readAll(from) {
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
    void readAll(port);
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

listen(async (message) => {
  try {
    say({ done: (await COMMANDS[message.command](message)) ?? null });
  } catch (error) {
    say({ failed: error.name, message: error.message });
  }
});
say({ done: "ready" });
