import { afterEach, describe, expect, it, vi } from "vitest";
import { ApiError } from "../../../../lib/api/http";
import { titleOf } from "./find.svelte";
import { served } from "../../../../lib/platform/host";
import { Stores } from "../../../../stores";

const { api, find, toasts } = new Stores(served);

const hit = (peak: number | null) => ({ begin: 1, end: 2, rows: 3, peak, peak_time: peak === null ? null : 1.5 });

describe("the title of what was found", () => {
  it("has the extreme of what is compared first", () => {
    const hits = [hit(3100), hit(null), hit(4200)];
    expect(titleOf("FREQ > 3000", { hits, count: 3, peak_of: "FREQ", lowest: false })).toBe("FREQ > 3000 (FREQ up to 4200)");
    const named = titleOf("Обороты > 3000", { hits, count: 3, peak_of: "FREQ", lowest: false }, () => "Speed");
    expect(named).toBe("Обороты > 3000 (Speed up to 4200)");
    expect(titleOf("TAIR < 2", { hits: [hit(1.5), hit(-3.25)], count: 2, peak_of: "TAIR", lowest: true })).toBe(
      "TAIR < 2 (TAIR down to −3.25)",
    );
  });

  it("has none without a comparison", () => {
    expect(titleOf("DET", { hits: [hit(null)], count: 1, peak_of: null, lowest: false })).toBe("DET");
  });

  it("says that there are more", () => {
    expect(titleOf("DET", { hits: [hit(null)], count: 2500, peak_of: null, lowest: false })).toBe("DET; the first 1 of 2500");
  });
});

describe("the kept conditions", () => {
  const kept = (expression: string) => ({ name: "", expression });
  afterEach(() => {
    find.kept = [];
  });

  const save = () => vi.spyOn(api, "saveSearches").mockImplementation((searches) => Promise.resolve({ searches }));

  it("stay when one is added before they were loaded, or after another page has added one", async () => {
    vi.spyOn(api, "searches").mockResolvedValue({ searches: [kept("DET"), kept("RXX")] });
    const saved = save();
    await find.keep(" FREQ > 3000 ");
    expect(saved.mock.calls).toEqual([[[kept("DET"), kept("RXX"), kept("FREQ > 3000")]]]);
    await find.drop("DET");
    expect(saved.mock.lastCall).toEqual([[kept("RXX")]]);
  });

  it("are not replaced if they can't be loaded", async () => {
    vi.spyOn(api, "searches").mockRejectedValue(new ApiError(503, "Busy", { en: "busy", ru: "занято" }));
    const shown = vi.spyOn(toasts, "error").mockReturnValue();
    const saved = save();
    await find.keep("DET");
    expect(shown).toHaveBeenCalledOnce();
    expect(saved).not.toHaveBeenCalled();
  });
});
