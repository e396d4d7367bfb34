// The program in two workers: one holds the line and all that is kept, the other only reads recordings. The reader takes seconds to start: that
// is done when it is first needed or while values come, and not before the first one answers. Where it can't be had, the first one does everything.
// Where memory is scarce the reader, which takes half as much again, is started only when it is needed, and ends when it was not for a minute.
import type { Text } from "../../lib/api/types";
import { Endpoint, type Port } from "./endpoint";
import type { Role, Situation } from "./messages";
import { whoAnswers } from "./whoAnswers";
import type { WorkerSocket } from "./workerSocket";

const readerEnded: Text = {
  en: "Reading the recording has failed: the browser may have run out of memory. Close other tabs and try again; live values and recording go on.",
  ru: "Чтение записи прервалось: возможно, браузеру не хватило памяти. Закройте другие вкладки и повторите; опрос и запись продолжаются.",
};

const LIST = "api/recordings";
/** ms without a request after which a reader ends where memory is scarce. Who looks through a recording asks more often than that. */
export const IDLE_MS = 60_000;

export class Program {
  readonly line: Endpoint;
  private reader: Endpoint | null = null;
  private situation: Situation = { recording: null, catalog: null };
  /** Nothing waits for the line's worker: it reads a recording itself until the reader has started. */
  lineIsFree = false;
  /** Requests on their way to the reader. */
  private asking = 0;
  private ending: ReturnType<typeof setTimeout> | undefined;

  /** `shared`: whether both workers see the same files; else there is nothing that a reader could read. `scarce`: memory is. */
  constructor(
    private readonly make: (role: Role) => Port,
    private readonly shared: Promise<boolean>,
    private readonly scarce = false,
  ) {
    this.line = new Endpoint(make("line"));
  }

  /** As `fetch`, for addresses of the API relative to the page. */
  readonly fetch = async (address: string, init: RequestInit = {}): Promise<Response> => {
    if (whoAnswers(init.method ?? "GET", address, init.body) === "line") return this.line.fetch(address, init);
    this.asking += 1;
    try {
      const reader = await this.readyReader(address);
      return await (reader === null ? this.line.fetch(address, init) : this.read(reader, address, init));
    } finally {
      this.asking -= 1;
      this.endIdleReader();
    }
  };

  readonly connect = (address: string): WorkerSocket => this.line.connect(address);

  /** Tell the reader what the line's worker does: it writes a file that grows, and may have changed the channels. */
  follow(situation: Situation): void {
    this.situation = situation;
    this.reader?.tell(situation);
  }

  /** Start the reader before it is needed; it takes seconds. */
  prepareReader(): void {
    if (!this.scarce) void this.startedReader();
  }

  private async read(reader: Endpoint, address: string, init: RequestInit): Promise<Response> {
    try {
      return await reader.fetch(address, init);
    } catch (error) {
      // Not again by the line's worker: what has ended this one would end that one, too.
      if (reader.ended === null || init.signal?.aborted) throw error;
      return Response.json({ error: { code: "ReaderEnded", ...readerEnded } }, { status: 500 });
    }
  }

  private async readyReader(address: string): Promise<Endpoint | null> {
    const waits = this.lineIsFree && !this.hasReader;
    // The list alone is not worth a reader. All else is, and no line's worker reads it meanwhile: what that has once needed stays its own.
    if (this.scarce) return waits && address === LIST ? null : this.startedReader();
    const starting = this.startedReader();
    return waits ? null : starting;
  }

  private get hasReader(): boolean {
    return this.reader !== null && this.reader.started && this.reader.ended === null;
  }

  /** End both workers, so that another tab can have the cable and the storage. */
  terminate(): void {
    this.line.terminate();
    this.reader?.terminate();
  }

  /** Null: it can't be had. */
  private async startedReader(): Promise<Endpoint | null> {
    await this.line.ready;
    if (this.line.ended !== null || !(await this.shared)) return null;
    const gone = this.reader?.ended != null && this.reader.started;
    if (this.reader === null || gone) {
      this.reader = new Endpoint(this.make("reader"));
      this.reader.onidle = () => this.endIdleReader();
      this.reader.tell(this.situation);
    }
    const reader = this.reader;
    try {
      await reader.ready;
      return reader;
    } catch {
      return null;
    }
  }

  /** Where memory is scarce: end the reader after a while, unless it is asked something until then. */
  private endIdleReader(): void {
    clearTimeout(this.ending);
    if (!this.scarce) return;
    this.ending = setTimeout(() => {
      if (this.asking === 0 && this.reader?.busy === false) this.reader.terminate();
    }, IDLE_MS);
  }
}
