// The ports found and the connection check; both continue while another screen is shown.
import { ApiError } from "../../lib/api/http";
import { ApiRequest } from "../../lib/api/request.svelte";
import type { About, DoctorStep, Port, State } from "../../lib/api/types";
import type { ApiClient } from "../../lib/api/api";
import type { Host } from "../../lib/platform/host";
import type { Live } from "../../lib/live/live.svelte";
import type { RecordingControl } from "../../lib/control/recordingControl.svelte";

export class ConnectionStore {
  readonly ports = new ApiRequest<Port[]>();
  readonly about = new ApiRequest<About>();
  readonly network = new ApiRequest<About>();
  /** Counts the answers of the switch: each has another link. */
  shares = $state(0);
  readonly ending = new ApiRequest<About>();
  readonly connecting = new ApiRequest<State>();
  /** The port being connected to; "" for the most likely one. */
  wanted = $state<string | null>(null);
  /** Class of the last error of a connect request. */
  code = $state<string | null>(null);
  /** Disconnecting or connecting elsewhere would end this recording and has to be confirmed. Without `port`: disconnect. */
  leaving = $state.raw<{ file: string; port?: string | null } | null>(null);

  steps = $state.raw<DoctorStep[]>([]);
  examining = $state(false);
  /** The port that a check was requested of; null: left to the program. */
  examined = $state<string | null>(null);
  /** When the check began, in seconds of this computer. */
  checkedAt = $state(0);
  error = $state.raw<ApiError | null>(null);
  readonly stopping = new ApiRequest<State>();

  constructor(
    private readonly api: ApiClient,
    private readonly host: Host,
    private readonly live: Live,
    private readonly recordingControl: RecordingControl,
  ) {}

  /** The port that is or was checked, as the program says. */
  get checkedPort(): string | null {
    return this.steps[0]?.port ?? this.examined;
  }

  /** The file of a running recording. */
  private get recorded(): string | null {
    const recording = this.live.state?.recording;
    return recording && !recording.failure ? recording.file : null;
  }

  /** Open the program to the network, or close it. */
  async share(on: boolean, control: boolean): Promise<void> {
    const about = await this.network.run(() => this.api.network(on, control));
    if (!about) return void (await this.about.run(() => this.api.about()));
    if (about.lan) this.shares += 1;
    this.about.value = about;
  }

  /** End a program that an icon has started; its end closes the recording. */
  async end(): Promise<void> {
    const file = this.recorded;
    this.live.ended = (await this.ending.run(() => this.api.end())) !== undefined;
    if (this.live.ended && file) this.recordingControl.announceSaved(file);
  }

  async scan(): Promise<void> {
    await this.ports.run(async () => (await this.api.ports()).ports);
  }

  /** Let the user choose an adapter in the browser's list, and connect to it. */
  async choose(): Promise<void> {
    const port = await this.host.choosePort?.();
    if (!port) return;
    await this.scan();
    await this.connect(port);
  }

  /** Connect; while recording to another port, ask first, because the recording would end. */
  async connect(port: string | null): Promise<void> {
    const file = this.recorded;
    if (file && port !== this.live.state?.port) this.leaving = { file, port };
    else await this.connectNow(port);
  }

  async disconnect(): Promise<void> {
    const file = this.recorded;
    if (file) this.leaving = { file };
    else await this.disconnectNow();
  }

  /** The confirmation was given. */
  async leave(): Promise<void> {
    const left = this.leaving;
    if (!left) return;
    this.leaving = null;
    const ended = left.port === undefined ? await this.disconnectNow() : await this.connectNow(left.port);
    if (ended) this.recordingControl.announceSaved(left.file);
  }

  private async connectNow(port: string | null): Promise<boolean> {
    this.wanted = port ?? "";
    const state = await this.connecting.run(() => this.api.connect(port));
    this.wanted = null;
    this.code = this.connecting.error?.code ?? null;
    if (state) this.live.use(state);
    return state !== undefined;
  }

  private async disconnectNow(): Promise<boolean> {
    const state = await this.connecting.run(() => this.api.disconnect());
    this.code = null;
    if (state) this.live.use(state);
    return state !== undefined;
  }

  async examine(port: string | null): Promise<void> {
    this.steps = [];
    this.error = null;
    this.stopping.reset();
    this.examining = true;
    this.examined = port;
    this.checkedAt = Date.now() / 1000;
    try {
      await this.api.doctor(port, (step) => (this.steps = [...this.steps, step]));
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
    } finally {
      // Else the last message would still say that the check has the port.
      await this.api.state().then(
        (state) => this.live.use(state),
        () => undefined,
      );
      this.examining = false;
    }
  }

  /** Stop the check; the server releases the port and ends the steps. */
  async stop(): Promise<void> {
    const state = await this.stopping.run(() => this.api.stopDoctor());
    if (state) this.live.use(state);
  }
}
