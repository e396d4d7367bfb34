import { fireEvent, render, screen } from "@testing-library/svelte";
import { createRawSnippet } from "svelte";
import { expect, it, vi } from "vitest";
import { eachOnItsOwnPage } from "../../../test/pageRig";
import Table from "./Table.svelte";

eachOnItsOwnPage();

interface Row {
  name: string;
  length: number | null;
}

function table(onpick?: (row: Row) => void) {
  const columns = [
    { key: "name", title: "Name", by: (row: Row) => row.name },
    { key: "length", title: "Length", by: (row: Row) => row.length },
  ];
  const rows = [
    { name: "b", length: 10 },
    { name: "a", length: null },
    { name: "c", length: 9 },
  ];
  const cell = createRawSnippet((row: () => Row, key: () => string) => ({ render: () => `<i>${key() === "name" ? row().name : ""}</i>` }));
  render(Table, { columns, rows, id: (row: Row) => row.name, cell, onpick } as never);
}
const names = () => [...document.querySelectorAll("tbody tr")].map((row) => row.textContent.trim()[0]);

it("a head sorts up, down, and then as it came; what has no value is last", async () => {
  table();
  expect(names()).toEqual(["b", "a", "c"]);
  const head = screen.getByRole("button", { name: /Length/ });
  await fireEvent.click(head);
  expect(names()).toEqual(["c", "b", "a"]);
  expect(head.closest("th")?.getAttribute("aria-sort")).toBe("ascending");
  await fireEvent.click(head);
  expect(head.closest("th")?.getAttribute("aria-sort")).toBe("descending");
  await fireEvent.click(head);
  expect(names()).toEqual(["b", "a", "c"]);
});

it("a row is picked by a click and by Enter", async () => {
  const onpick = vi.fn();
  table(onpick);
  await fireEvent.click(document.querySelector("tbody tr td")!);
  await fireEvent.keyDown(document.querySelector("tbody tr")!, { key: "Enter" });
  expect(onpick.mock.calls.map(([row]) => (row as Row).name)).toEqual(["b", "b"]);
});
