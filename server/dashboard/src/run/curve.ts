// What one run covered over its epochs: squares entered at least 1, 2, 5 and 10 times.

import { h } from "../dom";
import { look } from "../looks";
import type { CurveRow } from "../types";
import { lineChart } from "../charts/line";

const LEVELS = ["p1", "p2", "p5", "p10"] as const;

export function curveChart() {
  const chart = lineChart("coverage", "Coverage of this run over its epochs");
  const element = h("section", { hidden: true }, h("h3", {}, "Coverage over epochs"), chart.element);
  return {
    element,
    stop: chart.stop,
    draw: (rows: CurveRow[]): void => {
      element.hidden = rows.length < 2;
      if (rows.length < 2) return;
      chart.draw({
        x: { name: "epoch", at: rows.map((row) => row.epoch) },
        y: { name: "squares", log: false },
        labelled: true,
        lines: LEVELS.map((level, place) => ({
          label: level, look: look(place), mean: rows.map((row) => row[level]),
        })),
      });
    },
  };
}
