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

  it("disappear when their error no longer applies", () => {
    toasts.error(() => "no unit", { code: "NotConnected" });
    toasts.error(() => "no such channel", { code: "UnknownParameter" });
    toasts.dismiss(new Set(["NotConnected"]));
    expect(texts()).toEqual(["no such channel"]);
  });
});
