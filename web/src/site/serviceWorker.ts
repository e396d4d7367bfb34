// The service worker of the site: the files of one version, so that it starts without a network, downloads from the program in a page, and
// recordings that other apps share with it.
// A new version is loaded beside the one in use. It takes over when the page asks for that, or when no page is open.
import { askPages, type Page } from "./offline/asking";
import { KeptFiles } from "./offline/keptFiles";
import { Inbox } from "./shared/inbox";
import { PATH, receive } from "./shared/receive";

/** `make site` puts the version of all files here, so that a browser sees that this script has changed. */
const VERSION = "MIKAS_SITE_VERSION";

/** What is used of a service worker's global scope, whose types can't stand beside those of a page. */
interface Waits extends Event {
  waitUntil(work: Promise<unknown>): void;
}
interface Fetched extends Waits {
  readonly request: Request;
  respondWith(response: Promise<Response>): void;
}
interface Scope {
  readonly registration: { scope: string };
  readonly clients: { claim(): Promise<void>; matchAll(options: object): Promise<Page[]> };
  skipWaiting(): Promise<void>;
  addEventListener(kind: "install" | "activate", listener: (event: Waits) => void): void;
  addEventListener(kind: "fetch", listener: (event: Fetched) => void): void;
  addEventListener(kind: "message", listener: (event: MessageEvent<{ kind: string }>) => void): void;
}
declare const self: Scope;

const site = new URL(self.registration.scope);
const kept = new KeptFiles(VERSION, site, caches, (...request) => fetch(...request));

self.addEventListener("install", (event) => event.waitUntil(kept.keep()));

self.addEventListener("activate", (event) => event.waitUntil(kept.forgetOthers().then(() => self.clients.claim())));

self.addEventListener("message", (event) => {
  if (event.data.kind === "use") void self.skipWaiting();
});

self.addEventListener("fetch", (event) => {
  const { request } = event;
  const { origin, pathname, search } = new URL(request.url);
  if (origin !== site.origin || !pathname.startsWith(site.pathname)) return;
  const path = pathname.slice(site.pathname.length);
  if (request.method === "POST" && path === PATH) return event.respondWith(receive(request, site, new Inbox(site, caches)));
  if (request.method !== "GET") return;
  if (path.startsWith("docs/")) return; // the documentation beside the page is no part of it
  if (!path.startsWith("api/")) return event.respondWith(kept.find(request.url).then((found) => found ?? fetch(request)));
  const asked = self.clients.matchAll({ type: "window", includeUncontrolled: true }).then((pages) => askPages(pages, path + search));
  event.respondWith(asked.then(({ response }) => response));
  event.waitUntil(asked.then(({ over }) => over)); // the body may come for long
});
