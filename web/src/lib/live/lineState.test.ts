import { expect, it } from "vitest";
import { unplugged } from "./lineState";

const model = { en: "Mikas 7.1", ru: "Микас 7.1" };

it("only an adapter that has delivered data counts as unplugged", () => {
  const gone = { reason_code: "PortNotFound", model, samples: 12 };
  expect(unplugged(gone)).toBe(true);
  expect(unplugged({ ...gone, model: null })).toBe(true);
  expect(unplugged({ ...gone, model: null, samples: 0 })).toBe(false);
  expect(unplugged({ ...gone, reason_code: "NoEcho" })).toBe(false);
});
