// Every run as a dot, by group, for each of the four coverage counts: nothing hides in a mean.

import { h, svg } from "../dom";
import { look } from "../looks";
import { ask } from "../server";
import type { Summary } from "../types";
import { figure, whole } from "../words";

const MEASURES = ["p1", "p2", "p5", "p10"] as const;
const ROW = 22;
const WIDTH = 360;

export interface StripPlots {
  element: HTMLElement;
  draw(job: string, summary: Summary, signal: AbortSignal): Promise<void>;
}

export function stripPlots(): StripPlots {
  const plots = h("div", { class: "strips" });
  const element = h("section", {}, h("h3", {}, "All finished runs"), plots);
  return {
    element,
    draw: async (job, summary, signal) => {
      const text = await (await ask(`/v1/jobs/${job}/runs.csv`, { signal })).text();
      const runs = parse(text);
      const labels = summary.groups.map((group) => group.label);
      plots.replaceChildren(...MEASURES.map((measure) => strip(measure, labels, runs, summary)));
    },
  };
}

function strip(measure: string, labels: string[], runs: Record<string, string>[], summary: Summary): Element {
  const values = runs
    .map((run) => ({ place: labels.indexOf(run["label"] ?? ""), value: Number(run[measure]), run: run["run"] ?? run["id"] ?? "" }))
    .filter((run) => run.place >= 0 && Number.isFinite(run.value));
  const most = Math.max(...values.map((run) => run.value), 1);
  const height = labels.length * ROW + 40;
  const x = (value: number): number => 12 + (value / most) * (WIDTH - 24);
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": `${measure} of every run by group` });
  drawing.append(svg("text", { x: 0, y: 12, class: "name" }, measure));
  labels.forEach((label, place) => {
    const y = 24 + place * ROW + ROW / 2;
    const group = summary.groups[place]?.measures.find((one) => one.name === measure);
    drawing.append(svg("line", { x1: 12, x2: WIDTH - 12, y1: y, y2: y, class: "rail" }));
    if (group?.mean !== null && group?.mean !== undefined) {
      drawing.append(svg("line", { x1: x(group.mean), x2: x(group.mean), y1: y - 9, y2: y + 9, class: "mean" },
        svg("title", {}, `${label || "all runs"}: mean ${figure(group.mean)}, n ${whole(group.n)}`)));
    }
  });
  for (const { place, value, run } of values) {
    drawing.append(svg("circle", { cx: x(value), cy: 24 + place * ROW + ROW / 2, r: 3.5, fill: look(place).colour, "fill-opacity": 0.65 },
      svg("title", {}, `${labels[place]}: ${figure(value)} (${run.slice(0, 8)})`)));
  }
  for (const value of [0, most]) {
    drawing.append(svg("text", { x: x(value), y: height - 2, "text-anchor": value ? "end" : "start", class: "tick" }, figure(value)));
  }
  return drawing;
}

/** Rows of a CSV text by the names of its columns; fields may stand in quotes. */
export function parse(text: string): Record<string, string>[] {
  const lines = text.trim().split(/\r?\n/).map(fields);
  const head = lines.shift() ?? [];
  return lines.map((line) => Object.fromEntries(head.map((name, place) => [name, line[place] ?? ""])));
}

function fields(line: string): string[] {
  const found: string[] = [];
  for (const match of line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)) {
    found.push(match[1] !== undefined ? match[1].replaceAll('""', '"') : (match[2] ?? ""));
  }
  return found;
}
