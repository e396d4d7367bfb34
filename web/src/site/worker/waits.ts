// What Python's stacks wait for, by number: `mikas.browser.suspension` suspends a stack until it is over (JSPI).

/** A function of Python; `callPromising` calls it on a stack of its own that can be suspended. */
export interface PythonFunction {
  (...args: unknown[]): unknown;
  copy(): PythonFunction;
  destroy(): void;
  callPromising(): Promise<unknown>;
}

/** What Python says is over, and with what. */
let kept: (number: number, result: unknown) => unknown = () => undefined;
let broken: (number: number, error: unknown) => unknown = () => undefined;

const timers = new Map<number, ReturnType<typeof setTimeout>>();
const turns: (() => unknown)[] = [];
const channel = new MessageChannel();
channel.port1.onmessage = () => turns.shift()?.();

/** Call `then` after all that the browser has waiting: messages, timers, bytes of the port. A timer would wait for 4 ms. */
export function afterOthers(then: () => unknown): void {
  turns.push(then);
  channel.port2.postMessage(null);
}

/** The functions that Python's threads are made of. */
export const waits = {
  answer(whenKept: PythonFunction, whenBroken: PythonFunction): void {
    // Copies: Python drops its own when this returns.
    kept = whenKept.copy();
    broken = whenBroken.copy();
  },

  follow(number: number, promise: Promise<unknown>): void {
    promise.then(
      (result) => kept(number, result),
      (error) => broken(number, error),
    );
  },

  after(number: number, milliseconds: number): void {
    const over = () => {
      timers.delete(number);
      kept(number, false);
    };
    // A longer time overflows the timer's 32 bits, and would be over at once.
    timers.set(number, setTimeout(over, Math.min(milliseconds, 0x7fffffff)));
  },

  cancel(number: number): void {
    clearTimeout(timers.get(number));
    timers.delete(number);
  },

  turn(number: number): void {
    afterOthers(() => kept(number, true));
  },

  start(run: PythonFunction): void {
    const own = run.copy();
    setTimeout(() => void own.callPromising().finally(() => own.destroy()));
  },
};
