// A worker that runs the program: the line's, or the reader's.
import type { FromWorker } from "../program/messages";
import { startPython } from "./python";

const tell = (message: FromWorker): void => self.postMessage(message);

try {
  const python = await startPython((loaded, total) => tell({ kind: "progress", loaded, total, stage: "program" }));
  python.pyimport("mikas.dashboard.app");
  tell({ kind: "ready" });
} catch (error) {
  tell({ kind: "broken", message: String(error) });
}
