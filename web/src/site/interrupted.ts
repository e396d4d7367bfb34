// A recording ends with its page: when the page is reloaded or closed, or the browser crashes. The page notes what is recorded while it goes on, so
// that the next one can say that it was cut short, connect to the car again, and offer to go on.
import { dictionary } from "../lib/i18n";
import { loadSetting, saveSetting } from "../lib/platform/storage";
import type { State } from "../lib/api/types";
import type { Stores } from "../stores";

const t = dictionary({
  cut: {
    en: "The page was closed or reloaded amid a recording. {file} is kept; at most its last second is missing.",
    ru: "Страница закрылась или обновилась во время записи. Запись {file} сохранена, не хватать может только последней секунды.",
  },
  ask: { en: "Continue in a new one?", ru: "Продолжить в новой?" },
  go_on: { en: "Continue", ru: "Продолжить" },
});

const SETTING = "recording.amid";
/** ms between two notes of the same recording. */
const EACH_MS = 5000;
/** ms: who returns later has another drive in mind; then it is only said. */
const RETURN_MS = 30 * 60_000;

interface Note {
  file: string;
  port: string;
  /** UNIX ms. */
  seen: number;
}

type App = Pick<Stores, "api" | "connection" | "live" | "recordingControl" | "route" | "toasts">;

export class Interrupted {
  private noted: Note | null = null;

  /** Note the recording that goes on, and forget it when it has ended. */
  follow({ recording, port }: Pick<State, "recording" | "port">, now: number): void {
    if (recording && !recording.failure && port !== null) {
      if (this.noted?.file === recording.file && now - this.noted.seen < EACH_MS) return;
      this.noted = { file: recording.file, port, seen: now };
      saveSetting(SETTING, JSON.stringify(this.noted));
    } else if (this.noted !== null) {
      this.noted = null;
      saveSetting(SETTING, "");
    }
  }

  /** Called with the program's first state: say that a recording was cut short, and come back to its car. Returns whether one was. */
  began(app: App): boolean {
    const note = parsed(loadSetting(SETTING));
    saveSetting(SETTING, "");
    if (note === null) return false;
    const recent = Date.now() - note.seen < RETURN_MS;
    const action = recent ? { text: () => t("go_on"), run: () => void goOn(app, note) } : undefined;
    const text = () => t("cut", { file: note.file }) + (recent ? ` ${t("ask")}` : "");
    app.toasts.refuse(text, { duration: Infinity, action });
    if (!recent) return false;
    if (location.hash === "") app.route.go("live");
    void reconnected(app, note);
    return true;
  }
}

/** The reconnection that goes on: a click on *Continue* meanwhile waits for it, and begins no other. */
let returning: Promise<boolean> | null = null;

function reconnected(app: App, note: Note): Promise<boolean> {
  returning ??= reconnect(app, note).finally(() => (returning = null));
  return returning;
}

export const interrupted = new Interrupted();

/** Connect as before, if the browser still allows the adapter: no list is shown. */
async function reconnect({ api, connection, live, toasts }: App, { port }: Note): Promise<boolean> {
  const adapter = port.replace(/\?.*/s, "");
  const found = await toasts.attempt(() => api.ports());
  const allowed = adapter === "sim:" || found?.ports.some(({ url }) => url === adapter);
  if (allowed && live.state?.line === "off") await connection.connect(port);
  return allowed === true;
}

/** Called in a click: where the browser has forgotten the adapter, its list is shown. */
async function goOn(app: App, note: Note): Promise<void> {
  const { connection, live, recordingControl, route } = app;
  const go = route.later();
  const back = returning !== null || live.state?.line === "off" ? await reconnected(app, note) : true;
  if (!back) await connection.choose();
  if (live.state?.recording) return;
  await recordingControl.toggle();
  if (live.state?.line !== "off") go("live");
}

function parsed(text: string | null): Note | null {
  try {
    const it: unknown = JSON.parse(text || "null");
    if (!(it instanceof Object && "file" in it && "port" in it && "seen" in it)) return null;
    const { file, port, seen } = it;
    return typeof file === "string" && typeof port === "string" && typeof seen === "number" ? { file, port, seen } : null;
  } catch {
    return null;
  }
}
