// Every run as a dot, by group, for each of the chosen measures: nothing hides in a mean.

import { h, svg, write } from "../dom";
import { look } from "../looks";
import { link } from "../route";
import { savers } from "../charts/save";
import type { Run, Summary } from "../types";
import { figure, whole } from "../words";
import { measureOf } from "./groups";

/** Shown at once; the rest when asked for. */
const FIRST = ["p1", "p10", "t90_steps", "memory_bytes", "cpu_ns_per_robot_step"];
const NAMES: Record<string, string> = { cpu_ns_per_robot_step: "CPU time of a robot-step, ns", memory_bytes: "memory of a learner, bytes" };
const REST = ["p2", "p5", "t50_steps", "t99_steps", "mean_coverage", "overlap", "collisions_per_robot_step"];
const ROW = 22;
const WIDTH = 360;
/** Most runs that are drawn. */
const MOST = 2_000;
/** Groups beyond which strips get low. */
const MANY = 24;

export interface StripPlots {
  element: HTMLElement;
  /** The summary has intervals of means, of groups that are its own. */
  draw(runs: Run[], labels: string[], group: (run: Run) => string, summary: Summary): void;
}

export function stripPlots(): StripPlots {
  const plots = h("div", { class: "strips" });
  const rest = h("div", { class: "strips" });
  const more = h("details", {}, h("summary", {}, "More measures"), rest);
  const cut = h("p", { class: "quiet" });
  const element = h("section", {}, h("h3", {}, "All finished runs"), plots, more, cut);
  let last: [Run[], string[], (run: Run) => string, Summary] | null = null;
  const fill = (): void => {
    if (last && more.open) rest.replaceChildren(...REST.map((measure) => strip(measure, ...last!)));
  };
  more.addEventListener("toggle", fill);
  return {
    element,
    draw: (runs, labels, group, summary) => {
      const done = runs.filter((run) => run.result != null);
      const shown = done.slice(0, MOST);
      last = [shown, labels, group, summary];
      write(cut, shown.length < done.length ? `The first ${whole(MOST)} finished runs are shown.` : `A dot for each run, n = ${whole(done.length)}; upright the mean, across its 95 % interval.`);
      plots.replaceChildren(...FIRST.map((measure) => strip(measure, shown, labels, group, summary)));
      fill();
    },
  };
}

function strip(measure: string, runs: Run[], labels: string[], group: (run: Run) => string, summary: Summary): HTMLElement {
  const places = new Map(labels.map((label, place) => [label, place]));
  const values = runs.flatMap((run) => {
    const value = measureOf(run, measure);
    const place = places.get(group(run));
    return value === null || place === undefined ? [] : [{ place, value, run }];
  });
  if (values.length === 0) {
    return h("figure", {}, h("p", { class: "facts" }, `${measure}: no run has it${measure.endsWith("_steps") ? ", as none got there" : ""}.`));
  }
  const intervals = labels.map((label) =>
    summary.groups.find((one) => one.label === label)?.measures.find((one) => one.name === measure)?.interval ?? null);
  const name = NAMES[measure] ?? measure;
  const most = Math.max(...values.map((one) => one.value), ...intervals.map((interval) => interval?.high ?? 0), 1e-12);
  const row = labels.length > MANY ? 12 : ROW;
  const height = labels.length * row + 44;
  const x = (value: number): number => 12 + (value / most) * (WIDTH - 24);
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": `${name} of every run by group, n = ${values.length}` });
  drawing.append(svg("text", { x: 0, y: 12, class: "name" }, `${name}  (n ${values.length})`));
  labels.forEach((_, place) => {
    const y = 24 + place * row + row / 2;
    drawing.append(svg("line", { x1: 12, x2: WIDTH - 12, y1: y, y2: y, class: "rail" }));
  });
  for (const { place, value, run } of values) {
    const dot = svg("circle", {
      cx: x(value).toFixed(1), cy: 24 + place * row + row / 2, r: 3.5,
      fill: look(place).colour, "fill-opacity": 0.65, class: "dot",
    });
    dot.append(svg("title", {}, `${labels[place] || "all runs"}, seed ${run.seed}: ${figure(value)}`));
    dot.addEventListener("click", () => { location.hash = link("run", run.id); });
    drawing.append(dot);
  }
  labels.forEach((label, place) => {
    const own = values.filter((one) => one.place === place).map((one) => one.value);
    if (own.length === 0) return;
    const mean = own.reduce((sum, value) => sum + value, 0) / own.length;
    const y = 24 + place * row + row / 2;
    const interval = intervals[place];
    if (interval) drawing.append(svg("line", { x1: x(Math.max(interval.low, 0)), x2: x(interval.high), y1: y, y2: y, class: "interval" }));
    const told = interval ? ` [${figure(interval.low)}, ${figure(interval.high)}]` : "";
    drawing.append(svg("line", { x1: x(mean), x2: x(mean), y1: y - row / 2 + 2, y2: y + row / 2 - 2, class: "mean" },
      svg("title", {}, `${label || "all runs"}: mean ${figure(mean)}${told}, n ${own.length}`)));
  });
  for (const value of [0, most]) {
    drawing.append(svg("text", { x: x(value), y: height - 4, "text-anchor": value ? "end" : "start", class: "tick" }, figure(value)));
  }
  const csv = (): string => ["group,seed,run," + measure, ...values.map(({ place, value, run }) => [JSON.stringify(labels[place]), run.seed, run.id, value].join(","))].join("\n");
  return h("figure", {}, drawing, savers(measure, { svg: () => drawing, csv }));
}
