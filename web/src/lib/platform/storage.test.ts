import { expect, it, vi } from "vitest";
import { loadSetting, saveSetting } from "./storage";

const forbids = () => {
  throw new DOMException("not here", "SecurityError");
};

it("a setting lasts until the page is reloaded where the browser forbids storing", () => {
  vi.stubGlobal("localStorage", { getItem: forbids, setItem: forbids });
  expect(loadSetting("big.idle")).toBe(null);
  saveSetting("big.idle", "1");
  expect(loadSetting("big.idle")).toBe("1");
  const kept = new Map<string, string>();
  vi.stubGlobal("localStorage", {
    getItem: (name: string) => kept.get(name) ?? null,
    setItem: (name: string, value: string) => kept.set(name, value),
  });
  saveSetting("big.idle", "2");
  expect([loadSetting("big.idle"), kept.get("mikas.big.idle")]).toEqual(["2", "2"]);
});
