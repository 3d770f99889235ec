// What the service answers, as far as the page reads it.

export type State = "queued" | "running" | "paused" | "done" | "failed" | "cancelled";

export interface Job {
  id: string;
  name: string;
  state: State;
  created_at: string;
  runs: Record<"total" | "queued" | "running" | "paused" | "done" | "failed" | "cancelled", number>;
  progress: number;
  eta_s: number | null;
  robot_steps_per_s: number | null;
}

export interface Progress {
  phase: string;
  epochs_done: number;
  epochs_total: number;
  robot_steps_done: number;
  robot_steps_total: number;
  fraction: number;
  eta_s: number | null;
  robot_steps_per_s: number | null;
}

export interface Run {
  id: string;
  job_id: string;
  index: number;
  seed: number;
  arena: string;
  method: string;
  label: string;
  state: State;
  progress: Progress | null;
  result: Result | null;
  error: string | null;
}

export interface Result {
  p1: number;
  p2: number;
  p5: number;
  p10: number;
  reachable: number;
  fractions: Record<"p1" | "p2" | "p5" | "p10", number>;
  metrics: Record<string, number | null>;
  memory: { plan: { bytes: number }; most_bytes: number; least_bytes: number };
}

export interface Page<T> {
  items: T[];
  next: string | null;
}

export interface Measure {
  name: string;
  n: number;
  mean: number | null;
  sd: number | null;
  median: number | null;
  interval: [number, number] | null;
}

export interface Group {
  label: string;
  values: Record<string, unknown>;
  robots: number;
  runs: number;
  runs_done: number;
  measures: Measure[];
}

export interface Summary {
  job_id: string;
  name: string;
  runs: number;
  runs_done: number;
  groups: Group[];
}

export interface Arena {
  name: string;
  width_m: number;
  height_m: number;
  squares: number | [number, number];
  walls_m: [number, number, number, number][];
  starts: { x_m: number; y_m: number; heading_rad: number }[];
  objects?: Record<string, unknown>[];
}

export interface Coverage {
  width_m: number;
  height_m: number;
  squares: [number, number];
  visits: number[][];
  reachable?: boolean[][];
  [name: string]: unknown;
}

export interface Parameter {
  name: string;
  default: number | string;
  domain: { kind: "real" | "whole" | "choice"; min?: number; max?: number; names?: string[] };
  unit: string;
  about: string;
  source: string;
}

export interface Controllers {
  methods: { name: string; about: string; trains: string }[];
  parameters: Parameter[];
  presets: string[];
  robot_parameters: Parameter[];
}

export interface Template {
  name: string;
  about: string;
  runs: number;
  job: Record<string, unknown>;
}
