import { fireEvent, screen } from "@testing-library/svelte";
import { createRawSnippet } from "svelte";
import { expect, it, vi } from "vitest";
import type { ChangeProposal } from "../../lib/api/types";
import { eachOnItsOwnPage, page, refused } from "../../../test/pageRig";
import ConfirmChange from "./ConfirmChange.svelte";

eachOnItsOwnPage();

function dialog(confirmation: () => unknown) {
  let proposals = 0;
  const { asked, say, show } = page({
    "/changes/nonce": confirmation,
    "/changes": () => ({ nonce: `nonce ${++proposals}`, before: [], after: [], lost: [] }),
  });
  say();
  const [onclose, ondone] = [vi.fn(), vi.fn()];
  const children = createRawSnippet((proposal: () => ChangeProposal | null) => ({
    render: () => `<p>${proposal()?.nonce ?? "not yet"}</p>`,
  }));
  show(ConfirmChange, {
    change: { change: "erase-faults" },
    title: "Erase?",
    verb: "Erase",
    outdated: "They have changed",
    onclose,
    ondone,
    children,
  } as never);
  const confirmed = () => asked.filter(({ path }) => path.startsWith("/changes/")).map(({ path }) => decodeURI(path));
  const verb = () => screen.getByRole<HTMLButtonElement>("button", { name: "Erase" });
  return { confirmed, onclose, ondone, proposed: () => vi.waitFor(() => expect(verb().disabled).toBe(false)), verb };
}

it("nothing can be confirmed before its proposal is there", () => {
  expect(dialog(() => ({})).verb().disabled).toBe(true);
});

it("the proposal that is shown is confirmed, once", async () => {
  const it = dialog(() => ({ before: [], after: [] }));
  await it.proposed();
  await fireEvent.click(it.verb());
  await vi.waitFor(() => expect(it.ondone).toHaveBeenCalledOnce());
  expect(it.confirmed()).toEqual(["/changes/nonce 1"]);
});

it("an outdated proposal is shown again and not confirmed unseen", async () => {
  const it = dialog(() => refused(409, "ConfirmationOutdated"));
  await it.proposed();
  await fireEvent.click(it.verb());
  await vi.waitFor(() => expect(document.body.textContent).toContain("They have changed"));
  expect(it.ondone).not.toHaveBeenCalled();
  expect(it.confirmed()).toHaveLength(1);
});

it("cancelling sends nothing", async () => {
  const it = dialog(() => ({}));
  await it.proposed();
  await fireEvent.click(screen.getByRole("button", { name: "Cancel" }));
  expect(it.onclose).toHaveBeenCalled();
  expect(it.confirmed()).toEqual([]);
});
