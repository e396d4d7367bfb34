// Runs `web_serial_in_browser` in this worker, by Python.
import { SerialHost } from "../../web/src/site/worker/serial";
import { waits } from "../../web/src/site/worker/waits";

const { loadPyodide } = await import(new URL("pyodide/pyodide.mjs", location.href).href);
const python = await loadPyodide();
python.unpackArchive(await (await fetch("program.zip")).arrayBuffer(), "zip", { extractDir: "/program" });
python.registerJsModule("mikas_host", { ...waits, serial: new SerialHost(navigator.serial) });
const run = "import sys; sys.path.insert(0, '/program'); import web_serial_in_browser; web_serial_in_browser.run()";
postMessage(await python.runPythonAsync(run).catch(String));
