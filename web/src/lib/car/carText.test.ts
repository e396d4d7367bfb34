import { expect, it } from "vitest";
import { carName, parseMileage } from "./carText";

it("reads a mileage as people write it", () => {
  for (const typed of ["154000", " 154 000 ", "154\u00a0000 км", "154,000 km", "154.000"]) expect(parseMileage(typed)).toBe(154_000);
  expect(parseMileage(" ")).toBe(null);
  expect(parseMileage("0")).toBe(0);
  for (const typed of ["-5", "many", "12e3", "10000000", "1".repeat(40)]) expect(parseMileage(typed)).toBe(undefined);
});

it("names a car on one line", () => {
  expect(carName({ car: "Волга", plate: "А123ВС 52" })).toBe("Волга · А123ВС 52");
  expect(carName({ car: "", plate: "А123ВС 52" })).toBe("А123ВС 52");
  expect(carName({ car: "", plate: "" })).toBe("");
});
