// Lines with bands over a common abscissa, by uPlot; ways to take picture and figures along.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { h } from "../dom";
import { themed, type Look } from "../looks";
import { figure, percent } from "../words";
import { savers } from "./save";

export interface Line {
  label: string;
  look: Look;
  mean: (number | null)[];
  low?: (number | null)[];
  high?: (number | null)[];
  n?: number[];
  /** Single runs, drawn thin. */
  runs?: (number | null)[][];
}

export interface Lines {
  x: { name: string; at: number[]; log?: boolean };
  /** A `share` is shown in per cent. */
  y: { name: string; log: boolean; share?: boolean };
  lines: Line[];
  /** Whether labels stand at the lines, for want of a legend. */
  labelled?: boolean;
}

export interface LineChart {
  element: HTMLElement;
  draw(lines: Lines): void;
  stop(): void;
}

const HEIGHT = 340;
const SMALL = 240;
/** Lines up to which bands are told apart. */
const FEW = 4;
/** Direct labels stand at lines where colours and dashes do not tell all apart. */
const LABEL_FROM = 9;

export function lineChart(name: string, title: string, zoomed: (x: [number, number] | null) => void = () => undefined, zoom: [number, number] | null = null, sentence?: () => string): LineChart {
  const plot = h("div", { class: "plot", role: "img", "aria-label": title });
  let last: Lines | null = null;
  let chart: uPlot | null = null;
  let window_x = zoom;
  const element = h("div", { class: "chart" }, plot, savers(name, {
    png: () => plot.querySelector("canvas"),
    svg: () => (last ? picture(last, title) : null),
    csv: () => (last ? csv(last) : ""),
    ...(sentence && { sentence }),
  }));
  const height = (): number => (innerWidth < 700 ? SMALL : HEIGHT);
  const draw = (lines: Lines): void => {
    last = lines;
    const [ink, grid] = [themed("--quiet"), themed("--line")];
    const drawn = (list: (number | null)[]): (number | null)[] =>
      lines.y.log ? list.map((value) => (value === null || value <= 0 ? null : value)) : list;
    const data: (number | null)[][] = [lines.x.at];
    const series: uPlot.Series[] = [{ label: lines.x.name }];
    const bands: uPlot.Band[] = [];
    const none = { show: false };
    const ends: { at: number; text: string; colour: string }[] = [];
    // Bands come first and lines over all of them; many bands over each other are fainter.
    const opacity = lines.lines.length > FEW ? "1a" : "33";
    for (const { look, low, high } of lines.lines) {
      if (!low || !high) continue;
      const first = data.length;
      data.push(drawn(high), drawn(low));
      const edge: uPlot.Series = { label: "", stroke: "transparent", spanGaps: true, points: none };
      series.push(edge, { ...edge });
      bands.push({ series: [first, first + 1], fill: `${look.colour}${opacity}` });
    }
    for (const { label, look, mean, runs } of lines.lines) {
      for (const run of runs ?? []) {
        data.push(drawn(run));
        series.push({ label: "", stroke: `${look.colour}55`, width: 1, spanGaps: true, points: none });
      }
      ends.push({ at: data.length, text: label, colour: look.colour });
      data.push(drawn(mean));
      series.push({ label, stroke: look.colour, width: 2, dash: [...look.dash], spanGaps: true, points: none });
    }
    chart?.destroy();
    plot.replaceChildren();
    const font = "12px system-ui, sans-serif";
    const axis = { stroke: ink, font, labelFont: font, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid } };
    const values = (_: uPlot, ticks: (number | null)[]): string[] => ticks.map((tick) => (tick === null ? "" : figure(tick)));
    const shares = (_: uPlot, ticks: (number | null)[]): string[] => ticks.map((tick) => (tick === null ? "" : percent(tick)));
    chart = new uPlot(
      {
        width: Math.max(plot.clientWidth, 280),
        height: height(),
        legend: { show: false },
        cursor: { drag: { x: true, y: false }, points: none },
        scales: {
          x: { time: false, distr: lines.x.log ? 3 : 1, ...(window_x && { min: window_x[0], max: window_x[1] }) },
          y: { distr: lines.y.log ? 3 : 1 },
        },
        axes: [{ ...axis, label: lines.x.name, values }, { ...axis, label: lines.y.name, size: 64, values: lines.y.share ? shares : values }],
        series,
        bands,
        hooks: {
          setScale: [(self, key) => {
            if (key !== "x" || self.status !== 1) return;
            const { min, max } = self.scales["x"]!;
            const all = min === lines.x.at[0] && max === lines.x.at.at(-1);
            window_x = all || min == null || max == null ? null : [min, max];
            zoomed(window_x);
          }],
          draw: [(self) => {
            if (lines.lines.length < LABEL_FROM && !lines.labelled) return;
            const pen = self.ctx;
            const density = devicePixelRatio || 1;
            pen.save();
            pen.font = `${11 * density}px system-ui, sans-serif`;
            pen.textAlign = "right";
            for (const { at, text, colour } of ends) {
              const value = self.data[at]?.at(-1);
              if (value === null || value === undefined) continue;
              pen.fillStyle = colour;
              pen.fillText(text.length > 24 ? `… ${text.slice(-22)}` : text, self.valToPos(self.data[0]!.at(-1)!, "x", true) - 4 * density, self.valToPos(value, "y", true) - 4 * density);
            }
            pen.restore();
          }],
        },
      },
      data as uPlot.AlignedData,
      plot,
    );
  };
  const again = (): void => {
    if (last) draw(last);
  };
  const resize = new ResizeObserver(() => {
    if (chart && plot.clientWidth > 0) chart.setSize({ width: plot.clientWidth, height: height() });
  });
  resize.observe(plot);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", again);
  return {
    element,
    draw,
    stop: () => {
      resize.disconnect();
      dark.removeEventListener("change", again);
      chart?.destroy();
    },
  };
}

