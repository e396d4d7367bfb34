// A worker that runs the program: the line's, which has the cable and writes what is kept, or the reader's. Its name says which.
import { partsOf, type FromWorker, type ToWorker } from "../program/messages";
import { StorageError } from "../storage/errors";
import { opfsFolder } from "../storage/folder";
import { inTime } from "../storage/inTime";
import { Pool } from "../storage/pool";
import { PoolView } from "../storage/view";
import { adaptersBy } from "../usb/access";
import { followAdapters } from "./adapters";
import { startProgram } from "./program";
import { startPython } from "./python";

const [role, access] = partsOf(self.name);
const post = (message: FromWorker, transfer: Transferable[] = []): void => self.postMessage(message, { transfer });

async function begin(): Promise<void> {
  const progress = (loaded: number, total: number) => post({ kind: "progress", loaded, total, stage: "program" });
  const kept = inTime(keptFiles());
  // A reader that can read nothing is not worth the start of Python.
  if (role === "reader") await kept;
  const [python, files] = await Promise.all([startPython(progress), kept]);
  const serial = followAdapters(role === "line" ? adaptersBy(access) : undefined);
  const take = await startProgram(python, role, files, post, { serial });
  closeTheDoors();
  // One after the other: a request must not overtake the message before it while the view is refreshed.
  let before = Promise.resolve();
  self.onmessage = ({ data }: MessageEvent<ToWorker>) => {
    if (data.kind === "release") return serial.release(data.gone);
    if (!(files instanceof PoolView)) return take(data);
    const seen = before.then(() => (data.kind === "request" ? files.refresh() : undefined));
    before = seen.catch(() => {}).then(() => take(data)); // a view that can't be refreshed still answers, of what it saw
  };
  post({ kind: "ready" });
}

/** Null: this browser keeps nothing here (a private window), so all is in memory. */
async function keptFiles(): Promise<Pool | PoolView | null> {
  if (!navigator.storage?.getDirectory) return null;
  const folder = await opfsFolder().catch(() => null);
  if (folder === null) return null;
  return role === "line" ? Pool.open(folder) : PoolView.open(folder);
}

/** All is loaded. From here on nothing in this worker can reach the network, whatever its code does. */
function closeTheDoors(): void {
  for (const door of [
    "fetch",
    "XMLHttpRequest",
    "WebSocket",
    "WebSocketStream",
    "WebTransport",
    "EventSource",
    "Worker",
    "importScripts",
  ]) {
    Object.defineProperty(self, door, { value: undefined, configurable: false, writable: false });
  }
}

begin().catch((error: unknown) => {
  const why = error instanceof StorageError ? error.reason : undefined;
  post({ kind: "broken", message: error instanceof Error ? error.message : String(error), why });
});
