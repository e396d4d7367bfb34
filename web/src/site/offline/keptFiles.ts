// The files of one version of the site in the browser's cache, by the list that the build makes of them (`tools/site/listing.py`).
import { within } from "../within";

export interface SiteFiles {
  version: string;
  /** `sha256`: in hexadecimal digits. */
  files: { path: string; sha256: string }[];
}

/** As the desktop's server says it for each of its pages; site.html has the same. */
export const POLICY =
  "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; worker-src 'self' blob:; img-src 'self' data: blob:; " +
  "object-src 'none'; base-uri 'none'; form-action 'self'";

const LIST = "files.json";
const INDEX = "index.html";
/** ms in which the browser finds a kept file; then the server is asked. */
const FOUND_MS = 10_000;
/** Requests at the same time. */
const AT_ONCE = 4;

/** How the names of the caches of the site at `scope` begin. Other sites of the same origin have caches, too. */
export const kindOf = (scope: URL): string => `mikas ${scope.pathname} `;

export class KeptFiles {
  private readonly prefix: string;

  /** `scope`: the address of the site. */
  constructor(
    private readonly version: string,
    private readonly scope: URL,
    private readonly caches: CacheStorage,
    private readonly fetch: typeof globalThis.fetch,
  ) {
    this.prefix = kindOf(scope);
  }

  /** Load all files of this version; what did not change is taken over from the version before. Throws unless all are here and whole. */
  async keep(): Promise<void> {
    const response = await this.fetch(this.address(LIST), { cache: "no-store" });
    const listed = await listIn(response.clone());
    if (listed.version !== this.version) throw new Error(`the site has version ${listed.version} by now, not ${this.version}`);
    const cache = await this.caches.open(this.prefix + this.version);
    const before = await this.before();
    const left = [...listed.files];
    const work = async () => {
      for (let file = left.pop(); file; file = left.pop()) await this.put(cache, before, file);
    };
    await Promise.all(Array.from({ length: AT_ONCE }, work));
    await cache.put(this.address(LIST), response);
  }

  /** Delete the files of other versions. */
  async forgetOthers(): Promise<void> {
    for (const name of await this.names()) if (name !== this.prefix + this.version) await this.caches.delete(name);
  }

  /**
   * The kept file at this address, the page with the headers that a static host does not send; undefined: none, or none that can be read. Other
   * files are the browser's own answers: of these it streams the bytes past this worker, which would hold 16 MB of them for long, and keeps what
   * it has compiled.
   */
  async find(address: string): Promise<Response | undefined> {
    const { pathname } = new URL(address);
    const path = pathname === this.scope.pathname ? INDEX : pathname.slice(this.scope.pathname.length);
    const options = { cacheName: this.prefix + this.version, ignoreVary: true };
    const found = await within(FOUND_MS, this.caches.match(this.address(path), options)).catch(() => undefined);
    if (!found || path !== INDEX) return found;
    const headers = new Headers(found.headers);
    headers.set("Content-Security-Policy", `${POLICY}; frame-ancestors 'none'`);
    headers.set("X-Content-Type-Options", "nosniff");
    headers.set("Referrer-Policy", "no-referrer");
    return new Response(found.body, { status: found.status, headers });
  }

  private address(path: string): string {
    return new URL(path, this.scope).href;
  }

  private async names(): Promise<string[]> {
    return (await this.caches.keys()).filter((name) => name.startsWith(this.prefix));
  }

  /** By path and hash: the kept files of other versions. */
  private async before(): Promise<Map<string, Cache>> {
    const found = new Map<string, Cache>();
    for (const name of await this.names()) {
      const cache = await this.caches.open(name);
      const list = await cache.match(this.address(LIST));
      for (const { path, sha256 } of list ? (await listIn(list)).files : []) found.set(`${path} ${sha256}`, cache);
    }
    return found;
  }

  private async put(cache: Cache, before: ReadonlyMap<string, Cache>, { path, sha256 }: SiteFiles["files"][number]): Promise<void> {
    const address = this.address(path);
    const same = await before.get(`${path} ${sha256}`)?.match(address);
    await cache.put(address, same ?? (await this.whole(address, sha256)));
  }

  /** The file as it is listed: what another cache still has of a former version is loaded again. */
  private async whole(address: string, sha256: string): Promise<Response> {
    const integrity = `sha256-${base64(sha256)}`;
    try {
      return await this.ok(address, { integrity });
    } catch {
      return this.ok(address, { integrity, cache: "reload" });
    }
  }

  private async ok(address: string, init: RequestInit): Promise<Response> {
    const response = await this.fetch(address, init);
    if (!response.ok) throw new Error(`${address}: ${response.status}`);
    return response;
  }
}

async function listIn(response: Response): Promise<SiteFiles> {
  // eslint-disable-next-line @typescript-eslint/no-unsafe-return -- as the build writes it
  return response.json();
}

const base64 = (hex: string): string => btoa(String.fromCharCode(...hex.match(/../g)!.map((byte) => parseInt(byte, 16))));
