// Repeat a request that a screen can't do without: after 1, 2, 4, 8 s, then every 8 s; one request at a time.
const DELAYS = [1000, 2000, 4000, 8000];

/** Run `job` now and again until it succeeds. Returns a function that ends the retries, to be returned from an `$effect`. */
export function retry(job: () => Promise<unknown>): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let over = false;

  const ask = (tries: number): void => {
    const again = () => {
      if (over) return;
      timer = setTimeout(() => ask(tries + 1), DELAYS[Math.min(tries, DELAYS.length - 1)]);
    };
    void job().catch(again);
  };

  ask(0);
  return () => {
    over = true;
    clearTimeout(timer);
  };
}
