// What the page in the guest does with each adapter that it may use; bundled by `phone_in_guest`. What it finds stands on it, in the words that
// the program has for it, and goes to `phone_serving.py`.
import { UsbSerial } from "../../web/src/site/usb/usbSerial";

const ask = async (path, it) => (await fetch(path, { method: "POST", body: JSON.stringify(it) })).json();
const REQUEST = [0x61, 0x29, 0x76, 0x0d]; // FREQ; a step is 40 rpm
const PATIENCE = 60_000; // ms; the guest is slow

const within = (promise) =>
  Promise.race([promise, new Promise((_, fail) => setTimeout(() => fail(new Error("too late")), PATIENCE))]);

/** Send the request; return what comes, as many bytes as echo and answer have. */
async function exchange(port) {
  const writer = port.writable.getWriter();
  await writer.write(new Uint8Array(REQUEST));
  writer.releaseLock();
  const reader = port.readable.getReader();
  const got = [];
  try {
    while (got.length < REQUEST.length + 3) got.push(...(await reader.read()).value);
  } finally {
    reader.releaseLock();
  }
  return got;
}

async function tryOut(port) {
  const result = { ids: port.getInfo() };
  try {
    await within(port.open({ baudRate: 9600, bufferSize: 65536 }));
    await port.setSignals({ dataTerminalReady: true, requestToSend: false });
    result.got = await within(exchange(port));
    await port.setSignals({ break: true });
    await port.setSignals({ break: false });
    await port.close();
    await within(port.open({ baudRate: 9600, bufferSize: 65536 }));
    result.again = await within(exchange(port));
    await port.close();
  } catch (error) {
    result.failed = [error.name, error.message];
  }
  return result;
}

/** What stands on the page of an adapter, in both languages. */
function shown({ got = [] }, { chip, en, ru }) {
  const line = [...got.slice(0, REQUEST.length)].map((byte) => byte.toString(16).padStart(2, "0")).join(" ");
  const read = (said, name, unit) => said || `${line} → ${name}: ${got[REQUEST.length] * 40} ${unit}`;
  return { chip, en: read(en, "Engine speed", "rpm"), ru: read(ru, "Обороты", "об/мин") };
}

const adapters = [];
/** Draw the page in this language; called by `phone_serving.py` for its pictures. */
globalThis.draw = (language) => {
  document.body.replaceChildren(
    ...adapters.map(({ chip, [language]: words }) => {
      const each = document.createElement("p");
      each.append(Object.assign(document.createElement("b"), { textContent: chip }), document.createElement("br"), words);
      return each;
    }),
  );
};

const ports = await new UsbSerial(navigator.usb).getPorts();
for (const port of ports) {
  const result = await tryOut(port);
  adapters.push(shown(result, await ask("say", result)));
  draw("en");
}
await ask("say", { end: true });
