// What the way to the unit takes by itself: a request and its answer, over and over, by JavaScript alone. The adapter and its driver are those
// of the site, and there is no Python in this worker.
import type { Access } from "../../web/src/site/program/messages";
import { adaptersBy } from "../../web/src/site/usb/access";

const TERMINATOR = 0x0d;
/** ms in which the browser and the unit have all they need. */
const SETTLE = 500;

interface Asked {
  access: Access;
  request: number[];
  seconds: number;
}

self.onmessage = async ({ data: { access, request, seconds } }: MessageEvent<Asked>) => {
  const [port] = (await adaptersBy(access)?.getPorts()) ?? [];
  if (!port) throw new Error("There is no adapter.");
  await port.open({ baudRate: 9600, bufferSize: 1 << 16 });
  const [reader, writer] = [port.readable!.getReader(), port.writable!.getWriter()];
  const bytes = Uint8Array.from(request);
  let [ends, carried, exchanges, begin] = [0, 0, 0, 0];
  const first = performance.now() + SETTLE;
  void writer.write(bytes);
  for (;;) {
    const { value } = await reader.read();
    if (!value) throw new Error("The adapter is gone.");
    carried += value.length;
    ends += value.reduce((count, byte) => count + (byte === TERMINATOR ? 1 : 0), 0);
    if (ends < 2) continue; // its echo's, and its answer's
    ends = 0;
    exchanges += 1;
    const now = performance.now();
    if (begin && now > begin + seconds * 1000) {
      self.postMessage({ exchanges, carried, seconds: (now - begin) / 1000 });
      break;
    }
    if (!begin && now > first) [begin, exchanges, carried] = [now, 0, 0];
    void writer.write(bytes);
  }
  reader.releaseLock();
  writer.releaseLock();
  await port.close();
};
