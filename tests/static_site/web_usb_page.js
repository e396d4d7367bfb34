// A worker that has this site's drivers over WebUSB, and does what a test asks. Bundled by `test_web_usb`.
import { UsbSerial } from "../../web/src/site/usb/usbSerial";

const serial = new UsbSerial(navigator.usb);
let port, writer, heard, errors, ended;

/** Read all that comes, as `serial.ts` does. */
async function listen(opened) {
  const [bytes, names] = [(heard = []), (errors = [])];
  for (let stream = opened.readable; stream; stream = opened.readable) {
    const reader = stream.getReader();
    try {
      for (let read = await reader.read(); !read.done; read = await reader.read()) bytes.push(...read.value);
      return;
    } catch (error) {
      names.push(error.name);
    } finally {
      reader.releaseLock();
    }
  }
}

const PATIENCE = 20_000; // ms

async function until(isTrue) {
  const end = performance.now() + PATIENCE;
  while (!isTrue()) {
    if (performance.now() > end) throw new Error(`never came; only ${heard} and ${errors}`);
    await new Promise((again) => setTimeout(again, 1));
  }
}

const does = {
  ports: async () => (await serial.getPorts()).map((it) => it.getInfo()),
  async open(options) {
    [port] = await serial.getPorts();
    await port.open({ baudRate: 9600, bufferSize: 65536, ...options });
    await port.setSignals({ dataTerminalReady: true, requestToSend: true });
    writer = port.writable.getWriter();
    ended = listen(port);
    return { rate: port.rate, granularity: port.granularity };
  },
  write: async (bytes) => {
    await writer.write(new Uint8Array(bytes));
  },
  /** The bytes since the last call, once that are `count`. */
  async read(count) {
    await until(() => heard.length >= count);
    return heard.splice(0);
  },
  /** The bytes since the last call, once that ends with this one. */
  async readTo(last) {
    await until(() => heard.at(-1) === last);
    return heard.splice(0);
  },
  /** The name of the next error. */
  async error() {
    await until(() => errors.length);
    return errors.shift();
  },
  /** Exchanges one after another; returns how long each took, in ms, and what the last one brought. */
  async exchange({ request, length, times }) {
    const took = [];
    let got = [];
    for (let n = 0; n < times; n++) {
      const begin = performance.now();
      await does.write(request);
      got = await does.read(length);
      took.push(performance.now() - begin);
    }
    return { took, got };
  },
  break: async (low) => {
    await port.setSignals({ break: low });
  },
  async close() {
    writer.releaseLock();
    await port.close();
    await ended;
  },
  isGone: () => port.connected === false,
};

onmessage = async ({ data: { what, given } }) => {
  try {
    postMessage({ done: (await does[what](given)) ?? null });
  } catch (error) {
    postMessage({ failed: `${error.name}: ${error.message}` });
  }
};
