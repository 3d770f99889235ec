// Many robots and their rays, written into the pixels of one picture: for a browser a stroke of
// thousands of lines costs ten times as much. Few robots are drawn as paths, which look better.

import { MOUNTS, RANGE_M } from "./body";
import { FLOATS, SENSORS, WORDS, type Frame } from "./messages";

/** Robots from which on they are pixels. */
export const PIXELS_FROM = 150;
const HEADINGS = 64;
/** Pixels of a body's radius from which on its heading can be seen. */
const HEADED_PX = 2.5;
/** Small bodies are put between pixels, or they would be seen to jump. */
const SMALL_PX = 6;
const BETWEEN = 4;

/** Where rays begin and end, of a robot that looks along x. */
export const RAYS = Float64Array.from(MOUNTS.flatMap(({ x_m, y_m, heading_rad }) =>
  [x_m, y_m, x_m + RANGE_M * Math.cos(heading_rad), y_m + RANGE_M * Math.sin(heading_rad)]));
export const SENSED = MOUNTS.length;
/** Raw values from which on rays are drawn stronger, and how strong they are. */
const STRONGER = [100, 500, 1500] as const;
export const STRENGTHS = [0.18, 0.45, 0.7, 1] as const;
export const strengthOf = (value: number): number =>
  value < STRONGER[0] ? 0 : value < STRONGER[1] ? 1 : value < STRONGER[2] ? 2 : 3;

export interface PixelColours {
  accent: string;
  floor: string;
  line: string;
  warm: string;
}

/** `rgb(…)` with an opacity of 0 to 1, as a pixel. */
function pixel(colour: string, opacity: number): number {
  const [r = 0, g = 0, b = 0] = (colour.match(/[\d.]+/g) ?? []).map(Number);
  return ((Math.round(opacity * 255) << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

const covered = (reach: number): number => Math.min(Math.max(reach + 0.5, 0), 1);

export class Pixels {
  private image: ImageData | null = null;
  private pixels = new Uint32Array(0);
  private width = 0;
  private height = 0;
  private made = "";
  private sprites = new Uint32Array(0);
  private side = 0;
  private headings = 1;
  private between = 1;
  private strengths: number[] = [];

  /** Draws all robots as discs of `r` pixels, at `k` pixels a metre from the lower edge on. */
  draw(pen: CanvasRenderingContext2D, frame: Frame, k: number, r: number, density: number, withRays: boolean, colours: PixelColours): void {
    const { width, height } = pen.canvas;
    if (!this.image || this.width !== width || this.height !== height) {
      this.image = pen.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      [this.width, this.height] = [width, height];
    } else {
      this.pixels.fill(0);
    }
    this.make(r, density, colours);
    if (withRays) this.rays(frame, k);
    this.bodies(frame, k);
    pen.putImageData(this.image, 0, 0);
  }

  private rays({ floats, words, robots }: Frame, k: number): void {
    const { pixels, width, height, strengths } = this;
    for (let n = 0; n < robots; n++) {
      const at = n * FLOATS;
      const x = floats[at]! * k;
      const y = height - floats[at + 1]! * k;
      const heading = floats[at + 2]!;
      const cos = Math.cos(heading) * k;
      const sin = Math.sin(heading) * k;
      for (let s = 0; s < SENSED; s++) {
        const level = strengthOf(words[n * WORDS + SENSORS + s]!);
        const colour = strengths[level]!;
        let px = x + RAYS[s * 4]! * cos - RAYS[s * 4 + 1]! * sin;
        let py = y - RAYS[s * 4]! * sin - RAYS[s * 4 + 1]! * cos;
        const dx = x + RAYS[s * 4 + 2]! * cos - RAYS[s * 4 + 3]! * sin - px;
        const dy = y - RAYS[s * 4 + 2]! * sin - RAYS[s * 4 + 3]! * cos - py;
        const steps = Math.ceil(Math.max(Math.abs(dx), Math.abs(dy), 1));
        const [sx, sy] = [dx / steps, dy / steps];
        for (let step = 0; step <= steps; step++) {
          const [column, row] = [px | 0, py | 0];
          px += sx;
          py += sy;
          if (column < 0 || row < 0 || column >= width || row >= height) continue;
          const place = row * width + column;
          // The stronger is above.
          if (pixels[place]! < colour) pixels[place] = colour;
        }
      }
    }
  }

  private bodies({ floats, robots }: Frame, k: number): void {
    const { pixels, width, height, sprites, side, headings, between } = this;
    const turn = headings / (2 * Math.PI);
    const half = side / 2;
    for (let n = 0; n < robots; n++) {
      const at = n * FLOATS;
      let heading = Math.round(floats[at + 2]! * turn) % headings;
      if (heading < 0) heading += headings;
      const left = floats[at]! * k - half;
      const top = height - floats[at + 1]! * k - half;
      // Down to a whole pixel, and the sprite of what is left.
      const [x, y] = [Math.floor(left), Math.floor(top)];
      const part = ((top - y) * between | 0) * between + ((left - x) * between | 0);
      let from = (heading * between * between + part) * side * side;
      for (let row = y; row < y + side; row++) {
        for (let column = x; column < x + side; column++, from++) {
          const colour = sprites[from]!;
          if (colour === 0 || column < 0 || row < 0 || column >= width || row >= height) continue;
          const place = row * width + column;
          if (pixels[place]! >>> 24 <= colour >>> 24) pixels[place] = colour;
        }
      }
    }
  }

  /** What a body looks like at each heading and each place between pixels. */
  private make(r: number, density: number, { accent, floor, line, warm }: PixelColours): void {
    const key = `${r} ${density} ${accent} ${floor} ${line} ${warm}`;
    if (key === this.made) return;
    this.made = key;
    this.strengths = STRENGTHS.map((opacity, level) => pixel(level === 0 ? line : warm, opacity));
    this.headings = r > HEADED_PX * density ? HEADINGS : 1;
    this.between = r < SMALL_PX * density ? BETWEEN : 1;
    const side = (this.side = 2 * Math.ceil(r + 1) + 1);
    const { headings, between } = this;
    this.sprites = new Uint32Array(headings * between * between * side * side);
    const channels = (colour: string): number[] => (colour.match(/[\d.]+/g) ?? []).map(Number);
    const [body, nose] = [channels(accent), channels(floor)];
    const thick = Math.max(r / 4, density) / 2;
    let place = 0;
    for (let heading = 0; heading < headings; heading++) {
      const angle = (2 * Math.PI * heading) / headings;
      const [cos, sin] = [Math.cos(angle), -Math.sin(angle)];
      for (let part = 0; part < between * between; part++) {
        const cx = side / 2 + ((part % between) + (between > 1 ? 0.5 : 0)) / between;
        const cy = side / 2 + (Math.floor(part / between) + (between > 1 ? 0.5 : 0)) / between;
        for (let row = 0; row < side; row++) {
          for (let column = 0; column < side; column++, place++) {
            const [x, y] = [column + 0.5 - cx, row + 0.5 - cy];
            const opacity = covered(r - Math.hypot(x, y));
            if (opacity === 0) continue;
            const along = Math.min(Math.max(x * cos + y * sin, 0), r);
            const share = headings > 1 ? covered(thick - Math.hypot(x - along * cos, y - along * sin)) : 0;
            const [red, green, blue] = [0, 1, 2].map((n) => Math.round(body[n]! + (nose[n]! - body[n]!) * share));
            this.sprites[place] = ((Math.round(opacity * 255) << 24) | (blue! << 16) | (green! << 8) | red!) >>> 0;
          }
        }
      }
    }
  }
}
