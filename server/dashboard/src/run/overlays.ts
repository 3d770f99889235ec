// What is drawn over the robots of a scene: sensor rays, who tells whom by radio, movable objects,
// and the hatching of what no robot can reach.

import { MOUNTS, RANGE_M } from "./body";
import type { Frame } from "./frames";

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

/** Directions of sensors, the stronger the nearer something is. */
export function drawRays(pen: CanvasRenderingContext2D, f: Frame, { k, top, density }: Sheet, colours: Colours): void {
  pen.lineWidth = 1.5 * density;
  // Few strokes: rays of about the same strength are one path.
  for (let level = 0; level < 4; level++) {
    pen.globalAlpha = [0.18, 0.45, 0.7, 1][level]!;
    pen.strokeStyle = level === 0 ? colours.line : colours.warm;
    pen.beginPath();
    for (let n = 0; n < f.robots; n++) {
      const [x, y, heading] = [f.poses[n * 3]!, f.poses[n * 3 + 1]!, f.poses[n * 3 + 2]!];
      const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
      for (let s = 0; s < 8; s++) {
        const value = f.sensors[n * 8 + s]!;
        const strength = value < 100 ? 0 : value < 500 ? 1 : value < 1500 ? 2 : 3;
        if (strength !== level) continue;
        const mount = MOUNTS[s]!;
        const mx = x + mount.x_m * cos - mount.y_m * sin;
        const my = y + mount.x_m * sin + mount.y_m * cos;
        const angle = heading + mount.heading_rad;
        pen.moveTo(mx * k, top - my * k);
        pen.lineTo((mx + RANGE_M * Math.cos(angle)) * k, top - (my + RANGE_M * Math.sin(angle)) * k);
      }
    }
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

/** Who hears a robot: every step each tells all who are in range. */
export function hearers(f: Frame, robot: number, range_m: number): number[] {
  const [x, y] = [f.poses[robot * 3]!, f.poses[robot * 3 + 1]!];
  const found: number[] = [];
  for (let n = 0; n < f.robots; n++) {
    if (n !== robot && (f.poses[n * 3]! - x) ** 2 + (f.poses[n * 3 + 1]! - y) ** 2 <= range_m ** 2) found.push(n);
  }
  return found;
}

/** The range of the chosen robot's radio, and lines between robots that tell each other. */
export function drawRadio(pen: CanvasRenderingContext2D, f: Frame, robot: number, range_m: number, { k, top, density }: Sheet, colours: Colours): void {
  const line = (from: number, to: number): void => {
    pen.moveTo(f.poses[from * 3]! * k, top - f.poses[from * 3 + 1]! * k);
    pen.lineTo(f.poses[to * 3]! * k, top - f.poses[to * 3 + 1]! * k);
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
    pen.arc(f.poses[robot * 3]! * k, top - f.poses[robot * 3 + 1]! * k, range_m * k, 0, 2 * Math.PI);
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
