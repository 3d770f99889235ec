// The arena of a run: walls, starts, and what was covered as a heat map with a legend.

import { h, write } from "../dom";
import { heat, themed } from "../looks";
import { whole } from "../words";

export interface Walls {
  width_m: number;
  height_m: number;
  walls_m: readonly (readonly [number, number, number, number])[];
  starts: readonly { x_m: number; y_m: number; heading_rad: number }[];
}

export interface Grid {
  columns: number;
  rows: number;
  /** Row by row, the first the lowest y. */
  counts: readonly (readonly number[])[];
}

export interface Scene {
  element: HTMLElement;
  draw(walls: Walls, grid: Grid): void;
  stop(): void;
}

const LEGEND_STEPS = 64;

export function scene(): Scene {
  const canvas = h("canvas", { role: "img" });
  const ramp = h("canvas", { class: "ramp", width: LEGEND_STEPS, height: 1, "aria-hidden": true });
  const low = h("span", {});
  const high = h("span", {});
  const element = h(
    "figure",
    { class: "scene" },
    canvas,
    h("figcaption", { class: "quiet" }, low, ramp, high),
  );
  const pixels = ramp.getContext("2d");
  for (let x = 0; pixels && x < LEGEND_STEPS; x++) {
    pixels.fillStyle = `rgb(${heat(x / (LEGEND_STEPS - 1)).join(",")})`;
    pixels.fillRect(x, 0, 1, 1);
  }
  let last: [Walls, Grid] | null = null;
  const draw: Scene["draw"] = (walls, grid) => {
    last = [walls, grid];
    const width = Math.max(canvas.parentElement?.clientWidth ?? 0, 240);
    const scale = Math.min(width / walls.width_m, 640 / walls.height_m);
    const density = devicePixelRatio || 1;
    canvas.width = Math.round(walls.width_m * scale * density);
    canvas.height = Math.round(walls.height_m * scale * density);
    canvas.style.width = `${walls.width_m * scale}px`;
    const pen = canvas.getContext("2d");
    if (!pen) return;
    pen.fillStyle = themed("--floor");
    pen.fillRect(0, 0, canvas.width, canvas.height);
    const most = Math.max(1, ...grid.counts.map((row) => Math.max(...row)));
    const w = canvas.width / grid.columns;
    const t = canvas.height / grid.rows;
    let covered = 0;
    grid.counts.forEach((row, y) => {
      row.forEach((count, x) => {
        if (count === 0) return;
        covered += 1;
        pen.fillStyle = `rgb(${heat(Math.log1p(count) / Math.log1p(most)).join(",")})`;
        const top = canvas.height - (y + 1) * t;
        pen.fillRect(Math.floor(x * w), Math.floor(top), Math.ceil(w), Math.ceil(t));
      });
    });
    const k = scale * density;
    pen.strokeStyle = themed("--ink");
    pen.lineWidth = 2 * density;
    pen.lineCap = "round";
    pen.strokeRect(density, density, canvas.width - 2 * density, canvas.height - 2 * density);
    pen.beginPath();
    for (const [x1, y1, x2, y2] of walls.walls_m) {
      pen.moveTo(x1 * k, canvas.height - y1 * k);
      pen.lineTo(x2 * k, canvas.height - y2 * k);
    }
    pen.stroke();
    pen.strokeStyle = themed("--accent");
    for (const start of walls.starts.slice(0, 100)) {
      const [x, y, r] = [start.x_m * k, canvas.height - start.y_m * k, 0.037 * k];
      pen.beginPath();
      pen.arc(x, y, r, 0, 2 * Math.PI);
      pen.moveTo(x, y);
      pen.lineTo(x + r * Math.cos(start.heading_rad), y - r * Math.sin(start.heading_rad));
      pen.stroke();
    }
    write(low, "1 entry");
    write(high, `${whole(most)} entries (log scale)`);
    canvas.setAttribute("aria-label", `Arena with ${whole(covered)} squares entered, at most ${whole(most)} times`);
  };
  const again = (): void => {
    if (last) draw(...last);
  };
  const theme = matchMedia("(prefers-color-scheme: dark)");
  theme.addEventListener("change", again);
  const resize = new ResizeObserver(again);
  resize.observe(element);
  return {
    element,
    draw,
    stop: () => {
      theme.removeEventListener("change", again);
      resize.disconnect();
    },
  };
}
