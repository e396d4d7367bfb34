import { expect, it } from "vitest";
import { MOST_PANES, readPanes } from "./view.svelte";

const trace = (name: unknown, colour: unknown, hidden?: unknown) => ({ name, colour, hidden });
const read = (panes: unknown) => readPanes(JSON.stringify(panes));

it("the panes are those that this browser stored, as far as these are sound", () => {
  const panes = [
    { id: 7, traces: [trace("FREQ", 1), trace("THR", 2, true)] },
    { id: 9, traces: [trace("UOZ", 8)] },
  ];
  expect(read(panes)).toEqual([
    { id: 0, traces: [trace("FREQ", 1, false), trace("THR", 2, true)] },
    { id: 1, traces: [trace("UOZ", 8, false)] },
  ]);
  // A channel twice, colours that there are not, no name, an empty pane.
  expect(read([{ traces: [trace("FREQ", 1), trace("FREQ", 2), trace("A", 9), trace("B", "1"), trace(null, 1)] }, { traces: [] }])).toEqual([
    { id: 0, traces: [trace("FREQ", 1, false)] },
  ]);
  expect(read(Array.from({ length: 9 }, (_, at) => ({ traces: [trace(`C${at}`, 1)] })))).toHaveLength(MOST_PANES);
});

it("there are the default panes without sound ones", () => {
  const first = readPanes(null);
  expect(first.length).toBeGreaterThan(1);
  for (const text of ["", "{", "null", "5", "[]", "[null]", '[{"traces":{}}]', '[{"traces":[null]}]', '[{"traces":[]}]'])
    expect(readPanes(text)).toEqual(first);
});
