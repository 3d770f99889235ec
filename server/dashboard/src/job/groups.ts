// Which group a run belongs to, and what stands out in it.

import type { Run, Summary } from "../types";

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
  if (name === "memory_bytes") return result.memory.most_bytes;
  if (name === "collisions_per_robot_step") return result.steps > 0 ? result.collisions / result.steps : null;
  const value = (result.metrics as Record<string, unknown> | null | undefined)?.[name];
  return typeof value === "number" ? value : null;
}

const median = (sorted: number[]): number => {
  const middle = Math.floor(sorted.length / 2);
  return sorted.length % 2 ? sorted[middle]! : (sorted[middle - 1]! + sorted[middle]!) / 2;
};

/** What is odd about runs, by id: those that failed, and those far from the median of their group. */
export function odd(runs: Run[], group: (run: Run) => string, measure: string): Map<string, string> {
  const found = new Map<string, string>();
  const groups = new Map<string, Run[]>();
  for (const run of runs) {
    if (run.state === "failed") found.set(run.id, run.error ?? "failed");
    else if (run.state === "cancelled") found.set(run.id, "cancelled");
    const name = group(run);
    groups.set(name, [...(groups.get(name) ?? []), run]);
  }
  for (const members of groups.values()) {
    const valued = members.flatMap((run) => {
      const value = measureOf(run, measure);
      return value === null ? [] : [{ run, value }];
    });
    if (valued.length < 5) continue;
    const middle = median(valued.map((one) => one.value).sort((a, b) => a - b));
    const spread = median(valued.map((one) => Math.abs(one.value - middle)).sort((a, b) => a - b));
    if (spread === 0) continue;
    for (const { run, value } of valued) {
      // Iglewicz and Hoaglin (1993): a modified z-score beyond 3.5.
      const score = (0.6745 * (value - middle)) / spread;
      if (Math.abs(score) > 3.5) found.set(run.id, `${score > 0 ? "far above" : "far below"} its group's median`);
    }
  }
  return found;
}
