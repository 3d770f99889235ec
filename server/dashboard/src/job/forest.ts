// Differences of every pair of groups with their intervals: whichever crosses zero is not decided.

import { h, show, svg } from "../dom";
import { savers } from "../charts/save";
import type { Comparison, Pair } from "../types";
import { figure } from "../words";

const ROW = 26;
const WIDTH = 760;
const NAMES = 300;
/** Pairs that are drawn; the table has them all. */
const SHOWN = 40;
const HEAD = ["pair", "n", "difference", "interval", "P(first better)", "p", "p (Holm)"];

export interface ForestPlot {
  element: HTMLElement;
  draw(comparison: Comparison | null): void;
}

export function forestPlot(): ForestPlot {
  const plot = h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Forest plot" });
  const table = h("table", {});
  let last: Comparison | null = null;
  const element = h(
    "section",
    { hidden: true },
    h("h3", {}, "Differences between groups"),
    plot,
    savers("differences", {
      svg: () => plot.querySelector("svg"),
      csv: () => (last ? [HEAD.join(","), ...last.pairs.map((pair) => cells(last!, pair).map((cell) => JSON.stringify(cell)).join(","))].join("\n") : ""),
      sentence: () => last?.pairs.map((pair) => pair.sentence).join(" ") ?? "",
    }),
    h("details", {}, h("summary", {}, "As a table"), h("div", { class: "scroll", tabindex: 0 }, table)),
  );
  return {
    element,
    draw: (comparison) => {
      last = comparison;
      const pairs = comparison?.pairs.filter((pair) => pair.difference != null).slice(0, SHOWN) ?? [];
      show(element, pairs.length > 0);
      if (!comparison || pairs.length === 0) return;
      const reach = Math.max(
        ...pairs.flatMap((pair) => [pair.difference ?? 0, pair.interval?.low ?? 0, pair.interval?.high ?? 0].map(Math.abs)),
        1e-12,
      );
      const x = (value: number): number => NAMES + ((value / reach + 1) / 2) * (WIDTH - NAMES - 20) + 10;
      const height = pairs.length * ROW + 24;
      const drawing = svg(
        "svg",
        { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": "Forest plot of differences; the table below has them all" },
        svg("line", { x1: x(0), x2: x(0), y1: 0, y2: height - 20, class: "zero" }),
      );
      pairs.forEach((pair, row) => {
        const y = row * ROW + ROW / 2;
        const look = pair.differs ? "decided" : "open";
        const at = pair.difference ?? 0;
        const { low, high } = pair.interval ?? { low: at, high: at };
        drawing.append(
          svg("text", { x: 0, y: y + 4 }, `${name(comparison, pair)}  (n ${pair.n})`.slice(0, 48)),
          svg("line", { x1: x(low), x2: x(high), y1: y, y2: y, class: look }),
          svg("circle", { cx: x(at), cy: y, r: 4, class: look }, svg("title", {}, pair.sentence)),
        );
      });
      for (const value of [-reach, 0, reach]) {
        const anchor = value < 0 ? "start" : value > 0 ? "end" : "middle";
        drawing.append(svg("text", { x: x(value), y: height - 4, "text-anchor": anchor, class: "tick" }, figure(value)));
      }
      plot.replaceChildren(drawing);
      table.replaceChildren(
        h("thead", {}, h("tr", {}, ...HEAD.map((name) => h("th", { scope: "col" }, name)))),
        h("tbody", {}, ...comparison.pairs.map((pair) => {
          const [first, ...rest] = cells(comparison, pair);
          return h("tr", {}, h("th", { scope: "row" }, first!), ...rest.map((value) => h("td", {}, value)));
        })),
      );
    },
  };
}

const name = (comparison: Comparison, pair: Pair): string =>
  [pair.first, pair.second].map((place) => comparison.groups[place]?.label ?? "").join(" – ");

function cells(comparison: Comparison, pair: Pair): string[] {
  return [
    name(comparison, pair), String(pair.n), figure(pair.difference),
    pair.interval ? `[${figure(pair.interval.low)}, ${figure(pair.interval.high)}]` : "–",
    figure(pair.improvement), figure(pair.p), figure(pair.p_holm),
  ];
}
