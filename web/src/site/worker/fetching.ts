// Counts the bytes of the files of the start while they come, and unpacks archives. Pyodide fetches its own files by itself, so `fetch` is what
// counts and unpacks.
import { inflated } from "./pack";

interface Size {
  bytes: number;
  compressed: number;
}

/** Count the files of `sizes`, by their addresses, as they travel, and unpack those named `.pack`; return how to stop that. */
export function counting(sizes: ReadonlyMap<string, Size>, onProgress: (loaded: number, total: number) => void): () => void {
  const original = self.fetch.bind(self);
  const total = [...sizes.values()].reduce((sum, size) => sum + size.compressed, 0);
  let loaded = 0;
  self.fetch = async (...request) => {
    const response = await original(...request);
    const size = sizes.get(response.url);
    if (size && response.body) void count(response.clone().body!, size);
    return response.ok && response.url.endsWith(".pack") ? inflated(response) : response;
  };

  async function count(body: ReadableStream<Uint8Array>, size: Size): Promise<void> {
    try {
      for await (const part of body) {
        loaded += (part.byteLength / size.bytes) * size.compressed;
        onProgress(Math.min(loaded, total), total);
      }
    } catch {
      // Whoever wanted the file tells what is wrong with it.
    }
  }

  return () => {
    self.fetch = original;
  };
}
