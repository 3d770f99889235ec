// A sweep of several fields as parallel coordinates: a line for each group through its values to the
// mean of the measure, in the colour of that mean.

import { h, show, svg, write } from "../dom";
import { heat } from "../looks";
import { savers } from "../charts/save";
import type { Summary } from "../types";
import { figure, whole } from "../words";
import { plain, varied } from "./groups";

const GAP = 170;
const HEIGHT = 260;
const TOP = 30;
const BOTTOM = 20;
const SIDE = 70;
/** Values of an axis that are named; of more only some are. */
const NAMED = 12;

export function parallelPlot() {
  const plot = h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Parallel coordinates" });
  const text = h("p", { class: "quiet" });
  let csv = "";
  const element = h("section", { hidden: true }, h("h3", {}, "All fields at once"), plot, text,
    savers("parallel", { svg: () => plot.querySelector("svg"), csv: () => csv }));
  const draw = (summary: Summary, measure: string): void => {
    const fields = varied(summary);
    const groups = summary.groups.flatMap((group) => {
      const found = group.measures.find((one) => one.name === measure);
      return found?.mean == null ? [] : [{ values: fields.map((field) => plain(group.values[field] ?? "")), mean: found.mean, n: found.n, label: group.label }];
    });
    show(element, fields.length > 1 && groups.length > 1);
    if (fields.length < 2 || groups.length < 2) return;
    const axes = fields.map((_, place) => ordered([...new Set(groups.map((group) => group.values[place]!))]));
    const means = groups.map((group) => group.mean);
    const [least, most] = [Math.min(...means), Math.max(...means)];
    const share = (mean: number): number => (most > least ? (mean - least) / (most - least) : 0.5);
    const x = (axis: number): number => SIDE + axis * GAP;
    const y = (at: number): number => HEIGHT - BOTTOM - at * (HEIGHT - TOP - BOTTOM);
    const along = (axis: number, value: string): number => (axes[axis]!.length > 1 ? axes[axis]!.indexOf(value) / (axes[axis]!.length - 1) : 0.5);
    const width = 2 * SIDE + fields.length * GAP;
    const drawing = svg("svg", { viewBox: `0 0 ${width} ${HEIGHT}`, width, class: "as-is", role: "img", "aria-label": `${measure} over ${fields.join(", ")}: a line for each of ${groups.length} groups` });
    // The best come last, above the others.
    for (const group of [...groups].sort((a, b) => a.mean - b.mean)) {
      const points = [...group.values.map((value, axis) => `${x(axis)},${y(along(axis, value)).toFixed(1)}`), `${x(fields.length)},${y(share(group.mean)).toFixed(1)}`];
      drawing.append(svg("polyline", { points: points.join(" "), fill: "none", stroke: `rgb(${heat(share(group.mean)).join(",")})`, "stroke-width": 2, "stroke-opacity": 0.85 },
        svg("title", {}, `${group.label}: mean ${figure(group.mean)}, n ${group.n}`)));
    }
    [...fields, measure].forEach((name, axis) => {
      drawing.append(
        svg("line", { x1: x(axis), x2: x(axis), y1: y(0), y2: y(1), class: "axis" }),
        svg("text", { x: x(axis), y: 14, "text-anchor": "middle", class: "name" }, name.slice(0, 24)));
      const values = axis < fields.length ? axes[axis]! : [];
      const every = Math.ceil(values.length / NAMED);
      values.forEach((value, place) => {
        if (place % every === 0) drawing.append(svg("text", { x: x(axis) + 6, y: y(along(axis, value)) + 4, class: "halo" }, value.slice(0, 16)));
      });
    });
    for (const at of [0, 1]) drawing.append(svg("text", { x: x(fields.length) + 6, y: y(at) + 4 }, figure(at ? most : least)));
    plot.replaceChildren(drawing);
    csv = [[...fields, measure, "n"].map((cell) => JSON.stringify(cell)).join(","), ...groups.map((group) => [...group.values.map((cell) => JSON.stringify(cell)), group.mean, group.n].join(","))].join("\n");
    write(text, `A line for each of ${whole(groups.length)} groups, n = ${whole(groups.reduce((sum, group) => sum + group.n, 0))} runs in all; the lighter, the higher its mean of ${measure}.`);
  };
  return { element, draw };
}

/** Numbers by size, words as they came. */
function ordered(values: string[]): string[] {
  return values.every((value) => value !== "" && Number.isFinite(Number(value))) ? values.sort((a, b) => Number(a) - Number(b)) : values;
}
