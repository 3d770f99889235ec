// What is drawn over the robots of a scene: sensor rays, who tells whom by radio, movable objects,
// and the hatching of what no robot can reach.

import { FLOATS, SENSORS, WORDS, type Frame } from "./messages";
import { RAYS, SENSED, STRENGTHS, strengthOf } from "./pixels";

/** Where a picture is drawn: pixels a metre, the lower edge, device pixels a pixel. */
export interface Sheet {
  k: number;
  top: number;
  density: number;
}

export interface Colours {
  line: string;
  warm: string;
}

/** Robots up to which all who tell each other are joined; beyond that those of the chosen one. */
const JOINED = 200;

/** Rays of each strength, gathered so that each strength is one stroke; kept from picture to picture. */
const gathered = STRENGTHS.map(() => ({ ends: new Float32Array(0), count: 0 }));

/** Directions of sensors, the stronger the nearer something is. */
export function drawRays(pen: CanvasRenderingContext2D, f: Frame, { k, top, density }: Sheet, colours: Colours): void {
  const { floats, words, robots } = f;
  for (const list of gathered) {
    list.count = 0;
    if (list.ends.length < robots * SENSED * 4) list.ends = new Float32Array(robots * SENSED * 4);
  }
  for (let n = 0; n < robots; n++) {
    const at = n * FLOATS;
    const [x, y] = [floats[at]! * k, top - floats[at + 1]! * k];
    const heading = floats[at + 2]!;
    const [cos, sin] = [Math.cos(heading) * k, Math.sin(heading) * k];
    for (let s = 0; s < SENSED; s++) {
      const value = words[n * WORDS + SENSORS + s]!;
      const list = gathered[strengthOf(value)]!;
      const { ends, count } = list;
      const [x1, y1, x2, y2] = [RAYS[s * 4]!, RAYS[s * 4 + 1]!, RAYS[s * 4 + 2]!, RAYS[s * 4 + 3]!];
      ends[count] = x + x1 * cos - y1 * sin;
      ends[count + 1] = y - x1 * sin - y1 * cos;
      ends[count + 2] = x + x2 * cos - y2 * sin;
      ends[count + 3] = y - x2 * sin - y2 * cos;
      list.count = count + 4;
    }
  }
  pen.lineWidth = 1.5 * density;
  gathered.forEach(({ ends, count }, level) => {
    if (count === 0) return;
    pen.globalAlpha = STRENGTHS[level]!;
    pen.strokeStyle = level === 0 ? colours.line : colours.warm;
    pen.beginPath();
    for (let n = 0; n < count; n += 4) {
      pen.moveTo(ends[n]!, ends[n + 1]!);
      pen.lineTo(ends[n + 2]!, ends[n + 3]!);
    }
    pen.stroke();
  });
  pen.globalAlpha = 1;
}

/** Who hears a robot: every step each tells all who are in range. */
export function hearers(f: Frame, robot: number, range_m: number): number[] {
  const [x, y] = [f.floats[robot * FLOATS]!, f.floats[robot * FLOATS + 1]!];
  const found: number[] = [];
  for (let n = 0; n < f.robots; n++) {
    if (n !== robot && (f.floats[n * FLOATS]! - x) ** 2 + (f.floats[n * FLOATS + 1]! - y) ** 2 <= range_m ** 2) found.push(n);
  }
  return found;
}

/** The range of the chosen robot's radio, and lines between robots that tell each other. */
export function drawRadio(pen: CanvasRenderingContext2D, f: Frame, robot: number, range_m: number, { k, top, density }: Sheet, colours: Colours): void {
  const line = (from: number, to: number): void => {
    pen.moveTo(f.floats[from * FLOATS]! * k, top - f.floats[from * FLOATS + 1]! * k);
    pen.lineTo(f.floats[to * FLOATS]! * k, top - f.floats[to * FLOATS + 1]! * k);
  };
  pen.lineWidth = density;
  if (f.robots <= JOINED) {
    pen.strokeStyle = colours.line;
    pen.beginPath();
    for (let n = 0; n < f.robots; n++) for (const other of hearers(f, n, range_m)) if (other > n) line(n, other);
    pen.stroke();
  }
  if (robot >= f.robots) return;
  pen.strokeStyle = colours.warm;
  if (Number.isFinite(range_m)) {
    pen.setLineDash([4 * density, 4 * density]);
    pen.beginPath();
    pen.arc(f.floats[robot * FLOATS]! * k, top - f.floats[robot * FLOATS + 1]! * k, range_m * k, 0, 2 * Math.PI);
    pen.stroke();
    pen.setLineDash([]);
  }
  pen.lineWidth = 2 * density;
  pen.beginPath();
  for (const other of hearers(f, robot, range_m)) line(robot, other);
  pen.stroke();
}

const OBJECT_FILL = "#b9770e88";

/** Movable objects: boxes with their sides, else discs. */
export function drawObjects(pen: CanvasRenderingContext2D, f: Frame, about: readonly Record<string, unknown>[], { k, top, density }: Sheet, ink: string): void {
  pen.strokeStyle = ink;
  pen.fillStyle = OBJECT_FILL;
  pen.lineWidth = 1.5 * density;
  for (let n = 0; n * 3 < f.objects.length; n++) {
    const number = (name: string): number | null => (typeof about[n]?.[name] === "number" ? (about[n]![name] as number) : null);
    pen.save();
    pen.translate(f.objects[n * 3]! * k, top - f.objects[n * 3 + 1]! * k);
    pen.rotate(-f.objects[n * 3 + 2]!);
    pen.beginPath();
    const [width, height] = [number("width_m"), number("height_m") ?? number("length_m")];
    if (width !== null && height !== null) pen.rect((-width / 2) * k, (-height / 2) * k, width * k, height * k);
    else pen.arc(0, 0, (number("radius_m") ?? 0.02) * k, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
    pen.restore();
  }
}

/** Squares out of reach, hatched: `rows` has a text a row, the lowest y first, `0` for out of reach. */
export function hatched(rows: readonly string[], width: number, height: number, colour: string, density: number): HTMLCanvasElement {
  const sheet = document.createElement("canvas");
  const mask = document.createElement("canvas");
  [sheet.width, sheet.height] = [width, height];
  [mask.width, mask.height] = [rows[0]?.length ?? 0, rows.length];
  const [pen, small] = [sheet.getContext("2d"), mask.getContext("2d")];
  if (!pen || !small || mask.width === 0 || width === 0) return sheet;
  const image = small.createImageData(mask.width, mask.height);
  const pixels = new Uint32Array(image.data.buffer);
  rows.forEach((row, y) => {
    for (let x = row.indexOf("0"); x >= 0; x = row.indexOf("0", x + 1)) pixels[(rows.length - 1 - y) * mask.width + x] = 0xff000000;
  });
  small.putImageData(image, 0, 0);
  pen.strokeStyle = colour;
  pen.lineWidth = density;
  pen.globalAlpha = 0.55;
  pen.beginPath();
  for (let at = -height; at < width; at += 7 * density) {
    pen.moveTo(at, height);
    pen.lineTo(at + height, 0);
  }
  pen.stroke();
  pen.globalAlpha = 1;
  pen.imageSmoothingEnabled = false;
  pen.globalCompositeOperation = "destination-in";
  pen.drawImage(mask, 0, 0, width, height);
  return sheet;
}