/** The figures behind a chart. */
export function csv({ x, lines }: Lines): string {
  const cell = (value: number | null | undefined): string => String(value ?? "");
  const rows = lines.flatMap((line) =>
    x.at.map((at, place) =>
      [JSON.stringify(line.label), at, ...[line.n, line.mean, line.low, line.high].map((list) => cell(list?.[place]))].join(","),
    ),
  );
  return [`group,${x.name},n,mean,low,high`, ...rows].join("\n");
}

/** The same chart as a drawing that scales: for papers, on white. */
export function picture({ x, y, lines }: Lines, title: string): string {
  const [width, height, left, bottom, top, right] = [720, 420, 70, 50, 16, 150];
  const value = (list: (number | null)[]): number[] => list.filter((one): one is number => one !== null && (!y.log || one > 0));
  const all = lines.flatMap((line) => [...value(line.mean), ...value(line.low ?? []), ...value(line.high ?? [])]);
  const [x0, x1] = [x.at[0] ?? 0, x.at.at(-1) ?? 1];
  const [y0, y1] = [y.log ? Math.min(...all) : Math.min(0, ...all), Math.max(...all, 1e-12)];
  const onto = (v: number, from: number, to: number, log: boolean): number =>
    log ? (Math.log(v) - Math.log(from)) / (Math.log(to) - Math.log(from) || 1) : (v - from) / (to - from || 1);
  const px = (v: number): string => (left + onto(v, x0, x1, x.log ?? false) * (width - left - right)).toFixed(1);
  const py = (v: number): string => (height - bottom - onto(v, y0, y1, y.log) * (height - bottom - top)).toFixed(1);
  const path = (list: (number | null)[]): string =>
    list.flatMap((v, n) => (v === null || (y.log && v <= 0) ? [] : [`${px(x.at[n]!)},${py(v)}`])).join(" ");
  const escape = (text: string): string => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const parts: string[] = [];
  for (let tick = 0; tick <= 4; tick++) {
    const share = tick / 4;
    const v = y.log ? y0 * (y1 / y0) ** share : y0 + (y1 - y0) * share;
    const u = x.log ? x0 * (x1 / x0) ** share : x0 + (x1 - x0) * share;
    parts.push(
      `<line x1="${left}" x2="${width - right}" y1="${py(v)}" y2="${py(v)}" stroke="#ddd"/>`,
      `<text x="${left - 6}" y="${py(v)}" text-anchor="end" dominant-baseline="middle">${y.share ? percent(v) : figure(v)}</text>`,
      `<text x="${px(u)}" y="${height - bottom + 18}" text-anchor="middle">${figure(Math.round(u))}</text>`,
    );
  }
  lines.forEach((line, place) => {
    const { colour, dash } = line.look;
    if (line.low && line.high) {
      const back = [...line.low].map((v, n) => [v, n] as const).reverse()
        .flatMap(([v, n]) => (v === null || (y.log && v <= 0) ? [] : [`${px(x.at[n]!)},${py(v)}`]));
      parts.push(`<polygon points="${path(line.high)} ${back.join(" ")}" fill="${colour}" fill-opacity="0.2"/>`);
    }
    const dashes = dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    parts.push(`<polyline points="${path(line.mean)}" fill="none" stroke="${colour}" stroke-width="2"${dashes}/>`);
    const at = top + 10 + place * 18;
    parts.push(
      `<line x1="${width - right + 10}" x2="${width - right + 38}" y1="${at}" y2="${at}" stroke="${colour}" stroke-width="2"${dashes}/>`,
      `<text x="${width - right + 44}" y="${at}" dominant-baseline="middle">${escape(line.label || "all runs")}</text>`,
    );
  });
  parts.push(
    `<text x="${(left + width - right) / 2}" y="${height - 10}" text-anchor="middle">${escape(x.name)}</text>`,
    `<text transform="translate(16 ${height / 2}) rotate(-90)" text-anchor="middle">${escape(y.name)}</text>`,
  );
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" font-family="sans-serif" font-size="12"><title>${escape(title)}</title><rect width="100%" height="100%" fill="#fff"/>${parts.join("")}</svg>`;
}
