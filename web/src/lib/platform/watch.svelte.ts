// For what is outside of the page's data: canvas, timers, requests that change something.
import { untrack } from "svelte";

/**
 * For a component while it is initialised: call `act` now and after each change of what `read` returns, and what it returned in the end. What
 * `act` reads is not followed.
 */
export function watch<T>(read: () => T, act: (now: T) => unknown): void {
  $effect(() => {
    const now = read();
    const end: unknown = untrack(() => act(now));
    return end instanceof Function ? () => void Reflect.apply(end, undefined, []) : undefined;
  });
}
