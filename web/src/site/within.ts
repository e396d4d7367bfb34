// Waits for what the browser may never settle: a driver, a disk or a profile that hangs.

/** The name of the error of a wait that was too long. */
export const HANGS = "TimeoutError";

/** As `promise`, but broken with `HANGS` if that is not settled in so many milliseconds. */
export function within<T>(milliseconds: number, promise: Promise<T>, message = "The browser does not answer."): Promise<T> {
  return new Promise((keep, fail) => {
    const timer = setTimeout(() => fail(new DOMException(message, HANGS)), milliseconds);
    promise.then(keep, fail).finally(() => clearTimeout(timer));
  });
}
