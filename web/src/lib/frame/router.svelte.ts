// The current screen from the URL: `#/recordings/NAME` is screen "recordings" with rest ["NAME"]. In the hash, so that the server serves
// one page and Back works.

const SCREENS = ["live", "chart", "faults", "tests", "causes", "passport", "memory", "recordings", "report", "connection"] as const;

export type ScreenName = (typeof SCREENS)[number];

export class Route {
  screen = $state<ScreenName>("live");
  rest = $state.raw<string[]>([]);

  constructor() {
    this.read();
    globalThis.addEventListener?.("hashchange", () => this.read());
  }

  go(screen: ScreenName, ...rest: string[]): void {
    location.hash = "/" + [screen, ...rest.map(encodeURIComponent)].join("/");
  }

  /** For what takes a while: how to go where it leads. If the person has gone elsewhere meanwhile, they stay there. */
  later(): (screen: ScreenName, ...rest: string[]) => void {
    const { rest: from } = this; // of each address one of its own
    return (screen, ...rest) => this.rest === from && this.go(screen, ...rest);
  }

  private read(): void {
    const [screen, ...rest] = parsed(globalThis.location?.hash ?? "");
    this.screen = screen;
    this.rest = rest;
  }
}

/** The screen of a hash, and what follows it; an unknown one is Live, and a part that is not encoded right is taken as it is. */
export function parsed(hash: string): [ScreenName, ...string[]] {
  const [name = "", ...rest] = hash.replace(/^#\/?/, "").split("/");
  return [SCREENS.find((screen) => screen === name) ?? "live", ...rest.filter(Boolean).map(decoded)];
}

function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

export const href = (screen: ScreenName, ...rest: string[]) => "#/" + [screen, ...rest.map(encodeURIComponent)].join("/");
