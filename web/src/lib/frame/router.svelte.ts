// The current screen from the URL: `#/recordings/NAME` is screen "recordings" with rest ["NAME"]. In the hash, so that the server serves
// one page and Back works.

export const SCREENS = [
  "live",
  "chart",
  "faults",
  "tests",
  "passport",
  "memory",
  "recordings",
  "report",
  "connection",
] as const;

export type ScreenName = (typeof SCREENS)[number];

class Route {
  screen = $state<ScreenName>("live");
  rest = $state.raw<string[]>([]);

  constructor() {
    this.read();
    globalThis.addEventListener?.("hashchange", () => this.read());
  }

  go(screen: ScreenName, ...rest: string[]): void {
    location.hash = "/" + [screen, ...rest.map(encodeURIComponent)].join("/");
  }

  private read(): void {
    const [name = "", ...rest] = (globalThis.location?.hash ?? "").replace(/^#\/?/, "").split("/");
    this.screen = SCREENS.find((screen) => screen === name) ?? "live";
    this.rest = rest.filter(Boolean).map(decodeURIComponent);
  }
}

export const route = new Route();
export const href = (screen: ScreenName, ...rest: string[]) =>
  "#/" + [screen, ...rest.map(encodeURIComponent)].join("/");
