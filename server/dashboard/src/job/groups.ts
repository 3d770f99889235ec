// Which group a run belongs to, and what stands out in it.

import type { Run, Summary } from "../types";
import { whole } from "../words";

/** A value as a label. */
export const plain = (value: unknown): string => (typeof value === "string" ? value : JSON.stringify(value));

/** Fields that a job varies. */
export function varied(summary: Summary): string[] {
  const names = new Set(summary.groups.flatMap((group) => Object.keys(group.values)));
  return [...names];
}

/** The group of a run: its combination, or its value of a field. */
export function grouping(summary: Summary, by: string | null): (run: Run) => string {
  if (!by) return (run) => run.label;
  const values = new Map(summary.groups.map((group) => [group.label, plain(group.values[by] ?? "")]));
  return (run) => values.get(run.label) ?? run.label;
}

/** A measure of a run. */
export function measureOf(run: Run, name: string): number | null {
  const result = run.result;
  if (!result) return null;
  const [level, share] = name.split("_", 2);
  if (share === "fraction") return (result.fractions as Record<string, number>)[level!] ?? null;
  if (name in result) {
    const value = (result as unknown as Record<string, unknown>)[name];
    if (typeof value === "number") return value;
  }
  if (name === "cpu_ns_per_robot_step") return run.cpu_ns_per_robot_step ?? null;
  if (name === "memory_bytes") return result.memory.most_bytes;
  if (name === "collisions_per_robot_step") return result.steps > 0 ? result.collisions / result.steps : null;
  const value = (result.metrics as Record<string, unknown> | null | undefined)?.[name];
  return typeof value === "number" ? value : null;
}

/** What is said of a run that needs a look. */
export interface Odd {
  said: string;
  /** Its place among those that do, from 0. */
  rank: number;
  /** Whether the run can be asked why. */
  why: boolean;
}

/** Runs that need a look, by id: those of the summary in its order, then those that failed or were cancelled. */
export function standsOut(runs: Run[], summary: Summary | null): Map<string, Odd> {
  const found = new Map<string, Odd>();
  const add = (id: string, said: string, why: boolean): void => {
    if (!found.has(id)) found.set(id, { said, rank: found.size, why });
  };
  for (const odd of summary?.odd_runs ?? []) {
    add(odd.run_id, odd.explanation ?? `p1 ${whole(odd.p1)}, the median of its group is ${whole(odd.median_p1)}`, true);
  }
  for (const state of ["failed", "cancelled"]) {
    for (const run of runs) if (run.state === state) add(run.id, run.error ?? state, false);
  }
  return found;
}
