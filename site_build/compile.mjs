// node compile.mjs PYODIDE FOLDER LEVEL: compiles FOLDER/sources.zip into FOLDER/bytecode.zip.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [pyodide, folder, level] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(resolve(pyodide, "pyodide.mjs")).href);
// Columns of the lines would be an eighth of all.
const python = await loadPyodide({
  indexURL: resolve(pyodide),
  args: ["-X", "no_debug_ranges"],
});
python.FS.mkdir("/folder");
python.FS.mount(python.FS.filesystems.NODEFS, { root: resolve(folder) }, "/folder");
python.runPython(readFileSync(new URL("in_pyodide.py", import.meta.url), "utf8"));
const compileArchive = python.globals.get("compile_archive");
compileArchive("/folder/sources.zip", "/folder/bytecode.zip", Number(level));
