import { expect, it } from "vitest";
import { grouping, measureOf, odd, varied } from "./groups";
import type { Run, Summary } from "../types";

const run = (id: string, p1: number, label = "a"): Run =>
  ({ id, label, state: "done", result: { p1, fractions: { p1: p1 / 100 }, metrics: { t90_steps: 7, overlap: null }, memory: { most_bytes: 9 }, steps: 10, collisions: 5 } }) as unknown as Run;

it("finds measures where a result has them", () => {
  const one = run("x", 50);
  expect(["p1", "p1_fraction", "t90_steps", "overlap", "memory_bytes", "collisions_per_robot_step", "nothing"].map((name) => measureOf(one, name)))
    .toEqual([50, 0.5, 7, null, 9, 0.5, null]);
});

it("marks runs that failed or lie far from their group's median", () => {
  const runs = [48, 50, 51, 49, 52, 50, 5].map((p1, n) => run(String(n), p1));
  const failed = { ...run("f", 0), state: "failed", result: null, error: "no room" } as unknown as Run;
  expect([...odd([...runs, failed], (one) => one.label, "p1")]).toEqual([["f", "no room"], ["6", "far below its group's median"]]);
});

it("groups runs by a field that is varied", () => {
  const summary = { groups: [{ label: "im, 2", values: { "controller.method": "im", robots: 2 } }] } as unknown as Summary;
  expect(varied(summary)).toEqual(["controller.method", "robots"]);
  expect(grouping(summary, "robots")(run("x", 1, "im, 2"))).toBe("2");
  expect(grouping(summary, null)(run("x", 1, "im, 2"))).toBe("im, 2");
});
