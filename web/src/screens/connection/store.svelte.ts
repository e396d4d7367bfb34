// The ports found and the connection check; both continue while another screen is shown.
import { api } from "../../lib/api/api";
import { ApiError } from "../../lib/api/http";
import { ApiRequest } from "../../lib/api/request.svelte";
import { host } from "../../lib/platform/host";
import { live } from "../../lib/live/live.svelte";
import { announceSaved } from "../../lib/control/recordingControl.svelte";
import type { About, DoctorStep, Port, State } from "../../lib/api/types";

class ConnectionStore {
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
  /** The last port that data came from since the page was opened. */
  worked = $state<string | null>(null);
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

  /** The port that is or was checked, as the program says. */
  get checkedPort(): string | null {
    return this.steps[0]?.port ?? this.examined;
  }

  /** Open the program to the network, or close it. */
  async share(on: boolean, control: boolean): Promise<void> {
    const about = await this.network.run(() => api.network(on, control));
    if (!about) return void (await this.about.run(() => api.about()));
    if (about.lan) this.shares += 1;
    this.about.value = about;
  }

  /** End a program that an icon has started; its end closes the recording. */
  async end(): Promise<void> {
    const file = running();
    live.ended = (await this.ending.run(() => api.end())) !== undefined;
    if (live.ended && file) announceSaved(file);
  }

  async scan(): Promise<void> {
    await this.ports.run(async () => (await api.ports()).ports);
  }

  /** Let the user choose an adapter in the browser's list, and connect to it. */
  async choose(): Promise<void> {
    const port = await host.choosePort?.();
    if (!port) return;
    await this.scan();
    await this.connect(port);
  }

  /** Connect; while recording to another port, ask first, because the recording would end. */
  async connect(port: string | null): Promise<void> {
    const file = running();
    if (file && port !== live.state?.port) this.leaving = { file, port };
    else await this.connectNow(port);
  }

  async disconnect(): Promise<void> {
    const file = running();
    if (file) this.leaving = { file };
    else await this.disconnectNow();
  }

  /** The confirmation was given. */
  async leave(): Promise<void> {
    const left = this.leaving;
    if (!left) return;
    this.leaving = null;
    const ended = left.port === undefined ? await this.disconnectNow() : await this.connectNow(left.port);
    if (ended) announceSaved(left.file);
  }

  private async connectNow(port: string | null): Promise<boolean> {
    this.wanted = port ?? "";
    const state = await this.connecting.run(() => api.connect(port));
    this.wanted = null;
    this.code = this.connecting.error?.code ?? null;
    if (state) live.state = state;
    return state !== undefined;
  }

  private async disconnectNow(): Promise<boolean> {
    const state = await this.connecting.run(() => api.disconnect());
    this.code = null;
    if (state) live.state = state;
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
      await api.doctor(port, (step) => (this.steps = [...this.steps, step]));
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
    } finally {
      // Else the last message would still say that the check has the port.
      live.state = await api.state().catch(() => live.state);
      this.examining = false;
    }
  }

  /** Stop the check; the server releases the port and ends the steps. */
  async stop(): Promise<void> {
    const state = await this.stopping.run(() => api.stopDoctor());
    if (state) live.state = state;
  }
}

const running = (): string | null => {
  const recording = live.state?.recording;
  return recording && !recording.failure ? recording.file : null;
};

export const connection = new ConnectionStore();
