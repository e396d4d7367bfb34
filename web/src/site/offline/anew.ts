// The page loaded anew from its server: what this browser has kept of it may be damaged, or of another version. Recordings are kept elsewhere.
import { within } from "../within";
import { kindOf } from "./keptFiles";

/** ms in which the server answers, and the browser forgets. */
const PATIENCE = 10_000;

/** What is used of the browser; tests hand in others. */
export interface Browser {
  fetch: typeof fetch;
  caches: CacheStorage | undefined;
  workers: Pick<ServiceWorkerContainer, "getRegistrations"> | undefined;
  reload: () => void;
}

const here: Browser = {
  fetch: (...request) => fetch(...request),
  caches: globalThis.caches,
  workers: globalThis.navigator?.serviceWorker,
  reload: () => location.reload(),
};

/** Forget the files of the site that is at `site`, and reload it. Without its server nothing is forgotten; then return false. */
export async function loadAnew(site: URL, { fetch, caches, workers, reload }: Browser = here): Promise<boolean> {
  try {
    // No service worker answers this: it asks the server.
    const found = await within(PATIENCE, fetch(site.href, { method: "HEAD", cache: "no-store" }));
    if (!found.ok) return false;
  } catch {
    return false;
  }
  // What hangs is left: the reload asks the server for all that it can.
  await within(PATIENCE, forget(site, caches, workers)).catch(() => undefined);
  reload();
  return true;
}

async function forget(site: URL, caches: Browser["caches"], workers: Browser["workers"]): Promise<void> {
  for (const each of (await workers?.getRegistrations()) ?? []) if (each.scope === site.href) await each.unregister();
  for (const name of (await caches?.keys()) ?? []) if (name.startsWith(kindOf(site))) await caches!.delete(name);
}
