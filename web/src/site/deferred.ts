// A promise that is kept, or broken, from outside.

export class Deferred<T> {
  keep!: (value: T) => void;
  fail!: (reason: unknown) => void;
  readonly promise = new Promise<T>((keep, fail) => {
    this.keep = keep;
    this.fail = fail;
  });
}
