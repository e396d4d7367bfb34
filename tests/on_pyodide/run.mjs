// node --experimental-wasm-jspi run.mjs ROOT PROGRAM PACKAGES CACHE ARGUMENT…: pytest in Pyodide, over the program as the site packs it.
// ROOT: this repository; PROGRAM: the folder program-… of the built site; PACKAGES: where pytest is installed; CACHE: for its bytecode.
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [root, program, packages, cache, ...options] = process.argv.slice(2);
const TOOLS = [
  "_pytest", "httpx", "idna", "iniconfig", "packaging", "pluggy", "py.py", "pygments", "pytest", "websockets",
];

const LONGEST = 90_000; // ms of one test

const moduleAt = (...path) => import(pathToFileURL(join(...path)).href);
const { loadPyodide } = await moduleAt(program, "pyodide.mjs");
const { waits } = await moduleAt(root, "web/src/site/worker/waits.ts");
const { filesOf, inflated } = await moduleAt(root, "web/src/site/worker/pack.ts");
const pyodide = join(root, "web/node_modules/pyodide");

const bytesOf = (name) => inflated(new Response(readFileSync(join(program, name)))).arrayBuffer();
const packed = filesOf(await bytesOf("program.pack"));
const library = join(mkdtempSync(join(tmpdir(), "mikas-")), "stdlib.zip");
writeFileSync(library, new Uint8Array(await bytesOf("stdlib.pack")));
const python = await loadPyodide({
  indexURL: program,
  convertNullToNone: true,
  stdLibURL: library,
  lockFileContents: { info: JSON.parse(readFileSync(join(pyodide, "pyodide-lock.json"), "utf8")).info, packages: {} },
  env: { HOME: "/home/pyodide", PYTEST_DISABLE_PLUGIN_AUTOLOAD: "1", NO_COLOR: "1" },
  fsInit(FS, { sitePackages }) {
    for (const { path, content } of packed) {
      const place = `${sitePackages}/${path}`;
      FS.mkdirTree(place.slice(0, place.lastIndexOf("/")));
      FS.writeFile(place, content, { canOwn: true });
    }
  },
});

const { FS } = python;
function mount(place, folder) {
  FS.mkdirTree(place);
  FS.mount(FS.filesystems.NODEFS, { root: folder }, place);
}
mount("/repository", root);
mount("/cache", cache);
for (const name of TOOLS) {
  if (name.endsWith(".py")) FS.writeFile(`/tools/${name}`, readFileSync(join(packages, name)));
  else mount(`/tools/${name}`, join(packages, name));
}
FS.writeFile("/tools/stdlib.zip", readFileSync(join(pyodide, "python_stdlib.zip")));

python.runPython(`
import sys
sys.pycache_prefix = "/cache"
sys.path += ["/tools", "/repository/tests"]
`);
const inside = python.pyimport("on_pyodide.inside");
inside.prepare(waits, python.pyimport("pyodide.ffi.run_sync"));

let hanging;
/** Ends all if the test of this name takes too long. */
function watch(name) {
  clearTimeout(hanging);
  hanging = setTimeout(() => {
    console.log(`\nIt hangs: ${name}`);
    process.exit(1);
  }, LONGEST);
}
FS.chdir("/repository");
process.exit(await inside.run.callPromising(watch, options));
