// The page's end of a download: a link to the API is a request of the browser itself, which only the service worker sees; it asks this page.
// Where there is no service worker (yet), the page saves the file itself.
import type { Stores } from "../../stores";
import { saveFile } from "../../lib/platform/output";
import type { Asked, FromPage, ToPage } from "./asking";

type Fetch = (address: string, init?: RequestInit) => Promise<Response>;

export function answerDownloads(fetch: Fetch, stores: Stores): void {
  document.addEventListener("click", (event) => save(event, stores));
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

/** Save what a link names. Chromium does not ask the service worker for links with `download`, but for a frame whose answer is a file. */
function save(event: MouseEvent, { api, toasts }: Stores): void {
  const link = event.target instanceof Element ? event.target.closest<HTMLAnchorElement>("a[download]") : null;
  const address = link?.getAttribute("href");
  if (!link || !address?.startsWith("api/")) return;
  event.preventDefault();
  const byPage = async () => {
    const answer = await toasts.attempt(() => api.file(address));
    if (answer) saveFile(link.download, await answer.blob(), "application/octet-stream");
  };
  if (!navigator.serviceWorker?.controller) return void byPage();
  const frame = document.createElement("iframe");
  frame.hidden = true;
  frame.src = address;
  // A frame gets no file, but the answer that says why there is none: the page says it.
  frame.onload = () => void byPage();
  document.querySelector("body > iframe[hidden]")?.remove();
  document.body.append(frame);
}
