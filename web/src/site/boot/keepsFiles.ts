// Whether this browser keeps files for the page, which all its workers see. Over plain http and in some private windows there are none: then
// what is recorded is in the memory of one worker.
import { within } from "../within";

/** ms; the worker says what a browser that hangs does to its files. */
const PATIENCE = 10_000;

export const keepsFiles = async (): Promise<boolean> => {
  try {
    await within(PATIENCE, navigator.storage.getDirectory());
    return true;
  } catch {
    return false;
  }
};
