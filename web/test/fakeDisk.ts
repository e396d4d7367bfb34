// A folder in memory for the tests: it gets full, and it remembers every step, to be cut off anywhere.

import { StorageError } from "../src/site/storage/errors";
import type { Folder, Handle, Holding, View } from "../src/site/storage/folder";

type Step =
  | { kind: "make" | "flush"; name: string }
  | { kind: "write"; name: string; at: number; bytes: Uint8Array }
  | { kind: "truncate"; name: string; size: number };

export class FakeDisk implements Folder {
  /** Whether a file can be opened twice. */
  shares = true;
  readonly files = new Map<string, Uint8Array>();
  readonly steps: Step[] = [];
  /** Bytes that the files may have together. */
  room = Infinity;
  /** A full disk takes what there is room for, or throws, or gives a number that is no number of bytes (Chromium). */
  full: "short" | "throws" | "number" = "short";
  /** What every write throws. */
  failure: Error | null = null;
  readonly #open = new Map<string, { holding: Holding; times: number }>();

  names(): Promise<string[]> {
    return Promise.resolve([...this.files.keys()]);
  }

  async open(name: string, holding: Holding): Promise<Handle> {
    await Promise.resolve();
    const held = this.#open.get(name);
    const wanted = this.shares ? holding : "alone";
    if (held?.times && (held.holding === "alone" || wanted === "alone")) throw new StorageError("held");
    this.#open.set(name, { holding: wanted, times: (held?.times ?? 0) + 1 });
    if (!this.files.has(name)) this.take({ kind: "make", name });
    return new FakeHandle(this, name, () => this.#open.get(name)!.times--);
  }

  async view(name: string): Promise<View> {
    if (this.shares) return Object.assign(await this.open(name, "shared"), { renew: () => Promise.resolve() });
    const view = new FakeSnapshot(this, name);
    await view.renew();
    return view;
  }

  /** Do a step, and remember it. */
  take(step: Step): void {
    this.steps.push(step);
    this.#apply(step);
  }

  get used(): number {
    return [...this.files.values()].reduce((sum, file) => sum + file.length, 0);
  }

  /** Return the disk as it was after `count` steps, and the part `torn` of the next, if it is a write. */
  after(count: number, torn = 0): FakeDisk {
    const next = this.steps[count];
    const part = next?.kind === "write" && torn > 0 ? [cut(next, torn)] : [];
    return FakeDisk.of([...this.steps.slice(0, count), ...part]);
  }

  /** Return what a power failure after `count` steps leaves: of each file all up to its last flush, and any steps after it. */
  afterPowerFailure(count: number, random: () => number): FakeDisk {
    const kept: Step[] = [];
    const byName = new Map<string, Step[]>();
    for (const step of this.steps.slice(0, count)) {
      byName.set(step.name, [...(byName.get(step.name) ?? []), step]);
    }
    for (const own of byName.values()) {
      const sure = own.findLastIndex((step) => step.kind === "flush") + 1;
      kept.push(...own.filter((step, at) => at < sure || step.kind === "make" || random() < 0.5));
    }
    return FakeDisk.of(kept);
  }

  private static of(steps: Step[]): FakeDisk {
    const disk = new FakeDisk();
    for (const step of steps) disk.#apply(step);
    return disk;
  }

  #apply(step: Step): void {
    const file = this.files.get(step.name) ?? new Uint8Array();
    if (step.kind === "make") this.files.set(step.name, file);
    if (step.kind === "truncate") this.files.set(step.name, resized(file, step.size));
    if (step.kind === "write") {
      const end = step.at + step.bytes.length;
      const longer = end > file.length ? resized(file, end) : file;
      longer.set(step.bytes, step.at);
      this.files.set(step.name, longer);
    }
  }
}

class FakeHandle implements Handle {
  #closed = false;

  constructor(
    private readonly disk: FakeDisk,
    private readonly name: string,
    private readonly onClose: () => void,
  ) {}

  read(into: Uint8Array, { at }: { at: number }): number {
    const bytes = this.#content.subarray(at, at + into.length);
    into.set(bytes);
    return bytes.length;
  }

  write(bytes: Uint8Array, { at }: { at: number }): number {
    if (this.disk.failure) throw this.disk.failure;
    const grown = at + bytes.length - this.#content.length;
    const missing = Math.min(grown, bytes.length, this.disk.used + grown - this.disk.room);
    if (missing > 0 && this.disk.full === "throws") throw quotaExceeded();
    if (missing > 0 && this.disk.full === "number") return 2 ** 32 - 8;
    const taken = bytes.slice(0, bytes.length - Math.max(0, missing));
    if (taken.length) this.disk.take({ kind: "write", name: this.name, at, bytes: taken });
    return taken.length;
  }

  truncate(size: number): void {
    const grown = size - this.#content.length;
    if (grown > 0 && this.disk.used + grown > this.disk.room) throw quotaExceeded();
    this.disk.take({ kind: "truncate", name: this.name, size });
  }

  getSize(): number {
    return this.#content.length;
  }

  flush(): void {
    if (this.disk.failure) throw this.disk.failure;
    this.disk.take({ kind: "flush", name: this.name });
  }

  close(): void {
    if (!this.#closed) this.onClose();
    this.#closed = true;
  }

  get #content(): Uint8Array {
    if (this.#closed) throw new DOMException("closed", "InvalidStateError");
    return this.disk.files.get(this.name)!;
  }
}

/** What is in the file is seen at once, how long it is when it was renewed. */
class FakeSnapshot extends FakeHandle implements View {
  #size = 0;

  constructor(disk: FakeDisk, name: string) {
    super(disk, name, () => {});
  }

  async renew(): Promise<void> {
    await Promise.resolve();
    this.#size = super.getSize();
  }

  override read(into: Uint8Array, { at }: { at: number }): number {
    return super.read(into.subarray(0, Math.max(0, this.#size - at)), { at });
  }

  override getSize(): number {
    return this.#size;
  }
}

function quotaExceeded(): Error {
  return new DOMException("no room", "QuotaExceededError");
}

function resized(bytes: Uint8Array, size: number): Uint8Array {
  const other = new Uint8Array(size);
  other.set(bytes.subarray(0, size));
  return other;
}

function cut(step: Step & { kind: "write" }, part: number): Step {
  return { ...step, bytes: step.bytes.slice(0, Math.ceil(step.bytes.length * part)) };
}
