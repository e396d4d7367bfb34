// A WebSocket to the program in a worker, as far as the page needs one.
import type { LiveSocket } from "../../lib/platform/host";
import type { Post } from "./exchange";
import type { FromWorker } from "./messages";

/** The code of a connection that was lost. */
const LOST = 1006;

export class WorkerSocket implements LiveSocket {
  onopen: WebSocket["onopen"] = null;
  onmessage: WebSocket["onmessage"] = null;
  onclose: WebSocket["onclose"] = null;
  readyState: number = WebSocket.CONNECTING;

  constructor(
    private readonly id: number,
    private readonly post: Post,
    private readonly over: () => void,
  ) {}

  send(data: string): void {
    if (this.readyState === WebSocket.OPEN) this.post({ kind: "send", id: this.id, data });
  }

  close(code = 1000): void {
    if (this.readyState >= WebSocket.CLOSING) return;
    this.readyState = WebSocket.CLOSING;
    this.post({ kind: "close", id: this.id, code });
  }

  receive(message: FromWorker): void {
    const self = this as unknown as WebSocket;
    if (message.kind === "opened") {
      this.readyState = WebSocket.OPEN;
      this.onopen?.call(self, new Event("open"));
    } else if (message.kind === "message") this.onmessage?.call(self, new MessageEvent("message", { data: message.data }));
    else if (message.kind === "closed") this.closed(message.code, message.reason);
    else if (message.kind === "failed") this.closed(LOST, message.message);
  }

  /** The worker has ended. */
  lose(message: string): void {
    this.closed(LOST, message);
  }

  private closed(code: number, reason: string): void {
    this.readyState = WebSocket.CLOSED;
    this.over();
    this.onclose?.call(this as unknown as WebSocket, new CloseEvent("close", { code, reason }));
  }
}
