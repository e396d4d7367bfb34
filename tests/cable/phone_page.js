// What the page in the guest does with each adapter that it may use; bundled by `phone_in_guest`.
import { UsbSerial } from "../../web/src/site/usb/usbSerial";

const say = (it) => fetch("say", { method: "POST", body: JSON.stringify(it) });
const REQUEST = [0x61, 0x29, 0x76, 0x0d]; // FREQ
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
    result.failed = `${error.name}: ${error.message}`;
  }
  return result;
}

const ports = await new UsbSerial(navigator.usb).getPorts();
document.body.textContent = `${ports.length} adapters`;
for (const port of ports) {
  const result = await tryOut(port);
  document.body.append(document.createElement("br"), JSON.stringify(result));
  await say(result);
}
await say({ end: true });
