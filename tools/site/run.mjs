// node run.mjs '{"pyodide", "options", "folder", "call", "arguments"}': calls a function of in_pyodide.py, with `folder` at /folder.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const { pyodide, options, folder, call, arguments: given } = JSON.parse(process.argv[2]);
try {
  const { loadPyodide } = await import(pathToFileURL(resolve(pyodide, "pyodide.mjs")).href);
  const python = await loadPyodide({ indexURL: resolve(pyodide), ...options });
  python.FS.mkdir("/folder");
  python.FS.mount(python.FS.filesystems.NODEFS, { root: resolve(folder) }, "/folder");
  python.runPython(readFileSync(new URL("in_pyodide.py", import.meta.url), "utf8"));
  python.globals.get(call)(...given);
} catch (error) {
  console.error(error.message); // without the line of Pyodide's script, which is all of it
  process.exitCode = 1;
}
