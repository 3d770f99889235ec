import { expect, it } from "vitest";
import { countedSteps, placeOf, spanOf, type Head } from "./player";

it("finds the last moment that is not after a step", () => {
  const steps = [0, 10, 20, 30];
  expect([-5, 0, 9, 10, 29, 30, 99].map((step) => placeOf(steps, step))).toEqual([0, 0, 0, 1, 2, 3, 3]);
});

it("cuts slices whose moments fit into an answer, however short epochs are", () => {
  for (const robots of [1, 4, 1_000]) {
    for (const steps_per_epoch of [1, 7, 100, 2_000]) {
      for (const every_steps of [1, 5, 3_000]) {
        const span = spanOf({ robots, objects: 0, every_steps, steps_per_epoch });
        const samples = Math.floor(steps_per_epoch / every_steps) + 1;
        const moments = Math.ceil((span * samples) / steps_per_epoch) + 2;
        expect(span % every_steps).toBe(0);
        if (every_steps <= steps_per_epoch) expect(moments * robots).toBeLessThanOrEqual(100_000 + 2 * robots);
      }
    }
  }
});

it("counts the steps of exploration alone", () => {
  const head = { steps_per_epoch: 100, phases: [
    { phase: "evolution", from_epoch: 0, epochs: 10, in_training: true, shows: true },
    { phase: "exploration", from_epoch: 10, epochs: 5, in_training: false, shows: false },
  ] } as unknown as Head;
  expect([0, 1_000, 1_250, 9_999].map((step) => countedSteps(head, step))).toEqual([0, 0, 250, 500]);
});
