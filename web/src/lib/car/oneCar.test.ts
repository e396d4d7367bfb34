import { expect, it } from "vitest";
import { carKeys, mayBeOneCar } from "./oneCar";

const of = (more: { plate?: string; car?: string; model?: string; passport?: string[]; virtual?: boolean } = {}) => ({
  car: { car: more.car ?? "", plate: more.plate ?? "", mileage: null, workshop: "" },
  model: more.model ? { en: more.model, ru: more.model } : null,
  passport: more.passport ?? null,
  virtual: more.virtual ?? false,
});

it("a plate decides, however it is typed; then the car's name", () => {
  expect(mayBeOneCar(of({ plate: "а 123 вс 52" }), of({ plate: "A123BC52", car: "Волга" }))).toBe(true);
  expect(mayBeOneCar(of({ plate: "A123BC52", car: "Волга" }), of({ plate: "A124BC52", car: "Волга" }))).toBe(false);
  expect(mayBeOneCar(of({ car: "ГАЗ  3110" }), of({ car: "газ 3110" }))).toBe(true);
  expect(mayBeOneCar(of({ car: "ГАЗ 3110" }), of({ car: "Соболь" }))).toBe(false);
});

it("units of different models or passports are not one; what is not known differs from nothing", () => {
  expect(mayBeOneCar(of({ plate: "X", model: "Mikas 5.4" }), of({ plate: "X", model: "Mikas 7.1" }))).toBe(false);
  expect(mayBeOneCar(of({ passport: ["a", "b"] }), of({ passport: ["a", "c"] }))).toBe(false);
  expect(mayBeOneCar(of({ passport: ["a", ""] }), of({ passport: ["a", "c"] }))).toBe(true);
  expect(mayBeOneCar(of(), of({ model: "Mikas 7.1" }))).toBe(true);
  expect(mayBeOneCar(of({ virtual: true }), of())).toBe(false);
});

it("what is kept of a car is found by its plate, else by its name, else by its unit", () => {
  expect(carKeys(of({ plate: "а 123 вс 52", car: "ГАЗ  3110", passport: ["a", "b"] }))).toEqual([
    "plate A123BC52",
    "car газ 3110",
    "unit a/b",
  ]);
  expect(carKeys(of({ passport: ["", ""] }))).toEqual([]);
  expect(carKeys(of({ car: "x", virtual: true }))).toEqual(["virtual car x"]);
});
