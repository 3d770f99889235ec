import { expect, it } from "vitest";
import { grouping, measureOf, standsOut, varied } from "./groups";
import type { Run, Summary } from "../types";

const run = (id: string, p1: number, label = "a"): Run =>
  ({ id, label, state: "done", cpu_ns_per_robot_step: 80, result: { p1, fractions: { p1: p1 / 100 }, metrics: { t90_steps: 7, overlap: null }, memory: { most_bytes: 9 }, steps: 10, collisions: 5 } }) as unknown as Run;

it("finds measures where a result has them", () => {
  const one = run("x", 50);
  expect(["p1", "p1_fraction", "t90_steps", "overlap", "memory_bytes", "collisions_per_robot_step", "cpu_ns_per_robot_step", "nothing"].map((name) => measureOf(one, name)))
    .toEqual([50, 0.5, 7, null, 9, 0.5, 80, null]);
});

it("puts the runs of the summary first, in its order, then those that failed and were cancelled", () => {
  const runs = [run("a", 50), run("b", 5), run("c", 9),
    { ...run("x", 0), state: "cancelled", result: null }, { ...run("f", 0), state: "failed", result: null, error: "no room" }] as unknown as Run[];
  const summary = { odd_runs: [
    { run_id: "c", p1: 9, median_p1: 49.5, explanation: null }, { run_id: "b", p1: 5, median_p1: 50, explanation: "It stood in a corner." },
  ] } as unknown as Summary;
  expect([...standsOut(runs, summary)].map(([id, { said, rank, why }]) => [id, said, rank, why])).toEqual([
    ["c", "p1 9, the median of its group is 50", 0, true], ["b", "It stood in a corner.", 1, true], ["f", "no room", 2, false], ["x", "cancelled", 3, false],
  ]);
  expect([...standsOut(runs, null).keys()]).toEqual(["f", "x"]);
});

it("groups runs by a field that is varied", () => {
  const summary = { groups: [{ label: "im, 2", values: { "controller.method": "im", robots: 2 } }] } as unknown as Summary;
  expect(varied(summary)).toEqual(["controller.method", "robots"]);
  expect(grouping(summary, "robots")(run("x", 1, "im, 2"))).toBe("2");
  expect(grouping(summary, null)(run("x", 1, "im, 2"))).toBe("im, 2");
});
