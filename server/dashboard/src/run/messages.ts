// The binary messages of `/v1/runs/{id}/frames`, as docs/live-frames.md has them.

const ROBOT_BYTES = 40;
const HEAD_BYTES = 56;
const OBJECT_BYTES = 12;
const NO_CHOICE = 0xffff;
/** Numbers of a robot in `floats`, and in `words`, which are the same bytes. */
export const FLOATS = ROBOT_BYTES / 4;
export const WORDS = ROBOT_BYTES / 2;
/** Where in `floats` a robot's commands are, behind x, y and heading. */
export const COMMANDS = 3;
/** Where in `words` what it senses is, and its state and action. */
export const SENSORS = 10;
const CHOICE = 18;
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
  /** `FLOATS` of each robot: x, y, heading, commands left and right; the others are `words`. */
  floats: Float32Array;
  /** `WORDS` of each robot: from `SENSORS` on ps0 to ps7, then state and action. */
  words: Uint16Array;
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
  const flags = u32(44);
  const robots = u32(48);
  const objects = u32(52);
  const [first, bytes] = [body.byteOffset + HEAD_BYTES, robots * ROBOT_BYTES + objects * OBJECT_BYTES];
  // Read where they are, as all browsers have numbers in the order in which they are sent.
  const isAligned = first % 4 === 0;
  const buffer = isAligned ? body.buffer : body.buffer.slice(first, first + bytes);
  const at = isAligned ? first : 0;
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
    robots,
    floats: new Float32Array(buffer, at, robots * FLOATS),
    words: new Uint16Array(buffer, at, robots * WORDS),
    objects: new Float32Array(buffer, at + robots * ROBOT_BYTES, objects * 3),
  };
}

/** State and action of a robot; null without a table. */
export function choiceOf({ words }: Frame, robot: number): readonly [number, number] | null {
  const [state = NO_CHOICE, action = NO_CHOICE] = [words[robot * WORDS + CHOICE], words[robot * WORDS + CHOICE + 1]];
  return state === NO_CHOICE ? null : [state, action];
}

/** Where robots of a recording are put, moment after moment. */
export class Bodies {
  floats = new Float32Array(0);
  words = new Uint16Array(0);

  /** For so many robots, all of them at nought. */
  clear(robots: number): void {
    if (this.floats.length !== robots * FLOATS) {
      const buffer = new ArrayBuffer(robots * ROBOT_BYTES);
      this.floats = new Float32Array(buffer);
      this.words = new Uint16Array(buffer);
    }
    this.floats.fill(0);
  }

  choose(robot: number, state: number | null | undefined, action: number | null | undefined): void {
    const is = state != null && action != null;
    this.words[robot * WORDS + CHOICE] = is ? state : NO_CHOICE;
    this.words[robot * WORDS + CHOICE + 1] = is ? action : NO_CHOICE;
  }
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

/** Cuts parts of a stream into messages; one that comes in parts is copied once, the others are not. */
export class Cutter {
  /** The beginning of a message whose length is not known yet. */
  private held = new Uint8Array(0);
  private message: Uint8Array<ArrayBuffer> | null = null;
  private filled = 0;

  constructor(private readonly each: (kind: number, body: DataView<ArrayBuffer>) => void) {}

  push(part: Uint8Array<ArrayBuffer>): void {
    let bytes = part;
    if (this.held.length > 0) {
      bytes = new Uint8Array(this.held.length + part.length);
      bytes.set(this.held);
      bytes.set(part, this.held.length);
      this.held = new Uint8Array(0);
    }
    let at = 0;
    if (this.message) {
      at = Math.min(this.message.length - this.filled, bytes.length);
      this.message.set(bytes.subarray(0, at), this.filled);
      this.filled += at;
      if (this.filled < this.message.length) return;
      const whole = this.message;
      this.message = null;
      this.tell(whole, 0, whole.length);
    }
    while (bytes.length - at >= 4) {
      const end = 4 + new DataView(bytes.buffer, bytes.byteOffset + at).getUint32(0, true);
      if (bytes.length - at < end) {
        this.message = new Uint8Array(end);
        this.message.set(bytes.subarray(at));
        this.filled = bytes.length - at;
        return;
      }
      this.tell(bytes, at, end);
      at += end;
    }
    this.held = bytes.slice(at);
  }

  private tell(bytes: Uint8Array<ArrayBuffer>, at: number, end: number): void {
    const view = new DataView(bytes.buffer, bytes.byteOffset + at, end);
    this.each(view.getUint32(4, true), new DataView(bytes.buffer, view.byteOffset + 8, end - 8));
  }
}
