// Every run as a dot, by group, for each of the four coverage counts: nothing hides in a mean.

import { h, svg, write } from "../dom";
import { look } from "../looks";
import { read } from "../server";
import type { Page, Run, Summary } from "../types";
import { figure, whole } from "../words";

const MEASURES = ["p1", "p2", "p5", "p10"] as const;
const ROW = 22;
const WIDTH = 360;
/** Most runs that are drawn. */
const MOST = 2_000;

export interface StripPlots {
  element: HTMLElement;
  draw(job: string, summary: Summary, signal: AbortSignal): Promise<void>;
}

export function stripPlots(): StripPlots {
  const plots = h("div", { class: "strips" });
  const cut = h("p", { class: "quiet" });
  const element = h("section", {}, h("h3", {}, "All finished runs"), plots, cut);
  return {
    element,
    draw: async (job, summary, signal) => {
      const runs: Run[] = [];
      let next: string | null = "0";
      while (next !== null && runs.length < MOST) {
        const page: Page<Run> = await read(`/v1/jobs/${job}/runs?limit=200&cursor=${next}`, signal);
        runs.push(...page.items.filter((run) => run.result !== null));
        next = page.next;
      }
      write(cut, next === null ? "" : `The first ${whole(runs.length)} finished runs are shown.`);
      const labels = summary.groups.map((group) => group.label);
      plots.replaceChildren(...MEASURES.map((measure) => strip(measure, labels, runs, summary)));
    },
  };
}

function strip(measure: (typeof MEASURES)[number], labels: string[], runs: Run[], summary: Summary): Element {
  const values = runs
    .map((run) => ({ place: labels.indexOf(run.label), value: run.result?.[measure] ?? 0, run: run.id }))
    .filter((run) => run.place >= 0);
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
