// Day (white, for sunlight) and night (near-black): the system's preference until one is selected here and stored.
import { loadSetting, saveSetting } from "./storage";

export type Tone = "day" | "night";

function first(): Tone {
  const chosen = loadSetting("theme");
  if (chosen === "day" || chosen === "night") return chosen;
  return globalThis.matchMedia?.("(prefers-color-scheme: light)").matches ? "day" : "night";
}

class Theme {
  tone = $state<Tone>(first());
  /** Tokens read before: reading one forces the browser to compute styles. */
  private readonly tokens = new Map<string, string>();

  choose(tone: Tone): void {
    this.tone = tone;
    saveSetting("theme", tone);
    this.show();
  }

  toggle(): void {
    this.choose(this.tone === "day" ? "night" : "day");
  }

  show(): void {
    if (globalThis.document) document.documentElement.dataset.theme = this.tone;
  }

  /** Tokens of the day theme, for a picture on white, whatever is shown. */
  dayTokens(names: readonly string[]): Record<string, string> {
    const { dataset } = document.documentElement;
    const before = dataset.theme;
    dataset.theme = "day";
    const styles = getComputedStyle(document.documentElement);
    const found = Object.fromEntries(names.map((name) => [name, styles.getPropertyValue(`--${name}`).trim()]));
    if (before === undefined) delete dataset.theme;
    else dataset.theme = before;
    return found;
  }

  /** The value of a token of styles/tokens.css, for drawing on a canvas. Read it inside an effect that depends on `tone`. */
  token(name: string): string {
    const key = `${this.tone} ${name}`;
    let value = this.tokens.get(key);
    if (value === undefined) {
      value = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
      this.tokens.set(key, value);
    }
    return value;
  }
}

export const theme = new Theme();
theme.show();
