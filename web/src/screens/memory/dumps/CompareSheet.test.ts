import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import type { Dump } from "../../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../../test/pageRig";
import CompareSheet from "./CompareSheet.svelte";

eachOnItsOwnPage();

const dumpOf = (id: string) => ({ id, file: `${id}.bin`, space: "ram", state: "done", first: 0, last: 1 }) as unknown as Dump;

it("both dumps are read though the sheet shows another one before the first answer", async () => {
  const { show, stores } = page();
  const [first, second, third] = [dumpOf("one"), dumpOf("two"), dumpOf("three")];
  let answer = (): void => undefined;
  const asked: string[] = [];
  vi.spyOn(stores.api, "file").mockImplementation((address) => {
    asked.push(String(address));
    const bytes = new Response(new Uint8Array([1, 2]));
    return asked.length > 1 ? Promise.resolve(bytes) : new Promise((done) => (answer = () => done(bytes)));
  });
  const dumps = [first, second, third];
  const { rerender } = show(CompareSheet, { dump: first, dumps, onclose: () => undefined });
  await fireEvent.change(screen.getByRole("combobox"), { target: { value: "two" } });
  // The page rig takes them as its `props`; the library unwraps the outer ones.
  await rerender({ props: { props: { dump: third, dumps, onclose: () => undefined } } });
  answer();
  await vi.waitFor(() => expect(asked).toHaveLength(2));
  expect(asked[0]).toContain("/dumps/two/file");
  expect(asked[1]).toContain("/dumps/one/file"); // the one that was shown when it was asked for
});
