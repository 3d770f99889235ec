// What the service answers: types made from the OpenAPI document, under short names.

import type { components } from "./api";

type Schemas = components["schemas"];

export type State = Schemas["State"];
export type Job = Schemas["Job"];
export type Run = Schemas["RunSummary"];
export type Progress = Schemas["Progress"];
export type Result = Schemas["RunResult"];
export type Summary = Schemas["JobSummary"];
export type Group = Schemas["Group"];
export type Measure = Schemas["Measure"];
export type Interval = Schemas["Interval"];
export type Scaling = Schemas["Scaling"];
export type Curves = Schemas["JobCurves"];
export type Comparison = Schemas["Comparison"];
export type Pair = Schemas["ComparedPair"];
export type GroupCoverage = Schemas["GroupCoverage"];
export type Coverage = Schemas["Coverage"];
export type CurveRow = Schemas["CurveRow"];
export type MetricsRow = Schemas["MetricsRow"];
export type Learnt = Schemas["Learnt"];
export type Learning = Schemas["Learning"];
export type LearntTable = Schemas["LearntTable"];
export type RecordingSlice = Schemas["RecordingSlice"];
export type RecordingSummary = Schemas["RecordingSummary"];
export type Explanation = Schemas["Explanation"];
export type ExplanationPending = Schemas["ExplanationPending"];
export type Stayed = Schemas["StayedFor"];
export type Reach = Schemas["Reach"];
export type Workers = Schemas["Workers"];
export type Version = Schemas["Version"];
export type ArenaListing = Schemas["ArenaListing"];
export type ArenaCheck = Schemas["ArenaCheck"];
export type JobCheck = Schemas["JobCheck"];
export type Method = Schemas["MethodListing"];
export type Template = Schemas["TemplateListing"];
export type FieldError = Schemas["FieldError"];

/** A page of a list. */
export interface Page<T> {
  items: T[];
  next?: string | null;
}

/** What a parameter may be, which the document leaves open. */
export interface Domain {
  kind: "real" | "whole" | "choice";
  min?: number;
  max?: number;
  names?: string[];
}

export type Parameter = Omit<Schemas["ParameterListing"], "domain" | "default"> & {
  default: number | string;
  domain: Domain;
};
export type Controllers = Omit<Schemas["ControllerListing"], "parameters" | "robot_parameters" | "methods"> & {
  methods: (Omit<Method, "parameters"> & { parameters?: Parameter[] })[];
  parameters: Parameter[];
  robot_parameters: Parameter[];
};

/** An arena written out. */
export interface Arena {
  name?: string;
  width_m: number;
  height_m: number;
  squares?: number | [number, number];
  walls_m?: [number, number, number, number][];
  starts: Pose[];
  objects?: ArenaObject[];
}

export interface Pose {
  x_m: number;
  y_m: number;
  heading_rad: number;
}

export interface ArenaObject {
  kind?: string;
  x_m: number;
  y_m: number;
  heading_rad?: number;
  [name: string]: unknown;
}

/** A run's spec with every default filled in, as far as the page reads it. */
export interface RunSpec {
  seed: number;
  arena: string | (Partial<Arena> & Record<string, unknown>);
  controller: { method: string; train?: { arena?: string | (Partial<Arena> & Record<string, unknown>) } } & Record<string, unknown>;
  robots: number;
  epochs: number;
  steps_per_epoch: number;
  engine: string;
  memory_budget_bytes: number | null;
  sharing?: { mode: string; range_m?: number | null };
  robot?: { preset?: string; body_radius_m?: number } & Record<string, unknown>;
}
