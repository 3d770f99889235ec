import { expect, it } from "vitest";
import { placeOf } from "./player";

it("finds the last moment that is not after a step", () => {
  const steps = [0, 10, 20, 30];
  expect([-5, 0, 9, 10, 29, 30, 99].map((step) => placeOf(steps, step))).toEqual([0, 0, 0, 1, 2, 3, 3]);
});
