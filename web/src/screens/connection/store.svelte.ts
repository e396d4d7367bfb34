// Ports found and the examination: they go on while one looks at another screen.
import { ApiError, api } from "../../lib/api";
import { Asked } from "../../lib/asked.svelte";
import { live } from "../../lib/live.svelte";
import type { About, DoctorStep, Port, State } from "../../lib/types";

class ConnectionStore {
  readonly ports = new Asked<Port[]>();
  readonly about = new Asked<About>();
  readonly connecting = new Asked<State>();
  /** The port being connected to; "" for the one likely. */
  wanted = $state<string | null>(null);
  /** The last refusal to connect: which trouble it is. */
  code = $state<string | null>(null);

  steps = $state.raw<DoctorStep[]>([]);
  examining = $state(false);
  examined = $state<string | null>(null);
  trouble = $state.raw<ApiError | null>(null);
  private stopper: AbortController | null = null;

  async look(): Promise<void> {
    await this.ports.ask(async () => (await api.ports()).ports);
  }

  async connect(port: string | null): Promise<void> {
    this.wanted = port ?? "";
    const state = await this.connecting.ask(() => api.connect(port));
    this.wanted = null;
    this.code = this.connecting.error?.code ?? null;
    if (state) live.state = state;
  }

  async disconnect(): Promise<void> {
    const state = await this.connecting.ask(() => api.disconnect());
    this.code = null;
    if (state) live.state = state;
  }

  async examine(port: string | null): Promise<void> {
    this.steps = [];
    this.trouble = null;
    this.examining = true;
    this.examined = port;
    const stopper = new AbortController();
    this.stopper = stopper;
    try {
      await api.doctor(port, (step) => (this.steps = [...this.steps, step]), stopper.signal);
    } catch (error) {
      if (error instanceof ApiError) this.trouble = error;
      else if (!stopper.signal.aborted) throw error;
    } finally {
      this.examining = false;
    }
  }

  /** The page stops listening; the program ends the examination and goes back to sampling by itself. */
  stop(): void {
    this.stopper?.abort();
  }
}

export const connection = new ConnectionStore();
