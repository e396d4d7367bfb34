import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { toasts } = new Stores(served);

const texts = () => toasts.shown.map((toast) => toast.text());

describe("toasts", () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => {
    vi.runAllTimers();
    vi.useRealTimers();
  });

  it("disappear after a while; errors stay in the history", () => {
    toasts.success(() => "done");
    toasts.error(() => "no answer");
    expect(texts()).toEqual(["done", "no answer"]);
    vi.runAllTimers();
    expect(texts()).toEqual([]);
    expect(toasts.history.at(-1)?.text()).toBe("no answer");
  });

  it("stay until they are closed, and come once, if a person may not look now", () => {
    const sentences = ["frames", "results", "limits", "names"].map((en) => ({ en, ru: `${en} (ru)` }));
    toasts.remind(sentences.slice(0, 1));
    toasts.remind(sentences);
    for (const text of ["one", "two", "three"]) toasts.success(() => text);
    vi.runAllTimers();
    expect(texts()).toEqual(["frames", "results", "limits", "names"]);
    toasts.close(toasts.shown[0]!.id);
    toasts.remind(sentences);
    expect(texts()).toEqual(["results", "limits", "names"]);
    for (const { id } of toasts.shown) toasts.close(id);
  });

  it("disappear when their error no longer applies", () => {
    toasts.error(() => "no unit", { code: "NotConnected" });
    toasts.error(() => "no such channel", { code: "UnknownParameter" });
    toasts.dismiss(new Set(["NotConnected"]));
    expect(texts()).toEqual(["no such channel"]);
  });
});
