// A recording as frames: slices of it are read ahead and kept, few at a time.

import { read } from "../server";
import type { RecordingSlice } from "../types";
import { Bodies, COMMANDS, FLOATS, SENSORS, WORDS, type Frame } from "./messages";

/** Most moments and poses of a slice; the server has the same bounds. */
const MOST_MOMENTS = 4_000;
const MOST_POSES = 100_000;
/** Robots that are shown. */
const MOST_ROBOTS = 1_000;
/** Slices that are kept. */
const KEPT = 12;

export type Head = RecordingSlice["recording"];

export class Player {
  private slices = new Map<number, Promise<void>>();
  private ready = new Map<number, RecordingSlice>();
  private head: Head | null = null;
  /** One moment is looked at at a time. */
  private readonly bodies = new Bodies();

  constructor(readonly run: string, readonly name: string, private readonly trouble: (error: unknown) => void) {}

  /** What it is a recording of; again, as one that is being made grows. */
  async open(signal?: AbortSignal): Promise<Head> {
    const before = this.head?.to_step;
    this.head = (await read<RecordingSlice>(this.path({ steps: "1" }), signal)).recording;
    if (before !== undefined && before !== this.head.to_step) {
      // The last slice was read before it was full.
      const last = this.numberOf(before - 1);
      this.slices.delete(last);
      this.ready.delete(last);
    }
    return this.head;
  }

  get from(): number {
    return this.head ? this.head.from_epoch * this.head.steps_per_epoch : 0;
  }

  /** The last step. */
  get last(): number {
    return Math.max(this.from, (this.head?.to_step ?? 1) - 1);
  }

  get recording(): Head | null {
    return this.head;
  }

  /** The frame at a step or the last before it, where it has been read; what comes next is asked for. */
  frameAt(step: number): Frame | null {
    if (!this.head) return null;
    const number = this.numberOf(step);
    void this.want(number);
    if (number < this.numberOf(this.last)) void this.want(number + 1);
    const slice = this.ready.get(number);
    return slice ? frameOf(slice, step, this.bodies) : null;
  }

  /** The same, read where it has not been; null where it cannot be. */
  async load(step: number): Promise<Frame | null> {
    if (!this.head) return null;
    await this.want(this.numberOf(step));
    return this.frameAt(step);
  }

  /** The slice of a step. The end of the last epoch has none of its own. */
  private numberOf(step: number): number {
    const last = Math.max(this.last - 1, this.from);
    return Math.floor((Math.min(Math.max(step, this.from), last) - this.from) / spanOf(this.head!));
  }

  private want(number: number): Promise<void> {
    const there = this.slices.get(number);
    if (there) return there;
    const head = this.head!;
    const span = spanOf(head);
    const recorded = head.robot_numbers ?? Array.from({ length: head.robots }, (_, n) => n);
    // The end of an epoch is at the step at which the next begins, which may be that of the next slice.
    const query = { from_step: String(this.from + number * span), steps: String(span + 1), robots: recorded.slice(0, MOST_ROBOTS).join(",") };
    const slice = read<RecordingSlice>(this.path(query)).then(
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
    this.slices.set(number, slice);
    return slice;
  }

  private path(query: Record<string, string>): string {
    const route = this.name === "live" ? "recording.json" : `recordings/${this.name}.json`;
    return `/v1/runs/${this.run}/${route}?${new URLSearchParams(query)}`;
  }
}

/** Steps of a slice, so that its moments fit into an answer: an epoch has one more than its steps. */
export function spanOf(head: Pick<Head, "robots" | "objects" | "every_steps" | "steps_per_epoch">): number {
  const poses = Math.max(1, Math.min(head.robots, MOST_ROBOTS) + head.objects);
  const moments = Math.max(4, Math.min(MOST_MOMENTS, Math.floor(MOST_POSES / poses)));
  const samples = Math.floor(head.steps_per_epoch / head.every_steps) + 1;
  const span = Math.floor(((moments - 2) * head.steps_per_epoch) / samples);
  return Math.max(head.every_steps, Math.floor(span / head.every_steps) * head.every_steps);
}

/** Steps that counted before a step of a recording: those of exploration, in the target arena. */
export function countedSteps(head: Head, step: number): number {
  return head.phases.filter((phase) => phase.phase === "exploration").reduce((sum, phase) => {
    const first = phase.from_epoch * head.steps_per_epoch;
    return sum + Math.min(Math.max(step - first, 0), phase.epochs * head.steps_per_epoch);
  }, 0);
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

function frameOf(slice: RecordingSlice, step: number, bodies: Bodies): Frame | null {
  if (slice.step.length === 0) return null;
  const at = placeOf(slice.step, step);
  const { robots, recording } = slice;
  const count = robots.length;
  bodies.clear(count);
  const { floats, words } = bodies;
  robots.forEach((robot, n) => {
    const first = n * FLOATS;
    floats[first] = robot.x_m[at] ?? 0;
    floats[first + 1] = robot.y_m[at] ?? 0;
    floats[first + 2] = robot.heading_rad[at] ?? 0;
    floats[first + COMMANDS] = robot.left[at] ?? 0;
    floats[first + COMMANDS + 1] = robot.right[at] ?? 0;
    words.set(robot.sensors[at] ?? [], n * WORDS + SENSORS);
    bodies.choose(n, robot.state[at], robot.action[at]);
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
    floats, words, objects,
  };
}
