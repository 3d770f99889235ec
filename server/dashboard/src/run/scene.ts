// The arena of a run: what was covered as a heat map with a legend, and over it the robots, drawn
// anew only when there is something new to see.

import { h, show, write } from "../dom";
import { heatPixels, look, onTheme, ramp, themed } from "../looks";
import type { Arena } from "../types";
import { whole } from "../words";
import { FLOATS, type Frame, type Squares } from "./messages";
import { drawObjects, drawRadio, drawRays, hatched, type Sheet } from "./overlays";
import { Pixels, PIXELS_FROM } from "./pixels";

export const LAYERS = {
  visits: "visits (log scale)",
  first: "first visit",
  last: "last visit since you look",
  none: "no map",
} as const;
export type Layer = keyof typeof LAYERS;
export type Over = "robots" | "rays" | "trails" | "radio";

export interface Scene {
  element: HTMLElement;
  arena(arena: Arena, radius_m: number, radioRange_m: number | null): void;
  frame(frame: Frame): void;
  squares(squares: Squares): void;
  /** Shows only squares that had been entered after so many counted steps; all for null. */
  until(steps: number | null): void;
  /** Which squares can be reached: a text a row, the lowest y first, with `0` for those that cannot. */
  reach(rows: readonly string[] | null): void;
  layer(layer: Layer): void;
  over(what: Over, on: boolean): void;
  choose(robot: number): void;
  /** Times that took long, for tests: pictures drawn and milliseconds that they took. */
  readonly drawn: { pictures: number; ms: number };
  stop(): void;
}

/** Least time between two pictures of what was covered by a moment of a recording. */
const GROUND_EVERY_MS = 100;
const MOST_HIGH_PX = 640;
/** Robots that have colours and trails of their own. */
const COLOURED = 8;
const TRAILED = 64;
const TRAIL = 240;
/** Steps between two pictures above which a line between them would be made up. */
const TRAIL_STEPS = 40;

