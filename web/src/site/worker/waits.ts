// What a Python thread of the site waits for: `mikas.browser.green_threads` suspends its stack until the promise is kept (JSPI).
// Promises are fields: Pyodide makes an asyncio future of one that a function returns, in the event loop of the caller.

/** Kept with true by `wake()`, with false after `milliseconds`; without them, there is no limit. */
export class Wait {
  readonly promise: Promise<boolean>;
  private keep!: (woken: boolean) => void;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(milliseconds?: number | null) {
    this.promise = new Promise((resolve) => (this.keep = resolve));
    // A longer time overflows the timer's 32 bits, and would be over at once.
    if (milliseconds != null) this.timer = setTimeout(() => this.keep(false), Math.min(milliseconds, 0x7fffffff));
  }

  wake(): void {
    clearTimeout(this.timer);
    this.keep(true);
  }
}

const turns = new MessageChannel();
const waiting: Wait[] = [];
turns.port1.onmessage = () => waiting.shift()?.wake();

/** Kept after all that the browser has waiting: messages, timers, bytes of the port. A timer would wait for 4 ms. */
function turn(): Wait {
  const wait = new Wait();
  waiting.push(wait);
  turns.port2.postMessage(null);
  return wait;
}

/** A Python function; `callPromising` calls it on a stack of its own that can be suspended. */
export interface PythonFunction {
  copy(): PythonFunction;
  destroy(): void;
  callPromising(): Promise<unknown>;
}

function start(run: PythonFunction): void {
  const kept = run.copy(); // Python drops its own when this returns
  setTimeout(() => void kept.callPromising().finally(() => kept.destroy()));
}

/** The functions that Python's threads are made of. */
export const waits = { wait: (milliseconds?: number | null) => new Wait(milliseconds), turn, start };
