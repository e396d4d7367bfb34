import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import type { Recording } from "../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import Note from "./Note.svelte";

eachOnItsOwnPage();

const drive = (note: string) => ({ id: "drive.pcapng", note }) as Recording;

it("a saved note is announced, also where the list came with it before the answer", async () => {
  const { show, stores } = page();
  let answer = (): void => undefined;
  const write = vi.spyOn(stores.api, "noteRecording").mockImplementation(() => new Promise((done) => (answer = () => done({}))));
  const said = vi.spyOn(stores.toasts, "success");
  const { rerender } = show(Note, { recording: drive("") });
  await fireEvent.click(screen.getByRole("button"));
  await fireEvent.input(screen.getByRole("textbox"), { target: { value: " knocks uphill " } });
  await fireEvent.submit(document.querySelector("form")!);
  expect(write).toHaveBeenCalledWith("drive.pcapng", "knocks uphill");
  // The page rig takes them as its `props`; the library unwraps the outer ones.
  await rerender({ props: { props: { recording: drive("knocks uphill") } } });
  answer();
  await vi.waitFor(() => expect(document.querySelector("form")).toBeNull());
  expect(said).toHaveBeenCalledOnce();
});

it("a note that is as it was is neither sent nor announced", async () => {
  const { asked, show, stores } = page();
  const said = vi.spyOn(stores.toasts, "success");
  show(Note, { recording: drive("as it was") });
  await fireEvent.click(screen.getByRole("button"));
  await fireEvent.submit(document.querySelector("form")!);
  await vi.waitFor(() => expect(document.querySelector("form")).toBeNull());
  expect(asked.filter(({ method }) => method === "PUT")).toEqual([]);
  expect(said).not.toHaveBeenCalled();
});
