// Runs `web_serial_in_browser` in this worker, by Python: over Web Serial, or over WebUSB as on a phone.
import { UsbSerial } from "../../web/src/site/usb/usbSerial";
import { SerialHost } from "../../web/src/site/worker/serial";
import { waits } from "../../web/src/site/worker/waits";

const { loadPyodide } = await import(new URL("pyodide/pyodide.mjs", location.href).href);
const python = await loadPyodide();
python.unpackArchive(await (await fetch("program.zip")).arrayBuffer(), "zip", { extractDir: "/program" });
const isUsb = location.search === "?webusb";
const serial = new SerialHost(isUsb ? new UsbSerial(navigator.usb) : navigator.serial);
python.registerJsModule("mikas_host", { ...waits, serial });
const run = `import os, sys
sys.path.insert(0, "/program")
os.environ["SCHEME"] = "${isUsb ? "webusb" : "webserial"}"
import web_serial_in_browser
web_serial_in_browser.run()`;
postMessage(await python.runPythonAsync(run).catch(String));
