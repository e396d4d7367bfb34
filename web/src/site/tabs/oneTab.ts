// One tab has the program: two could neither share the cable nor the kept files. A Web Lock says which. Another tab waits for it, or asks the
// first over a channel to leave it; that one refuses while it samples or records.
import type { Refusal } from "../boot/start.svelte";
import { Deferred } from "../deferred";
import { within } from "../within";

const NAME = "mikas.program";
/** ms in which a tab answers; its page has time even while it draws. */
const ANSWER_MS = 4000;
/** ms in which the browser says whether the lock is free. */
const LOCK_MS = 20_000;

type Message = { kind: "leave"; from: string } | { kind: "left"; to: string } | { kind: "refused"; to: string; refusal: Refusal };

type Channel = Pick<BroadcastChannel, "postMessage" | "onmessage">;

/** What a tab does with the program. */
export interface Owner {
  /** Why it can't be left now; null: it can. */
  refusal(): Refusal | null;
  /** End the program. Another tab has it then. */
  leave(): void;
  /** The program is gone: begin as a new tab. */
  restart(): void;
}

export class OneTab {
  private readonly id = crypto.randomUUID();
  private readonly waiting = new AbortController();
  private owner: Owner | null = null;
  private owns = false;
  private answered: ((refusal: Refusal | null) => void) | null = null;
  /** Kept when this tab has the program. */
  private readonly mine = new Deferred<void>();

  constructor(
    private readonly locks: LockManager,
    private readonly channel: Channel,
  ) {
    channel.onmessage = ({ data }: MessageEvent<Message>) => this.receive(data);
  }

  /** Wait until this tab has the program; `elsewhere` is called if another one has it. */
  async become(owner: Owner, elsewhere: () => void): Promise<void> {
    this.owner = owner;
    if (!(await this.tryNow())) {
      elsewhere();
      this.hold({ signal: this.waiting.signal });
    }
    await this.mine.promise;
  }

  /** Ask the tab that has the program to leave it to this one. Null: it has. */
  async ask(): Promise<Refusal | null> {
    const answer = new Promise<Refusal | null>((resolve) => (this.answered = resolve));
    const timer = setTimeout(() => this.answered?.("silent"), ANSWER_MS);
    this.send({ kind: "leave", from: this.id });
    const refusal = await answer;
    clearTimeout(timer);
    this.answered = null;
    if (refusal === null) {
      // Others may wait for it, too.
      this.waiting.abort();
      this.hold({ steal: true });
    }
    return refusal;
  }

  private tryNow(): Promise<boolean> {
    return within(LOCK_MS, new Promise((decided) => this.hold({ ifAvailable: true }, decided)));
  }

  /** Hold the lock until it is taken away, or the tab is closed. */
  private hold(options: LockOptions, decided?: (mine: boolean) => void): void {
    const held = this.locks.request(NAME, options, (lock) => {
      decided?.(lock !== null);
      if (lock === null) return;
      this.owns = true;
      this.mine.keep();
      return new Promise<never>(() => undefined);
    });
    held.catch(() => {
      if (!options.signal?.aborted) this.restart();
    });
  }

  private restart(): void {
    if (this.owns) this.owner?.restart();
    this.owns = false;
  }

  private receive(message: Message): void {
    if (message.kind === "leave") this.asked(message.from);
    else if (message.to === this.id) this.answered?.(message.kind === "left" ? null : message.refusal);
  }

  private asked(by: string): void {
    if (!this.owns || this.owner === null) return;
    const refusal = this.owner.refusal();
    if (refusal !== null) return this.send({ kind: "refused", to: by, refusal });
    this.owner.leave();
    this.send({ kind: "left", to: by });
    // The other one takes the lock. If it was closed meanwhile, this tab goes on.
    setTimeout(() => this.restart(), ANSWER_MS);
  }

  private send(message: Message): void {
    this.channel.postMessage(message);
  }
}
