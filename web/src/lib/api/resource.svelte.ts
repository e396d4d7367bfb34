// Data of the program that belong to something: a unit, a recording, a plan. They are asked for while a component needs them: at once, and again
// when the key changes. Data of another key are dropped at once, so nothing of one unit or recording is shown under another.
import { untrack } from "svelte";
import { ApiRequest } from "./request.svelte";

/** ms after which a request that a screen can't do without is repeated, one at a time; then every 8 s. */
const DELAYS = [1000, 2000, 4000, 8000];

interface Options<K, T> {
  /** What the data belong to, as data that JSON can hold; null: there is nothing to ask for now, and what is there stays. */
  of: () => K | null;
  ask: (key: K, signal: AbortSignal) => Promise<T>;
  /** Data of the key that is other when they have to be asked for again; those that are there stay until the next have come. */
  again?: () => unknown;
  /** Data of another key stay, too, until the next have come. */
  keeps?: true;
  /** ms between two questions, while the page is visible; 0: it is asked once. */
  every?: () => number;
  /** ms for which key and `again` must stay the same before it is asked. */
  wait?: number;
  /** A failed question is repeated. */
  insists?: true;
  /** Data that have come are not asked for again when another component needs them. */
  once?: true;
}

export class Resource<K, T> extends ApiRequest<T> {
  private readonly due = $derived.by(() => JSON.stringify([this.options.of(), this.options.again?.()]));
  private readonly every = $derived.by(() => this.options.every?.() ?? 0);
  /** The key of the data, or of those that are being asked for. */
  private key = "";
  /** What has come. */
  private come = "";
  private timer: ReturnType<typeof setTimeout> | undefined;
  private stop = new AbortController();

  constructor(private readonly options: Options<K, T>) {
    super();
  }

  /** For a component while it is initialised: ask as long as it lives. */
  need(): this {
    $effect(() => {
      if (this.due) untrack(() => this.turnTo(this.options.of()));
      return () => {
        clearTimeout(this.timer);
        this.stop.abort();
      };
    });
    $effect(() => {
      if (this.every === 0) return;
      const timer = setInterval(() => document.hidden || this.busy || void this.reload(), this.every);
      return () => clearInterval(timer);
    });
    return this;
  }

  /** Ask again, now. Undefined if it failed (then `error` is set), or if there is nothing to ask for. */
  async reload(): Promise<T | undefined> {
    const key = this.options.of();
    if (key === null) return undefined;
    this.belongTo(key);
    return this.load(key, 0);
  }

  private turnTo(key: K | null): void {
    if (key === null) return this.skip();
    const due = JSON.stringify([key, this.options.again?.()]);
    if (this.options.once && due === this.come) return;
    this.belongTo(key);
    if (this.options.wait) this.timer = setTimeout(() => void this.load(key, 0), this.options.wait);
    else void this.load(key, 0);
  }

  private belongTo(key: K): void {
    const text = JSON.stringify(key);
    if (text !== this.key && !this.options.keeps) this.reset();
    this.key = text;
  }

  private async load(key: K, tries: number): Promise<T | undefined> {
    const { options } = this;
    const { signal } = (this.stop = new AbortController());
    const due = JSON.stringify([key, options.again?.()]);
    const value = await this.run(() => options.ask(key, signal));
    if (value !== undefined) this.come = due;
    else if (this.error && options.insists && !signal.aborted) {
      this.timer = setTimeout(() => void this.load(key, tries + 1), DELAYS[Math.min(tries, DELAYS.length - 1)]);
    }
    return value;
  }
}
