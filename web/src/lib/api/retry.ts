// Something asked of the server that a screen can't do without: when it fails, again after 1, 2, 4, 8 s, then every 8 s; one at a time.
const DELAYS = [1000, 2000, 4000, 8000];

/** Asks now and until it comes. Returns what ends the asking: for an `$effect`, so that it lasts as long as the live line is open. */
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
