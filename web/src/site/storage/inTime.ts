// The start waits for the browser's files, and for nothing that never comes.
import { HANGS, within } from "../within";
import { StorageError } from "./errors";

/** ms; to open hundreds of files takes a second. */
const PATIENCE = 60_000;

/** As `opening`, but broken with a `StorageError` if the browser neither opens nor refuses. */
export const inTime = <T>(opening: Promise<T>): Promise<T> =>
  within(PATIENCE, opening).catch((error: unknown) => {
    throw error instanceof DOMException && error.name === HANGS ? new StorageError("hangs", error) : error;
  });
