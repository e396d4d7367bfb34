// The survey for the project: its state, asked for while the screen is shown, and what the person answers. It runs in the program, so a page that is
// loaded again, or another one, finds it where it is.
import { ApiRequest } from "../../../lib/api/request.svelte";
import type { SurveyRequest, SurveyResult, SurveyState } from "../../../lib/api/types";
import type { Stores } from "../../../stores";

/** ms between two questions while a survey runs, and while none does: another page may start one. */
const RUNNING = 500;
const IDLE = 3000;
/** Until the owner says otherwise. */
const CONSENTS = { engine: true, passports: false, memory: false };

export class SurveyStore {
  state = $state.raw<SurveyState | null>(null);
  readonly asking = new ApiRequest<SurveyState>();
  readonly change = new ApiRequest<SurveyState>();
  readonly result = new ApiRequest<SurveyResult>();
  /** What the owner allows and has entered so far: a page that is cut off for a moment takes nothing of it away. */
  readonly entered = $state({ consents: { ...CONSENTS }, volts: "", figure: "" });
  /** Counts what this page changes: an answer to a question of before is of the state before. */
  private changes = 0;

  constructor(private readonly app: Pick<Stores, "api">) {}

  /** Follow the survey until the returned function is called. */
  follow(): () => void {
    let stopped = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async () => {
      const { changes } = this;
      const state = await this.asking.run(() => this.app.api.survey());
      if (state && changes === this.changes && !this.change.busy) this.take(state);
      if (!stopped) timer = setTimeout(() => void ask(), this.state?.phase === "running" ? RUNNING : IDLE);
    };
    void ask();
    return () => {
      stopped = true;
      clearTimeout(timer);
    };
  }

  /** A consent holds for one survey. */
  async start(request: SurveyRequest): Promise<void> {
    await this.run(() => this.app.api.startSurvey(request));
    if (this.state?.phase === "running") Object.assign(this.entered, { consents: { ...CONSENTS }, volts: "" });
  }

  stop = () => this.run(() => this.app.api.stopSurvey());
  save = () => this.run(() => this.app.api.saveSurvey());
  forget = () => this.run(() => this.app.api.forgetSurvey());
  done = (id: number, done: boolean) => this.run(() => this.app.api.answerSurvey({ id, done, figure: null }));
  figure = (id: number, figure: number | null) => this.run(() => this.app.api.answerSurvey({ id, done: false, figure }));

  /** Ask for all that the file would hold. */
  look = () => this.result.run(() => this.app.api.surveyResult());

  private async run(job: () => Promise<SurveyState>): Promise<void> {
    this.changes += 1;
    const state = await this.change.run(job);
    this.changes += 1;
    if (state) this.take(state);
  }

  private take(state: SurveyState): void {
    if (state.phase === "running" || state.phase === "idle") this.result.reset();
    if (state.asked?.id !== this.state?.asked?.id) this.entered.figure = "";
    this.state = state;
  }
}
