// The ports found and the connection check; both continue while another screen is shown.
import { Resource } from "../../lib/api/resource.svelte";
import { ApiRequest } from "../../lib/api/request.svelte";
import type { About, DoctorStep, State } from "../../lib/api/types";
import { watch } from "../../lib/platform/watch.svelte";
import type { Stores } from "../../stores";

/** ms between two scans for adapters, so that one appears after it is plugged in. */
const SCAN_MS = 3000;

export class ConnectionStore {
  readonly ports = new Resource({
    of: () => this.app.live.linked,
    ask: async () => (await this.app.api.ports()).ports,
    every: () => (this.app.live.linked ? SCAN_MS : 0),
  });
  /** Another page may switch the network; its addresses change, and a phone comes by one of them. */
  readonly about: Resource<true, About> = new Resource({
    of: () => this.app.live.linked,
    again: () => this.app.live.state?.lan,
    ask: () => this.app.api.about(),
    every: () => (this.app.live.linked && this.about.value?.lan_links.length ? SCAN_MS : 0),
  });
  readonly network = new ApiRequest<About>();
  /** Counts the answers of the switch: each has another link. */
  shares = $state(0);
  readonly ending = new ApiRequest<About>();
  readonly connecting = new ApiRequest<State>();
  readonly pausing = new ApiRequest<State>();
  /** The port being connected to; "" for the most likely one. */
  wanted = $state<string | null>(null);
  /** The port that a person is typing. */
  typed = $state("");
  /** Disconnecting or connecting elsewhere would end this recording and has to be confirmed. Without `port`: disconnect. */
  leaving = $state.raw<{ file: string; port?: string | null; driven?: boolean } | null>(null);

  steps = $state.raw<DoctorStep[]>([]);
  readonly check = new ApiRequest<void>();
  readonly stopping = new ApiRequest<State>();
  /** The port that a check was requested of; null: left to the program. */
  examined = $state<string | null>(null);
  /** The check looks for another kind of unit, too. */
  others = $state(false);
  /** When the check began, in seconds of this computer. */
  checkedAt = $state(0);

  /** The change of the port that runs. */
  private turning: Promise<unknown> | null = null;
  private turns = 0;

  /** The browser's list is shown. */
  choosing = $state(false);
  /** How to go to the gauges once values come; null: no one waits for them. */
  private toGauges = $state.raw<(() => void) | null>(null);

  constructor(private readonly app: Pick<Stores, "api" | "host" | "live" | "recordingControl" | "route">) {}

  /** For the frame while it is initialised: from an adapter that was chosen to its gauges, without a further touch. */
  follow(): void {
    watch(
      () => this.toGauges !== null && this.app.live.answers,
      (come) => {
        if (!come) return;
        this.toGauges?.();
        this.toGauges = null;
      },
    );
  }

  /** The port that is or was checked, as the program says. */
  get checkedPort(): string | null {
    return this.steps[0]?.port ?? this.examined;
  }

  /** The file of a running recording. */
  private get recorded(): string | null {
    const recording = this.app.live.state?.recording;
    return recording && !recording.failure ? recording.file : null;
  }

  /** Open the program to the network, or close it. */
  async share(on: boolean, control: boolean): Promise<void> {
    const about = await this.network.run(() => this.app.api.network(on, control));
    if (!about) return void (await this.about.reload());
    if (about.lan) this.shares += 1;
    this.about.value = about;
  }

  /** End a program that an icon has started; its end closes the recording. */
  async end(): Promise<void> {
    const file = this.recorded;
    this.app.live.ended = (await this.ending.run(() => this.app.api.end())) !== undefined;
    if (this.app.live.ended && file) this.app.recordingControl.announceSaved(file);
  }

  /** Let the user choose an adapter in the browser's list, connect to it, and show its gauges when it answers. Without a choice: the advice. */
  async choose(): Promise<void> {
    const go = this.app.route.later();
    this.choosing = true;
    const port = await this.app.host.choosePort?.().finally(() => (this.choosing = false));
    if (!port) return go("connection");
    void this.ports.reload();
    await this.change(port, false, go);
  }

  /** Connect to an adapter that needs no choice, and show its gauges when it answers. */
  async begin(port: string): Promise<void> {
    await this.change(port, false, this.app.route.later());
  }

  /** Connect, or disconnect without a port. A recording of another port would end: ask first. */
  async connect(port?: string | null): Promise<void> {
    await this.change(port, false);
  }

  /** Start a virtual car, and show its gauges. */
  async drive(car: string): Promise<void> {
    await this.change(car, true);
  }

  /** `driven`: the gauges are shown then; `go`: when values come. */
  private async change(port: string | null | undefined, driven: boolean, go?: ReturnType<Stores["route"]["later"]>): Promise<void> {
    const now = go ?? this.app.route.later();
    const file = this.recorded;
    this.toGauges = null;
    if (file && port !== this.app.live.state?.port) this.leaving = { file, port, driven };
    else if (!(await this.turnTo(port))) return;
    else if (driven) now("live");
    else if (go) this.toGauges = () => go("live");
  }

  /** The confirmation was given. */
  async leave(): Promise<void> {
    const left = this.leaving;
    if (!left) return;
    this.leaving = null;
    const go = this.app.route.later();
    if (!(await this.turnTo(left.port))) return;
    this.app.recordingControl.announceSaved(left.file);
    if (left.driven) go("live");
  }

  private async turnTo(port?: string | null): Promise<boolean> {
    const { api } = this.app;
    const wanted = port === undefined ? null : (port ?? "");
    this.wanted = wanted;
    const state = await this.inTurn(this.connecting, () => (port === undefined ? api.disconnect() : api.connect(port)));
    if (this.wanted === wanted) this.wanted = null;
    return state !== undefined;
  }

  /** Keep this pause before each request, in seconds, or find it by trying; the port is opened again, and a recording goes on. */
  async keepPause(pause: number | "auto"): Promise<void> {
    const { api, live } = this.app;
    const { port, plan } = live.state ?? {};
    if (port && plan) await this.inTurn(this.pausing, () => api.connect(port, { pause, method: plan.method, rate: plan.rate }));
  }

  /**
   * Change the port once the change before has ended: the program refuses two at a time, and a press may arrive before the one that it follows.
   * Undefined if it failed, or if another one was wanted meanwhile.
   */
  private async inTurn(request: ApiRequest<State>, job: () => Promise<State>): Promise<State | undefined> {
    const turn = ++this.turns;
    while (this.turning) await this.turning;
    if (turn !== this.turns) return undefined;
    const running = request.run(job);
    this.turning = running.catch(() => undefined);
    try {
      const state = await running;
      if (state) this.app.live.use(state);
      return state;
    } finally {
      this.turning = null;
    }
  }

  /** Check the connection; `others`: where no Mikas answers, look for another kind of unit. */
  async examine(port: string | null, others = false): Promise<void> {
    const { api, live } = this.app;
    this.steps = [];
    this.others = others;
    this.check.reset();
    this.stopping.reset();
    this.examined = port;
    this.checkedAt = Date.now() / 1000;
    // With the state after it: else the last message would still say that the check has the port.
    const state = () =>
      api.state().then(
        (it) => live.use(it),
        () => undefined,
      );
    await this.check.run(() => api.doctor(port, (step) => (this.steps = [...this.steps, step]), others).finally(state));
  }

  /** Stop the check; the server releases the port and ends the steps. */
  async stop(): Promise<void> {
    const state = await this.stopping.run(() => this.app.api.stopDoctor());
    if (state) this.app.live.use(state);
  }
}
