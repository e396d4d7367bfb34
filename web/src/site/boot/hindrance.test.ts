import { expect, it, vi } from "vitest";
import { hindrance } from "./hindrance";

it("the program needs WebAssembly that can wait", () => {
  vi.stubGlobal("WebAssembly", { Suspending: class {} });
  expect(hindrance()).toBe(null);
  vi.stubGlobal("WebAssembly", {});
  expect(hindrance()).toBe("no-jspi");
  vi.stubGlobal("WebAssembly", undefined);
  expect(hindrance()).toBe("no-wasm");
});
