// Differences of every pair of groups with their intervals: whichever crosses zero is not decided.

import { h, svg, show } from "../dom";
import type { Comparison, Pair } from "./pooled";
import { figure } from "../words";

const ROW = 26;
const WIDTH = 760;
const NAMES = 300;
/** Pairs that are drawn; the table has them all. */
const SHOWN = 40;

export interface ForestPlot {
  element: HTMLElement;
  draw(comparison: Comparison): void;
}

export function forestPlot(): ForestPlot {
  const plot = h("div", { class: "scroll", tabindex: 0 });
  const table = h("table", {});
  const element = h(
    "section",
    { hidden: true },
    h("h3", {}, "Differences between groups"),
    plot,
    h("details", {}, h("summary", {}, "As a table"), h("div", { class: "scroll", tabindex: 0 }, table)),
  );
  return {
    element,
    draw: (comparison) => {
      const name = (pair: Pair): string =>
        [pair.first, pair.second].map((place) => comparison.groups[place]?.label ?? "").join(" – ");
      const pairs = comparison.pairs.filter((pair) => pair.difference !== null).slice(0, SHOWN);
      show(element, pairs.length > 0);
      const reach = Math.max(
        ...pairs.flatMap((pair) => [pair.difference ?? 0, pair.interval?.low ?? 0, pair.interval?.high ?? 0].map(Math.abs)),
        1e-12,
      );
      const x = (value: number): number => NAMES + ((value / reach + 1) / 2) * (WIDTH - NAMES - 20) + 10;
      const height = pairs.length * ROW + 24;
      const drawing = svg(
        "svg",
        { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": "Forest plot of differences" },
        svg("line", { x1: x(0), x2: x(0), y1: 0, y2: height - 20, class: "zero" }),
      );
      pairs.forEach((pair, row) => {
        const y = row * ROW + ROW / 2;
        const decided = pair.differs;
        const at = pair.difference ?? 0;
        const { low, high } = pair.interval ?? { low: at, high: at };
        drawing.append(
          svg("text", { x: 0, y: y + 4 }, `${name(pair)}  (n ${pair.n})`.slice(0, 48)),
          svg("line", { x1: x(low), x2: x(high), y1: y, y2: y, class: decided ? "decided" : "open" }),
          svg("circle", { cx: x(at), cy: y, r: 4, class: decided ? "decided" : "open" },
            svg("title", {}, pair.sentence)),
        );
      });
      for (const value of [-reach, 0, reach]) {
        drawing.append(svg("text", { x: x(value), y: height - 4, "text-anchor": "middle", class: "tick" }, figure(value)));
      }
      plot.replaceChildren(drawing);
      const head = ["pair", "n", "difference", "interval", "P(first better)", "p", "p (Holm)"];
      table.replaceChildren(
        h("thead", {}, h("tr", {}, ...head.map((name) => h("th", { scope: "col" }, name)))),
        h("tbody", {}, ...comparison.pairs.map((pair) =>
          h("tr", {},
            h("th", { scope: "row" }, name(pair)),
            ...[
              String(pair.n), figure(pair.difference),
              pair.interval ? `[${figure(pair.interval.low)}, ${figure(pair.interval.high)}]` : "–",
              figure(pair.improvement), figure(pair.p), figure(pair.p_holm),
            ].map((value) => h("td", {}, value))))),
      );
    },
  };
}
