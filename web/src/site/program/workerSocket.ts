// A WebSocket to the program in a worker, as far as the page needs one.
import type { LiveSocket } from "../../lib/platform/host";
import type { FromWorker } from "./messages";

/** The code of a connection that was lost. */
const LOST = 1006;

export class WorkerSocket implements LiveSocket {
  onmessage: LiveSocket["onmessage"] = null;
  onclose: LiveSocket["onclose"] = null;

  /** `over` is called when nothing can follow. */
  constructor(private readonly over: () => void) {}

  receive(message: FromWorker): void {
    if (message.kind === "message") this.onmessage?.(new MessageEvent("message", { data: message.data }));
    else if (message.kind === "closed") this.closed(message.code, message.reason);
    else if (message.kind === "failed") this.lose(message.message);
  }

  /** Nothing of it is wanted any more; the program ends it when the page opens another one. */
  close(): void {
    this.over();
  }

  /** The worker has ended. */
  lose(message: string): void {
    this.closed(LOST, message);
  }

  private closed(code: number, reason: string): void {
    this.over();
    this.onclose?.(new CloseEvent("close", { code, reason }));
  }
}
