// A recording as frames: slices of it are read ahead and kept, few at a time.

import { read } from "../server";
import type { RecordingSlice } from "../types";
import type { Frame } from "./frames";

/** Most moments and poses of a slice; the server has the same bounds. */
const MOST_MOMENTS = 4_000;
const MOST_POSES = 100_000;
/** Slices that are kept. */
const KEPT = 12;

export class Player {
  private slices = new Map<number, Promise<RecordingSlice>>();
  private ready = new Map<number, RecordingSlice>();
  private head: RecordingSlice["recording"] | null = null;

  constructor(readonly run: string, readonly name: string, private readonly trouble: (error: unknown) => void) {}

  /** What it is a recording of; again, as one that is being made grows. */
  async open(signal?: AbortSignal): Promise<RecordingSlice["recording"]> {
    const slice = await read<RecordingSlice>(this.path({ steps: "1", robots: "0" }), signal);
    this.head = slice.recording;
    return slice.recording;
  }

  get from(): number {
    return this.head ? this.head.from_epoch * this.head.steps_per_epoch : 0;
  }

  /** The step behind the last. */
  get to(): number {
    return this.head?.to_step ?? 0;
  }

  get recording(): RecordingSlice["recording"] | null {
    return this.head;
  }

  /** The frame at a step or the last before it, where it has been read; what comes next is asked for. */
  frameAt(step: number): Frame | null {
    if (!this.head) return null;
    const span = this.span();
    const number = Math.floor((step - this.from) / span);
    this.want(number);
    if (step + span < this.to) this.want(number + 1);
    const slice = this.ready.get(number);
    return slice ? frameOf(slice, step) : null;
  }

  /** Steps of a slice. */
  private span(): number {
    const { robots, objects, every_steps } = this.head!;
    const poses = Math.max(1, Math.min(robots, 1_000) + objects);
    return Math.max(1, Math.min(MOST_MOMENTS, Math.floor(MOST_POSES / poses) - 2)) * every_steps;
  }

  private want(number: number): void {
    if (number < 0 || this.slices.has(number)) return;
    const span = this.span();
    const recorded = this.head!.robot_numbers ?? Array.from({ length: this.head!.robots }, (_, n) => n);
    const robots = recorded.slice(0, 1_000).join(",");
    const slice = read<RecordingSlice>(this.path({ from_step: String(this.from + number * span), steps: String(span), robots }));
    this.slices.set(number, slice);
    slice.then(
      (found) => {
        this.ready.set(number, found);
        for (const old of this.slices.keys()) {
          if (this.slices.size <= KEPT) break;
          this.slices.delete(old);
          this.ready.delete(old);
        }
      },
      (error) => {
        this.slices.delete(number);
        this.trouble(error);
      },
    );
  }

  private path(query: Record<string, string>): string {
    const route = this.name === "live" ? "recording.json" : `recordings/${this.name}.json`;
    return `/v1/runs/${this.run}/${route}?${new URLSearchParams(query)}`;
  }
}

/** The last moment of a slice that is not after a step. */
export function placeOf(steps: readonly number[], step: number): number {
  let [low, high] = [0, steps.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (steps[middle]! <= step) low = middle;
    else high = middle - 1;
  }
  return low;
}

function frameOf(slice: RecordingSlice, step: number): Frame | null {
  if (slice.step.length === 0) return null;
  const at = placeOf(slice.step, step);
  const { robots, recording } = slice;
  const count = robots.length;
  const poses = new Float32Array(count * 3);
  const commands = new Float32Array(count * 2);
  const sensors = new Uint16Array(count * 8);
  robots.forEach((robot, n) => {
    poses[n * 3] = robot.x_m[at] ?? 0;
    poses[n * 3 + 1] = robot.y_m[at] ?? 0;
    poses[n * 3 + 2] = robot.heading_rad[at] ?? 0;
    commands[n * 2] = robot.left[at] ?? 0;
    commands[n * 2 + 1] = robot.right[at] ?? 0;
    sensors.set(robot.sensors[at] ?? [], n * 8);
  });
  const objects = new Float32Array(slice.objects.length * 3);
  slice.objects.forEach((object, n) => objects.set([object.x_m[at] ?? 0, object.y_m[at] ?? 0, object.heading_rad[at] ?? 0], n * 3));
  const epoch = slice.epochs.find((one) => one.epoch === slice.epoch[at]);
  return {
    step: slice.step[at]!,
    robotSteps: 0,
    robotStepsTotal: 0,
    time_s: slice.step[at]! * recording.step_s,
    phase: epoch?.phase ?? "",
    epochsDone: epoch?.phase_epoch ?? 0,
    epochsTotal: 0,
    isTraining: epoch?.in_training ?? false,
    learns: false,
    robots: count,
    poses, commands, sensors, objects,
    choice: (robot) => {
      const [state, action] = [robots[robot]?.state[at], robots[robot]?.action[at]];
      return state == null || action == null ? null : [state, action];
    },
  };
}
