// Recordings that another app has shared with the page, or that the system has opened with it, until the program has them. They are in the
// browser's cache: the service worker reaches it without a page and without a network, and every tab does.

/** What came of a share: recordings; no file; no room for them; a form that can't be read. */
export type News = "some" | "none" | "full" | "failed";

/** The channel on which all tabs hear that something is in the inbox. */
export const CHANNEL = "mikas.shared";

const NAME = "X-Mikas-Name";

export class Inbox {
  /** `scope`: the address of the site. Its kept files are in caches of other names, which a new version forgets. */
  constructor(
    private readonly scope: URL,
    private readonly caches: CacheStorage,
  ) {}

  /** Keep these files, all or none. Return what to say of them. */
  async put(files: readonly File[]): Promise<News> {
    if (files.length === 0) return "none";
    const put: string[] = [];
    try {
      const cache = await this.cache();
      for (const file of files) {
        const address = new URL(`shared/${crypto.randomUUID()}`, this.scope).href;
        put.push(address);
        await cache.put(address, new Response(file, { headers: { [NAME]: encodeURIComponent(file.name) } }));
      }
      return "some";
    } catch (error) {
      const cache = await this.cache().catch(() => null);
      for (const address of put) await cache?.delete(address).catch(() => false);
      return error instanceof Error && error.name === "QuotaExceededError" ? "full" : "failed";
    }
  }

  /** Hand the files to `add`, the first one first. Each stays here until that has ended: a tab that is closed meanwhile loses none. */
  async empty(add: (file: File) => Promise<unknown>): Promise<void> {
    const cache = await this.cache();
    for (const request of await cache.keys()) {
      const found = await cache.match(request);
      if (found) await add(new File([await found.blob()], decodeURIComponent(found.headers.get(NAME) ?? "")));
      await cache.delete(request);
    }
  }

  private cache(): Promise<Cache> {
    return this.caches.open(`mikas-shared ${this.scope.pathname}`);
  }
}
