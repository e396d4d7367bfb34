// What a test of a component needs: Vitest's files share a window, so each test begins and ends with an empty, wide one.
import { cleanup } from "@testing-library/svelte";
import { afterEach, beforeEach, vi } from "vitest";

export function eachOnItsOwnPage(): void {
  beforeEach(() => {
    vi.stubGlobal("scrollTo", () => undefined);
    (window as unknown as { happyDOM: { setViewport(size: object): void } }).happyDOM.setViewport({ width: 1366, height: 768 });
    location.hash = "";
  });
  afterEach(cleanup);
}
