// node … link_in_node.js PROGRAM: the link of the page's Python (`mikas.browser.web_serial`), over the page's drivers, in Pyodide under Node.
// PROGRAM: an archive of mikas, pytest and `link_in_pyodide.py`, which runs.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { UsbSerial } from "../../../web/src/site/usb/usbSerial";
import { followAdapters } from "../../../web/src/site/worker/adapters";
import { waits } from "../../../web/src/site/worker/waits";
import { ask, deviceOf, listen, say } from "./usb_over_pipe";

const [program, pyodide] = process.argv.slice(2);

class Usb extends EventTarget {
  device = null;
  getDevices = async () => (this.device ? [this.device] : []);

  change(kind, device) {
    this.device = kind === "connect" ? device : null;
    device.gone = this.device === null;
    this.dispatchEvent(Object.assign(new Event(kind), { device }));
  }
}

const usb = new Usb();
listen(({ plugged, pulled }) => {
  if (plugged) usb.change("connect", deviceOf(plugged));
  if (pulled && usb.device) usb.change("disconnect", usb.device);
});

/** The other end of the wire, and the hand at the plug. */
const far = { ask: (what, data) => ({ promise: ask(what, { data: data instanceof Uint8Array ? [...data] : data }).then((it) => it.result ?? null) }) };

async function run() {
  const { loadPyodide } = await import(pathToFileURL(pyodide).href);
  const python = await loadPyodide({ convertNullToNone: true });
  python.unpackArchive(new Uint8Array(readFileSync(program)), "zip", { extractDir: "/program" });
  python.registerJsModule("mikas_host", { ...waits, far, serial: followAdapters(new UsbSerial(usb)) });
  python.runPython("import sys; sys.path.insert(0, '/program')");
  return python.pyimport("link_in_pyodide").run.callPromising();
}
run().then(
  (said) => say({ done: said }),
  // Without the stack: it has all of Pyodide in one line.
  ({ name, message }) => say({ failed: name, message }),
);