export function scene(onChoose: (robot: number) => void): Scene {
  // Named from the first moment; what is drawn names it anew.
  const ground = h("canvas", { role: "img", "aria-label": "The arena with its robots" });
  const swarm = h("canvas", { class: "swarm", "aria-hidden": true });
  const [low, high] = [h("span", {}), h("span", {})];
  const legend = h("figcaption", { class: "quiet" }, low, ramp(), high);
  const holder = h("div", { class: "stage" }, ground, swarm);
  const element = h("figure", { class: "scene" }, holder, legend);
  const raster = document.createElement("canvas");
  const shown = { robots: true, rays: false, trails: true, radio: false };
  const drawn = { pictures: 0, ms: 0 };
  const pixels = new Pixels();
  let arena: Arena | null = null;
  let radius_m = 0.037;
  let range_m: number | null = null;
  let scale = 1;
  let density = 1;
  let frame: Frame | null = null;
  let squares: Squares | null = null;
  let before: Uint32Array | null = null;
  let last: Float64Array | null = null;
  let layer: Layer = "visits";
  let until: number | null = null;
  let reachable: readonly string[] | null = null;
  let hatching: HTMLCanvasElement | null = null;
  let robot = 0;
  let trails: Float32Array[] = [];
  let lengths: number[] = [];
  let colours = { floor: "", ink: "", accent: "", warm: "", line: "" };
  let due = 0;
  let groundDue = false;
  let ground_at = 0;

  const theme = (): void => {
    colours = {
      floor: themed("--floor"), ink: themed("--ink"), accent: themed("--accent"),
      warm: themed("--warm"), line: themed("--quiet"),
    };
  };
  const ask = (withGround: boolean): void => {
    groundDue ||= withGround;
    if (due === 0) due = requestAnimationFrame(draw);
  };
  const draw = (): void => {
    due = 0;
    if (!arena) return;
    const start = performance.now();
    const isSoon = until !== null && start - ground_at < GROUND_EVERY_MS;
    if (groundDue && !isSoon) {
      drawGround(arena);
      ground_at = start;
      groundDue = false;
    }
    drawSwarm(arena);
    drawn.pictures += 1;
    drawn.ms += performance.now() - start;
    if (groundDue) ask(false);
  };
  const fit = (): void => {
    if (!arena) return;
    const width = Math.max(element.clientWidth, 240);
    scale = Math.min(width / arena.width_m, MOST_HIGH_PX / arena.height_m);
    density = devicePixelRatio || 1;
    for (const canvas of [ground, swarm]) {
      canvas.width = Math.round(arena.width_m * scale * density);
      canvas.height = Math.round(arena.height_m * scale * density);
      canvas.style.width = `${arena.width_m * scale}px`;
      canvas.style.height = `${arena.height_m * scale}px`;
    }
    theme();
    hatching = null;
    ask(true);
  };

  /** The value of each square between 0 and 1, below 0 for none; and the legend. */
  const values = (s: Squares): { value: (n: number) => number; low: string; high: string } | null => {
    if (layer === "none") return null;
    if (layer === "visits") {
      let most = 1;
      for (const count of s.visits) if (count > most) most = count;
      const top = Math.log1p(most);
      return {
        value: (n) => (s.visits[n]! > 0 && isBy(s, n) ? Math.log1p(s.visits[n]!) / top : -1),
        low: "1 entry", high: `${whole(most)} entries (log scale)${until === null ? "" : ", of the whole run, where entered by now"}`,
      };
    }
    const at = layer === "first" ? s.first : last;
    let top = 1;
    for (const value of at ?? []) if (value > top) top = value;
    return {
      value: (n) => {
        const value = at?.[n] ?? -1;
        return value < 0 || !isBy(s, n) ? -1 : value / top;
      },
      low: layer === "first" ? "entered first at step 0" : "entered when you began to look",
      high: layer === "first" ? `at step ${whole(top)}` : "just now",
    };
  };
  const isBy = (s: Squares, n: number): boolean => until === null || s.first[n]! <= until;
  const drawGround = (where: Arena): void => {
    const pen = ground.getContext("2d");
    if (!pen) return;
    const k = scale * density;
    pen.fillStyle = colours.floor;
    pen.fillRect(0, 0, ground.width, ground.height);
    const map = squares && !frame?.isTraining ? values(squares) : null;
    let covered = 0;
    if (map && squares) {
      const { columns, rows } = squares;
      raster.width = columns;
      raster.height = rows;
      const small = raster.getContext("2d")!;
      const image = small.createImageData(columns, rows);
      const bytes = new Uint32Array(image.data.buffer);
      const heat = heatPixels();
      for (let y = 0; y < rows; y++) {
        for (let x = 0; x < columns; x++) {
          const value = map.value(y * columns + x);
          if (value < 0) continue;
          covered += 1;
          bytes[(rows - 1 - y) * columns + x] = heat[Math.round(Math.min(value, 1) * 255)]!;
        }
      }
      small.putImageData(image, 0, 0);
      pen.imageSmoothingEnabled = false;
      pen.drawImage(raster, 0, 0, ground.width, ground.height);
      write(low, map.low);
      write(high, map.high);
    }
    if (reachable && !frame?.isTraining) {
      hatching ??= hatched(reachable, ground.width, ground.height, colours.line, density);
      pen.drawImage(hatching, 0, 0);
    }
    show(legend, map !== null);
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 2 * density;
    pen.lineCap = "round";
    pen.strokeRect(density, density, ground.width - 2 * density, ground.height - 2 * density);
    pen.beginPath();
    for (const [x1, y1, x2, y2] of where.walls_m ?? []) {
      pen.moveTo(x1 * k, ground.height - y1 * k);
      pen.lineTo(x2 * k, ground.height - y2 * k);
    }
    pen.stroke();
    if (!frame) {
      pen.strokeStyle = colours.accent;
      for (const start of where.starts.slice(0, 200)) {
        disc(pen, start.x_m * k, ground.height - start.y_m * k, radius_m * k, start.heading_rad);
        pen.stroke();
      }
    }
    ground.setAttribute(
      "aria-label",
      squares
        ? `Arena with ${whole(covered)} squares entered${frame ? `, ${whole(frame.robots)} robots` : ""}`
        : `Arena${frame ? ` with ${whole(frame.robots)} robots` : ""}`,
    );
  };
  const drawSwarm = (where: Arena): void => {
    const pen = swarm.getContext("2d");
    if (!pen) return;
    const k = scale * density;
    const top = swarm.height;
    const r = Math.max(radius_m * k, 1.5 * density);
    const isMany = frame !== null && frame.robots >= PIXELS_FROM;
    if (frame && shown.robots && isMany) pixels.draw(pen, frame, k, r, density, shown.rays, colours);
    else pen.clearRect(0, 0, swarm.width, swarm.height);
    if (!frame) return;
    const { floats, robots } = frame;
    const sheet: Sheet = { k, top, density };
    if (frame.objects.length) drawObjects(pen, frame, where.objects ?? [], sheet, colours.ink);
    if (!shown.robots) return;
    if (shown.trails) {
      pen.lineWidth = 1.2 * density;
      trails.forEach((trail, n) => {
        const length = lengths[n] ?? 0;
        pen.strokeStyle = robots <= COLOURED ? look(n).colour : colours.line;
        pen.globalAlpha = n === robot ? 0.9 : 0.45;
        pen.beginPath();
        for (let p = 0; p < length; p++) {
          const x = trail[p * 2]! * k;
          const y = top - trail[p * 2 + 1]! * k;
          if (p === 0) pen.moveTo(x, y);
          else pen.lineTo(x, y);
        }
        pen.stroke();
      });
      pen.globalAlpha = 1;
    }
    if (shown.rays && !isMany) drawRays(pen, frame, sheet, colours);
    if (shown.radio && range_m !== null) drawRadio(pen, frame, robot, range_m, sheet, colours);
    if (robots <= COLOURED) {
      for (let n = 0; n < robots; n++) {
        pen.fillStyle = look(n).colour;
        pen.strokeStyle = colours.ink;
        pen.lineWidth = 1.5 * density;
        disc(pen, floats[n * FLOATS]! * k, top - floats[n * FLOATS + 1]! * k, r, floats[n * FLOATS + 2]!);
        pen.fill();
        pen.stroke();
      }
    } else if (!isMany) {
      // All discs are one path and all headings another.
      pen.fillStyle = colours.accent;
      pen.beginPath();
      for (let n = 0; n < robots; n++) {
        const [x, y] = [floats[n * FLOATS]! * k, top - floats[n * FLOATS + 1]! * k];
        pen.moveTo(x + r, y);
        pen.arc(x, y, r, 0, 2 * Math.PI);
      }
      pen.fill();
      pen.strokeStyle = colours.floor;
      pen.lineWidth = Math.max(r / 4, density);
      pen.beginPath();
      for (let n = 0; n < robots; n++) {
        const [x, y] = [floats[n * FLOATS]! * k, top - floats[n * FLOATS + 1]! * k];
        const heading = floats[n * FLOATS + 2]!;
        pen.moveTo(x, y);
        pen.lineTo(x + r * Math.cos(heading), y - r * Math.sin(heading));
      }
      pen.stroke();
    }
    if (robot < robots) {
      pen.strokeStyle = colours.warm;
      pen.lineWidth = 3 * density;
      pen.beginPath();
      pen.arc(floats[robot * FLOATS]! * k, top - floats[robot * FLOATS + 1]! * k, r + 4 * density, 0, 2 * Math.PI);
      pen.stroke();
    }
  };
  const addToTrails = (f: Frame): void => {
    const steps = frame ? f.step - frame.step : 0;
    const goesOn = frame !== null && steps >= 0 && steps <= TRAIL_STEPS && f.isTraining === frame.isTraining;
    const count = f.robots <= TRAILED ? f.robots : 0;
    if (!goesOn || trails.length !== count) {
      trails = Array.from({ length: count }, () => new Float32Array(TRAIL * 2));
      lengths = trails.map(() => 0);
    }
    for (let n = 0; n < count; n++) {
      const trail = trails[n]!;
      let length = lengths[n]!;
      const [x, y] = [f.floats[n * FLOATS]!, f.floats[n * FLOATS + 1]!];
      // A robot that was put back to its start leaves no line across the arena.
      const far = length > 0 && Math.hypot(x - trail[length * 2 - 2]!, y - trail[length * 2 - 1]!) > 0.02 * Math.max(steps, 1);
      if (far) length = 0;
      if (length === TRAIL) {
        trail.copyWithin(0, 2);
        length -= 1;
      }
      trail[length * 2] = x;
      trail[length * 2 + 1] = y;
      lengths[n] = length + 1;
    }
  };
  swarm.addEventListener("click", (event) => {
    if (!frame) return;
    const box = swarm.getBoundingClientRect();
    const x = (event.clientX - box.left) / scale;
    const y = (box.bottom - event.clientY) / scale;
    let nearest = -1;
    let best = (radius_m * 3) ** 2;
    for (let n = 0; n < frame.robots; n++) {
      const distance = (frame.floats[n * FLOATS]! - x) ** 2 + (frame.floats[n * FLOATS + 1]! - y) ** 2;
      if (distance < best) [nearest, best] = [n, distance];
    }
    if (nearest >= 0) onChoose(nearest);
  });
  const themeChanges = onTheme(fit);
  const resize = new ResizeObserver(fit);
  resize.observe(element);
  return {
    element, drawn,
    arena: (where, body_m, radio_m) => {
      if (arena === where) return;
      [arena, radius_m, range_m] = [where, body_m, radio_m];
      fit();
    },
    frame: (next) => {
      const changesGround = frame === null || frame.isTraining !== next.isTraining || frame.robots !== next.robots;
      addToTrails(next);
      frame = next;
      ask(changesGround);
    },
    squares: (next) => {
      const now = next.steps;
      if (!before || before.length !== next.visits.length) {
        last = new Float64Array(next.visits.length).fill(-1);
      } else if (last) {
        for (let n = 0; n < before.length; n++) if (next.visits[n]! !== before[n]!) last[n] = now;
      }
      before = next.visits;
      squares = next;
      ask(true);
    },
    until: (steps) => {
      if (until === steps) return;
      until = steps;
      if (squares && layer !== "none") ask(true);
    },
    reach: (rows) => {
      reachable = rows;
      hatching = null;
      ask(true);
    },
    layer: (next) => {
      layer = next;
      ask(true);
    },
    over: (what, on) => {
      shown[what] = on;
      ask(false);
    },
    choose: (next) => {
      robot = next;
      ask(false);
    },
    stop: () => {
      cancelAnimationFrame(due);
      themeChanges();
      resize.disconnect();
    },
  };

  function disc(pen: CanvasRenderingContext2D, x: number, y: number, r: number, heading: number): void {
    pen.beginPath();
    pen.arc(x, y, r, 0, 2 * Math.PI);
    pen.moveTo(x, y);
    pen.lineTo(x + r * Math.cos(heading), y - r * Math.sin(heading));
  }
}
