// An archive (`tools/site/archives.py`): a ZIP of uncompressed files, compressed as a whole, which is smaller and unpacks in one go. Its files
// are parts of one buffer: none is copied.

const END = 0x06054b50;
const ENTRY = 0x02014b50;

export interface Packed {
  path: string;
  content: Uint8Array<ArrayBuffer>;
}

/** What came compressed by gzip. */
export function inflated(response: Response): Response {
  return new Response(response.body?.pipeThrough(new DecompressionStream("gzip")), { status: response.status });
}

/** The files of a ZIP archive that compresses none of them and has no comment. */
export function filesOf(archive: ArrayBuffer): Packed[] {
  const view = new DataView(archive);
  const end = archive.byteLength - 22;
  if (end < 0 || view.getUint32(end, true) !== END) throw new Error("The program's archive is damaged");
  const decoder = new TextDecoder();
  const found: Packed[] = [];
  let at = view.getUint32(end + 16, true);
  for (let left = view.getUint16(end + 10, true); left > 0; left -= 1) {
    const method = view.getUint16(at + 10, true);
    if (view.getUint32(at, true) !== ENTRY || method !== 0) throw new Error("The program's archive is damaged");
    const size = view.getUint32(at + 24, true);
    const name = view.getUint16(at + 28, true);
    const others = view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
    const local = view.getUint32(at + 42, true);
    const begin = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
    const path = decoder.decode(new Uint8Array(archive, at + 46, name));
    found.push({ path, content: new Uint8Array(archive, begin, size) });
    at += 46 + name + others;
  }
  return found;
}
