import { expect, it } from "vitest";
import { fieldOf, parseValues, pathOf, valuesAt, withValues } from "./document";

it("puts one value into the base and several into the matrix", () => {
  const job = { name: "x", base: { arena: "easy" }, other: [1] };
  const one = withValues(job, "controller.alpha", [0.5]);
  expect(one).toEqual({ name: "x", base: { arena: "easy", controller: { alpha: 0.5 } }, other: [1] });
  const two = withValues(one, "controller.alpha", [0.5, 0.7]);
  expect(two).toEqual({ name: "x", base: { arena: "easy" }, matrix: { "controller.alpha": [0.5, 0.7] }, other: [1] });
  expect(valuesAt(two, "controller.alpha")).toEqual([0.5, 0.7]);
  expect(withValues(two, "controller.alpha", [])).toEqual(job);
  expect(valuesAt(job, "controller.alpha")).toEqual([]);
  expect(job).toEqual({ name: "x", base: { arena: "easy" }, other: [1] });
});

it("finds the field that an error is at", () => {
  const fields = ["arena", "controller.method", "controller.train.epochs", "robots"];
  for (const [pointer, field] of [
    ["/base/arena/walls_m/0", "arena"], ["/matrix/controller.method/1", "controller.method"],
    ["/base/controller/train/epochs", "controller.train.epochs"], ["/base/nothing", null],
  ] as const) {
    expect(fieldOf(pathOf(pointer), fields)).toBe(field);
  }
});

it("reads values as people write them", () => {
  expect(parseValues("0.5, 1e3 ,im,,true")).toEqual([0.5, 1000, "im", true]);
});
