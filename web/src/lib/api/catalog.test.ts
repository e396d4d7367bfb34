import { afterEach, expect, it, vi } from "vitest";
import type { Catalog } from "./types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { api, catalog } = new Stores(served);

const version = (version: string) => ({ version, parameters: [], derived: [] }) as unknown as Catalog;

afterEach(() => {
  catalog.loaded = null;
});

it("a catalog that was requested before a change does not replace the changed one", async () => {
  let answer = (_: Catalog) => {};
  vi.spyOn(api, "catalog").mockImplementation(() => new Promise((resolve) => (answer = resolve)));
  const stop = catalog.follow("1")!;
  catalog.use(version("2")); // saved on this page
  stop(); // the state names version 2
  answer(version("1"));
  await Promise.resolve();
  await Promise.resolve();
  expect(catalog.loaded?.version).toBe("2");
});
