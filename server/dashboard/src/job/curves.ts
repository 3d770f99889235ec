// Curves of groups with their bands, and a legend that is a table: n stands beside each group.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { h, keyed, write } from "../dom";
import { look, themed } from "../looks";
import type { Curves } from "./pooled";
import { figure, whole } from "../words";

/** Fewest runs that have a band. */
const BAND_FROM = 3;
const HEIGHT = 340;

export interface CurvesChart {
  element: HTMLElement;
  draw(curves: Curves, labels: string[], how: { log: boolean; measure: string }): void;
  stop(): void;
}

export function curvesChart(): CurvesChart {
  const plot = h("div", { class: "plot", role: "img", "aria-labelledby": "curves-text" });
  const text = h("figcaption", { id: "curves-text", class: "quiet" });
  const legend = h("ul", { class: "plain legend", "aria-label": "Groups" });
  const save = h("button", { type: "button" }, "PNG");
  const csv = h("button", { type: "button" }, "CSV");
  const element = h("figure", { class: "curves" }, plot, legend, text, h("p", {}, save, " ", csv));
  const hidden = new Set<string>();
  let chart: uPlot | null = null;
  let last: Parameters<CurvesChart["draw"]> | null = null;

  const draw: CurvesChart["draw"] = (curves, labels, how) => {
    last = [curves, labels, how];
    const [ink, line] = [themed("--quiet"), themed("--line")];
    const place = (label: string): number => Math.max(labels.indexOf(label), 0);
    const shown = curves.groups.filter((group) => !hidden.has(group.label));
    const data: (number | null)[][] = [curves.at];
    const series: uPlot.Series[] = [{ label: curves.x }];
    const bands: uPlot.Band[] = [];
    const drawn = (value: number | null): number | null =>
      value === null || (how.log && value <= 0) ? null : value;
    for (const group of shown) {
      const { colour, dash } = look(place(group.label));
      const first = data.length;
      data.push(group.mean.map(drawn));
      series.push({ label: group.label, stroke: colour, width: 2, dash: [...dash], spanGaps: true, points: { show: false } });
      if (group.runs_done >= BAND_FROM) {
        data.push(group.high.map(drawn), group.low.map(drawn));
        const edge: uPlot.Series = { label: "", stroke: "transparent", spanGaps: true, points: { show: false } };
        series.push(edge, { ...edge });
        bands.push({ series: [first + 1, first + 2], fill: `${colour}33` });
      }
    }
    chart?.destroy();
    plot.replaceChildren();
    const font = "12px system-ui, sans-serif";
    const axis = { stroke: ink, font, labelFont: font, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
    chart = new uPlot(
      {
        width: Math.max(plot.clientWidth, 280),
        height: HEIGHT,
        legend: { show: false },
        cursor: { drag: { x: true, y: false } },
        scales: { x: { time: false }, y: { distr: how.log ? 3 : 1 } },
        axes: [
          { ...axis, label: curves.x },
          { ...axis, label: how.measure, size: 64, values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : figure(tick))) },
        ],
        series,
        bands,
      },
      data as uPlot.AlignedData,
      plot,
    );
    keyed(
      legend,
      curves.groups,
      (group) => group.label,
      (group) => {
        const box = h("input", { type: "checkbox", checked: true });
        box.addEventListener("change", () => {
          if (box.checked) hidden.delete(group.label);
          else hidden.add(group.label);
          if (last) draw(...last);
        });
        return h("li", {}, h("label", {}, box, swatch(place(group.label)), h("span", {})));
      },
      (item, group) => {
        const [mean, low, high] = [group.mean, group.low, group.high].map((list) => list.at(-1) ?? null);
        const band = group.runs_done >= BAND_FROM && low !== null && high !== null;
        const interval = band ? ` [${figure(low)}, ${figure(high)}]` : "";
        const name = item.querySelector("span:last-child")!;
        write(name, `${group.label || "all runs"}  ${figure(mean)}${interval}  n ${whole(group.n.at(-1) ?? 0)}`);
      },
    );
    write(
      text,
      `Mean of ${how.measure} by ${curves.x} over all finished runs of each group, with ` +
        `${Math.round(curves.level * 100)} % intervals; no band for fewer than ${BAND_FROM} runs.`,
    );
  };
  const resize = new ResizeObserver(() => {
    if (chart && plot.clientWidth > 0) chart.setSize({ width: plot.clientWidth, height: HEIGHT });
  });
  resize.observe(plot);
  const theme = matchMedia("(prefers-color-scheme: dark)");
  const again = (): void => {
    if (last) draw(...last);
  };
  theme.addEventListener("change", again);
  save.addEventListener("click", () => {
    const canvas = plot.querySelector("canvas");
    if (canvas) download("curves.png", canvas.toDataURL("image/png"));
  });
  csv.addEventListener("click", () => {
    if (last) download("curves.csv", `data:text/csv;charset=utf-8,${encodeURIComponent(rows(last[0]))}`);
  });
  return {
    element,
    draw,
    stop: () => {
      resize.disconnect();
      theme.removeEventListener("change", again);
      chart?.destroy();
    },
  };
}

/** The line of a group in a legend. */
export function swatch(place: number): HTMLElement {
  const { colour, dash } = look(place);
  const style = dash.length === 0 ? "solid" : dash[0]! > 4 ? "dashed" : "dotted";
  const line = h("span", { class: "swatch", "aria-hidden": true });
  // Not as an attribute: the page's policy refuses styles in its text.
  line.style.borderTop = `3px ${style} ${colour}`;
  return line;
}

export function download(name: string, href: string): void {
  h("a", { download: name, href }).click();
}

function rows(curves: Curves): string {
  const cell = (value: number | null | undefined): string => String(value ?? "");
  const lines = curves.groups.flatMap((group) =>
    curves.at.map((x, place) =>
      [JSON.stringify(group.label), x, ...[group.n, group.mean, group.low, group.high].map((list) => cell(list[place]))].join(","),
    ),
  );
  return [`group,${curves.x},n,mean,low,high`, ...lines].join("\n");
}
