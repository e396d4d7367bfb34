// Starts Python: Pyodide, the standard library, the program and its packages, all from one folder of the site.
import type { PyodideAPI, PyodideConfig } from "pyodide";
import { counting } from "./fetching";
import { filesOf } from "./pack";

/** What `python -m tools.site` has packed: the folder, and the size of each of its files, bare and as it travels. */
interface Program {
  folder: string;
  files: Record<string, { bytes: number; compressed: number }>;
  lock: PyodideConfig["lockFileContents"];
}
declare const __PROGRAM__: Program;

type OnProgress = (loaded: number, total: number) => void;

/** The folder of the site, whatever its address: this script is in its folder `assets`. */
const SITE = new URL(/* @vite-ignore */ "..", import.meta.url);

export async function startPython(onProgress: OnProgress): Promise<PyodideAPI> {
  const folder = new URL(`${__PROGRAM__.folder}/`, SITE);
  // Modules are imported: nobody sees them come.
  const fetched = Object.entries(__PROGRAM__.files).filter(([name]) => !name.endsWith(".mjs"));
  const sizes = new Map(fetched.map(([name, size]) => [new URL(name, folder).href, size]));
  const stop = counting(sizes, onProgress);
  try {
    const program = fetch(new URL("program.pack", folder)).then(unpacked);
    // eslint-disable-next-line @typescript-eslint/no-unsafe-assignment -- the package's own module, at an address that only the build knows
    const { loadPyodide }: typeof import("pyodide") = await import(/* @vite-ignore */ new URL("pyodide.mjs", folder).href);
    return await loadPyodide({
      indexURL: folder.href,
      convertNullToNone: true,
      stdLibURL: new URL("stdlib.pack", folder).href,
      lockFileContents: __PROGRAM__.lock,
      packageBaseUrl: folder.href,
      async fsInit(FS, { sitePackages }) {
        const made = new Set<string>();
        for (const { path, content } of await program) {
          const place = `${sitePackages}/${path}`;
          const parent = place.slice(0, place.lastIndexOf("/"));
          if (!made.has(parent)) FS.mkdirTree(parent);
          made.add(parent);
          FS.writeFile(place, content, { canOwn: true });
        }
      },
    });
  } finally {
    stop();
  }
}

async function unpacked(response: Response): Promise<ReturnType<typeof filesOf>> {
  if (!response.ok) throw new Error(`${response.url}: ${response.status}`);
  return filesOf(await response.arrayBuffer());
}
