import { render, screen } from "@testing-library/svelte";
import { expect, it } from "vitest";
import { limitTexts } from "../../lib/channels/limitFields";
import { eachOnItsOwnPage } from "../../../test/pageRig";
import LimitFields from "./LimitFields.svelte";

eachOnItsOwnPage();
const limits = { danger_low: null, warning_low: null, warning_high: 100.5, danger_high: 110, hysteresis: 2 };
const fields = () => screen.getAllByRole<HTMLInputElement>("textbox");

it("each limit has its field, in the unit of the channel; without a limit it is empty", () => {
  render(LimitFields, { texts: limitTexts(limits), unit: "°C" });
  expect(fields().map(({ value }) => value)).toEqual(["", "", "100.5", "110", "2"]);
  expect(screen.getByLabelText(/Danger above, °C/)).toBe(fields()[3]);
});

it("who may not change them can't type", () => {
  render(LimitFields, { texts: limitTexts(limits), unit: "", disabled: true });
  expect(fields().every(({ disabled }) => disabled)).toBe(true);
});
