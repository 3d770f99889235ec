// How groups and heat look: the same group has the same look in every chart of a job.

import { h } from "./dom";

/** Okabe and Ito (2008): told apart by people who are colour-blind; the last differs by theme. */
const COLOURS = [
  "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#8c564b",
] as const;
const DASHES: readonly (readonly number[])[] = [[], [8, 4], [2, 3], [10, 3, 2, 3]];

export interface Look {
  colour: string;
  dash: readonly number[];
}

/** The look of a group by its place: eight colours, then the same with dashes, 32 in all. */
export function look(place: number): Look {
  return {
    colour: COLOURS[place % COLOURS.length] ?? COLOURS[0],
    dash: DASHES[Math.floor(place / COLOURS.length) % DASHES.length] ?? [],
  };
}

/** How many groups can be told apart by their look alone; beyond that labels do it. */
export const LOOKS = COLOURS.length * DASHES.length;

/** Viridis at nine places: perceptually uniform, and rising in lightness. */
const VIRIDIS: readonly (readonly [number, number, number])[] = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
  [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
];

/** The part of it that stands out from the floor, 1.5 to 1 at least: light floors hide its end, dark
 * ones its beginning. */
const SEEN = { light: [0, 0.9], dark: [0.12, 1] } as const;

const darkness = typeof matchMedia === "undefined" ? null : matchMedia("(prefers-color-scheme: dark)");

/** The colour of a share of 0 to 1, of the theme in force unless it is said. */
export function heat(share: number, isDark = darkness?.matches ?? false): readonly [number, number, number] {
  const [first, last] = isDark ? SEEN.dark : SEEN.light;
  const at = (first + Math.min(Math.max(share, 0), 1) * (last - first)) * (VIRIDIS.length - 1);
  const low = Math.floor(at);
  const from = VIRIDIS[low] ?? VIRIDIS[0]!;
  const to = VIRIDIS[low + 1] ?? from;
  const mix = (a: number, b: number): number => Math.round(a + (b - a) * (at - low));
  return [mix(from[0], to[0]), mix(from[1], to[1]), mix(from[2], to[2])];
}

const pixels = (isDark: boolean): Uint32Array => Uint32Array.from({ length: 256 }, (_, step) => {
  const [r, g, b] = heat(step / 255, isDark);
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
});
const [LIGHT, DARK] = [pixels(false), pixels(true)];

/** The same in 256 steps, as pixels of a canvas. */
export const heatPixels = (): Uint32Array => (darkness?.matches ? DARK : LIGHT);

/** Calls when the theme changes, until what it gives is called. */
export function onTheme(call: () => void): () => void {
  darkness?.addEventListener("change", call);
  return () => darkness?.removeEventListener("change", call);
}

const RAMP_STEPS = 64;
const ramps = new Set<WeakRef<HTMLCanvasElement>>();
onTheme(() => {
  for (const held of ramps) {
    const canvas = held.deref();
    if (canvas) paint(canvas);
    else ramps.delete(held);
  }
});

/** The colours of a map from the lowest to the highest, for its legend. */
export function ramp(): HTMLCanvasElement {
  const canvas = h("canvas", { class: "ramp", width: RAMP_STEPS, height: 1, "aria-hidden": true });
  ramps.add(new WeakRef(canvas));
  paint(canvas);
  return canvas;
}

function paint(canvas: HTMLCanvasElement): void {
  const pen = canvas.getContext("2d");
  for (let x = 0; pen && x < RAMP_STEPS; x++) {
    pen.fillStyle = `rgb(${heat(x / (RAMP_STEPS - 1)).join(",")})`;
    pen.fillRect(x, 0, 1, 1);
  }
}

/** A colour of the style sheet by its name, as a canvas takes it: of the theme in force. */
export function themed(name: string): string {
  const probe = document.createElement("span");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}
