import { expect, test } from "vitest";
import { filesOf, inflated } from "./pack";

// compressed(zip_of({"mikas/a.pyc": b"one", "mikas/ё.toml": "два".encode(), "c": b""})) of tools/site/archives.py.
const PACK =
  "H4sIAAAAAAACAwvwZmYRYYAARQZkwAjEyQEo0h/bcqqYgSwQ5gbi3MzsxGL9RL2CyuT8vFSoWg6IWp1vOW/YgCwQ5oWrvThRryQ/N+fClgubLmwI8GZkEmHGbTsMLAFzktGVo7sGoVwe1W1wjTichtDoje7QAG9WkCqgHcwMi4F0DVghAKErhEQ1AQAA";

const bytes = () => Uint8Array.from(atob(PACK), (letter) => letter.charCodeAt(0));
const packed = () => inflated(new Response(bytes())).arrayBuffer();

test("has the files that the build has packed", async () => {
  const files = filesOf(await packed()).map(({ path, content }) => [path, new TextDecoder().decode(content)]);
  expect(files).toEqual([
    ["c", ""],
    ["mikas/a.pyc", "one"],
    ["mikas/ё.toml", "два"],
  ]);
});

test("a damaged archive is refused, wherever it is cut off", async () => {
  const whole = await packed();
  for (let size = 0; size < whole.byteLength; size += 1) expect(() => filesOf(whole.slice(0, size))).toThrow(/damaged/);
});
