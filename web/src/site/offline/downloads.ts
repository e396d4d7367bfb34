// The page's end of a download: a link to the API is a request of the browser itself, which only the service worker sees; it asks this page.
// Where there is no service worker (yet), the page saves the file itself.
import { saveFile } from "../../lib/platform/output";
import type { Asked, FromPage, ToPage } from "./asking";

type Fetch = (address: string, init?: RequestInit) => Promise<Response>;

export function answerDownloads(fetch: Fetch): void {
  document.addEventListener("click", (event) => void saveByPage(event, fetch));
  navigator.serviceWorker?.addEventListener("message", ({ data, ports: [port] }: MessageEvent<Asked>) => {
    if (data.kind === "request" && port) void answer(port, data.address, fetch);
  });
  navigator.serviceWorker?.startMessages();
}

/** Send the answer to a request through `port`, a part each time when more is wanted. */
export async function answer(port: MessagePort, address: string, fetch: Fetch): Promise<void> {
  const say = (message: FromPage, transfer: Transferable[] = []) => port.postMessage(message, transfer);
  const stop = new AbortController();
  let parts: ReadableStreamDefaultReader<Uint8Array<ArrayBuffer>> | undefined;

  const more = async () => {
    try {
      const part = await parts?.read();
      if (part?.value) return say({ kind: "part", data: part.value }, [part.value.buffer]);
      say({ kind: "end" });
    } catch {
      say({ kind: "failed" });
    }
    port.close();
  };

  port.onmessage = ({ data }: MessageEvent<ToPage>) => (data.kind === "more" ? void more() : stop.abort());
  say({ kind: "here" });
  try {
    const response = await fetch(address, { signal: stop.signal });
    parts = response.body?.getReader();
    say({ kind: "head", status: response.status, headers: [...response.headers] });
  } catch {
    say({ kind: "failed" });
    port.close();
  }
}

async function saveByPage(event: MouseEvent, fetch: Fetch): Promise<void> {
  const link = event.target instanceof Element ? event.target.closest<HTMLAnchorElement>("a[download]") : null;
  const address = link?.getAttribute("href");
  if (!link || !address?.startsWith("api/") || navigator.serviceWorker?.controller) return;
  event.preventDefault();
  const response = await fetch(address);
  saveFile(link.download, await response.blob(), "application/octet-stream");
}
