// The page's drivers (web/src/site/usb) by commands of `node_rig.py`.
import { familyOf } from "../../../web/src/site/usb/identify";
import { UsbSerialPort } from "../../../web/src/site/usb/usbSerialPort";
import { deviceOf, listen, say } from "./usb_over_pipe";

let device;
let port;
let received = [];
let errors = [];
/** Whether nothing is left to be read: the port was closed, or is lost. */
let ended = false;
let wake = () => {};
/** Errors in a row after which a port is taken for one whose stream never ends. */
const MOST = 50;

async function readAll(from) {
  for (let stream = from.readable; stream; stream = from.readable) {
    const reader = stream.getReader();
    try {
      for (let read = await reader.read(); !read.done; read = await reader.read()) {
        received.push(...read.value);
        wake();
      }
      break;
    } catch (error) {
      errors.push(error.name);
      if (errors.length > MOST) break;
      wake();
    } finally {
      reader.releaseLock();
    }
  }
  ended = true;
  wake();
}

const until = async (isDone) => {
  while (!isDone()) await new Promise((woken) => (wake = woken));
};

const COMMANDS = {
  plug({ facts }) {
    device = deviceOf(facts);
    port = new UsbSerialPort(device);
    return familyOf(device);
  },
  async open({ options }) {
    received = [];
    errors = [];
    ended = false;
    await port.open(options);
    void readAll(port);
    return [port.rate, port.granularity];
  },
  async write({ data }) {
    const writer = port.writable.getWriter();
    await writer.write(Uint8Array.from(data)).finally(() => writer.releaseLock());
  },
  async received({ count }) {
    await until(() => received.length >= count);
    return received.splice(0, count);
  },
  async error() {
    await until(() => errors.length);
    return errors.shift();
  },
  pull() {
    device.gone = true;
  },
  /** The browser's event, which may come before or after all that transfers say. */
  unplug: () => port.unplug(),
  async ended() {
    await until(() => ended);
    return errors;
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
