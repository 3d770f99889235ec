// The binary messages of `/v1/runs/{id}/frames`, as docs/live-frames.md has them.

import { stream, type Stream } from "../stream";

export const ROBOT_BYTES = 40;
const HEAD_BYTES = 56;
const OBJECT_BYTES = 12;
const NO_CHOICE = 0xffff;
const PHASES = ["babbling", "evolution", "repository", "exploration", "done"];

/** Where robots are at a moment. */
export interface Frame {
  step: number;
  robotSteps: number;
  robotStepsTotal: number;
  time_s: number;
  phase: string;
  epochsDone: number;
  epochsTotal: number;
  isTraining: boolean;
  learns: boolean;
  robots: number;
  /** x, y, heading of each robot. */
  poses: Float32Array;
  /** Commands left and right of each robot. */
  commands: Float32Array;
  /** ps0 to ps7 of each robot. */
  sensors: Uint16Array;
  /** State and action of each robot; null without a table. */
  choice(robot: number): readonly [number, number] | null;
  /** x, y, heading of each object. */
  objects: Float32Array;
}

/** What was covered by a moment. */
export interface Squares {
  steps: number;
  columns: number;
  rows: number;
  /** Entries of each square, the lowest row first. */
  visits: Uint32Array;
  /** Counted steps after which each was first entered; -1 for never. */
  first: Float32Array;
}

export function parseFrame(body: DataView<ArrayBuffer>): Frame {
  const f64 = (at: number): number => body.getFloat64(at, true);
  const u32 = (at: number): number => body.getUint32(at, true);
  const f32 = (at: number): number => body.getFloat32(at, true);
  const flags = u32(44);
  const robots = u32(48);
  const poses = new Float32Array(robots * 3);
  const commands = new Float32Array(robots * 2);
  const sensors = new Uint16Array(robots * 8);
  const choices = new Uint16Array(robots * 2);
  for (let robot = 0; robot < robots; robot++) {
    const at = HEAD_BYTES + robot * ROBOT_BYTES;
    for (let n = 0; n < 3; n++) poses[robot * 3 + n] = f32(at + 4 * n);
    for (let n = 0; n < 2; n++) commands[robot * 2 + n] = f32(at + 12 + 4 * n);
    for (let n = 0; n < 8; n++) sensors[robot * 8 + n] = body.getUint16(at + 20 + 2 * n, true);
    for (let n = 0; n < 2; n++) choices[robot * 2 + n] = body.getUint16(at + 36 + 2 * n, true);
  }
  const objects = new Float32Array(u32(52) * 3);
  const first = HEAD_BYTES + robots * ROBOT_BYTES;
  for (let n = 0; n < objects.length; n++) objects[n] = f32(first + Math.floor(n / 3) * OBJECT_BYTES + (n % 3) * 4);
  return {
    step: f64(0),
    robotSteps: f64(8),
    robotStepsTotal: f64(16),
    time_s: f64(24),
    phase: PHASES[u32(32)] ?? "unknown",
    epochsDone: u32(36),
    epochsTotal: u32(40),
    isTraining: (flags & 1) !== 0,
    learns: (flags & 2) !== 0,
    robots, poses, commands, sensors, objects,
    choice: (robot) => {
      const [state = NO_CHOICE, action = NO_CHOICE] = choices.subarray(robot * 2, robot * 2 + 2);
      return state === NO_CHOICE ? null : [state, action];
    },
  };
}

export function parseSquares(body: DataView<ArrayBuffer>): Squares {
  const columns = body.getUint32(8, true);
  const rows = body.getUint32(12, true);
  const count = columns * rows;
  const at = body.byteOffset + 16;
  return {
    steps: body.getFloat64(0, true),
    columns,
    rows,
    visits: new Uint32Array(body.buffer.slice(at, at + 4 * count)),
    first: new Float32Array(body.buffer.slice(at + 4 * count, at + 8 * count)),
  };
}

/** Cuts parts of a stream into messages. */
export class Cutter {
  private held = new Uint8Array(0);

  constructor(private readonly each: (kind: number, body: DataView<ArrayBuffer>) => void) {}

  push(part: Uint8Array): void {
    let bytes = part;
    if (this.held.length > 0) {
      bytes = new Uint8Array(this.held.length + part.length);
      bytes.set(this.held);
      bytes.set(part, this.held.length);
    }
    let at = 0;
    while (bytes.length - at >= 8) {
      const view = new DataView(bytes.buffer as ArrayBuffer, bytes.byteOffset + at);
      const end = 4 + view.getUint32(0, true);
      if (bytes.length - at < end) break;
      this.each(view.getUint32(4, true), new DataView(view.buffer, view.byteOffset + 8, end - 8));
      at += end;
    }
    this.held = bytes.slice(at);
  }
}

export interface Seen {
  frame(frame: Frame): void;
  squares(squares: Squares): void;
  /** Nobody steps the run at present. */
  waiting(): void;
  /** Whether the run has ended: the stream ends too when the server stops, and is then taken up again. */
  isOver(): boolean;
}

/** Watches a run until it ends. */
export function watchFrames(run: string, see: Seen): Stream {
  return stream(
    `/v1/runs/${run}/frames`,
    () => ({}),
    () => {
      const cutter = new Cutter((kind, body) => {
        if (kind === 1) see.frame(parseFrame(body));
        else if (kind === 2) see.squares(parseSquares(body));
        else if (kind === 3) see.waiting();
      });
      return (part) => cutter.push(part);
    },
    () => see.isOver(),
  );
}
