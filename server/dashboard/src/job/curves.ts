// Curves of groups with their bands, and a legend that is a table: n stands beside each group.

import { h, keyed, write } from "../dom";
import { look } from "../looks";
import { lineChart } from "../charts/line";
import { choose } from "../route";
import type { Curves } from "../types";
import { figure, percent, whole } from "../words";

/** Fewest runs that have a band. */
export const BAND_FROM = 3;

export interface CurvesChart {
  element: HTMLElement;
  draw(curves: Curves, how: { log: boolean; single: boolean }): void;
  stop(): void;
}

/** `hidden` are labels that are not drawn, `zoom` the epochs that are. */
export function curvesChart(hidden: Set<string>, zoom: [number, number] | null): CurvesChart {
  const text = h("p", { class: "quiet" });
  const legend = h("ul", { class: "plain legend", "aria-label": "Legend" });
  const chart = lineChart(
    "curves", "Curves of the groups; the list below has their last values",
    (x) => choose("zoom", x ? x.map((value) => Math.round(value)).join("-") : null), zoom, () => said,
  );
  const element = h("figure", { class: "curves" }, chart.element, legend, h("figcaption", {}, text));
  let last: Parameters<CurvesChart["draw"]> | null = null;
  let said = "";

  const draw: CurvesChart["draw"] = (curves, how) => {
    last = [curves, how];
    const told = (value: number | null | undefined): string => (isShare(curves) && value != null ? percent(value) : figure(value));
    const lines = curves.groups.map((group, place) => ({ group, look: look(place) }));
    chart.draw({
      x: { name: curves.x, at: curves.at },
      y: { name: isShare(curves) ? `${curves.measure.replace("_fraction", "")}, share of what can be reached` : `${curves.measure}, squares`, log: how.log, share: isShare(curves) },
      lines: lines.filter(({ group }) => !hidden.has(group.label)).map(({ group, look }) => ({
        label: group.label || "all runs",
        look,
        n: group.n,
        mean: group.mean as (number | null)[],
        ...(group.runs_done >= BAND_FROM && !how.single && { low: group.low as (number | null)[], high: group.high as (number | null)[] }),
        ...((how.single || group.runs_done < BAND_FROM) && { runs: (group.runs ?? []).map((run) => run.values as (number | null)[]) }),
      })),
    });
    keyed(
      legend,
      curves.groups,
      (group) => group.label,
      (group) => {
        const box = h("input", { type: "checkbox", checked: !hidden.has(group.label) });
        box.addEventListener("change", () => {
          if (box.checked) hidden.delete(group.label);
          else hidden.add(group.label);
          choose("hide", hidden.size ? [...hidden].join("|") : null);
          if (last) draw(...last);
        });
        return h("li", {}, h("label", {}, box, swatch(curves.groups.indexOf(group)), h("span", {})));
      },
      (item, group) => {
        // Runs of fewer epochs end before the others.
        const place = lastOf(group.n);
        const [mean, low, high] = [group.mean, group.low, group.high].map((list) => list[place] ?? null);
        const band = group.runs_done >= BAND_FROM && low != null && high != null;
        const interval = band ? ` [${told(low)}, ${told(high)}]` : "";
        write(item.querySelector("span:last-child")!, `${group.label || "all runs"}  ${told(mean)}${interval}  n ${whole(group.n[place] ?? 0)}${place < group.n.length - 1 && place >= 0 ? `, to ${curves.x} ${whole(curves.at[place]!)}` : ""}`);
      },
    );
    const at = curves.at.at(-1);
    said = at === undefined ? "" : `After ${whole(at)} ${curves.x}s the mean of ${curves.measure} was ${curves.groups.map((group) => {
      const place = lastOf(group.n);
      const [mean, low, high] = [group.mean, group.low, group.high].map((list) => list[place] ?? null);
      return `${told(mean)}${low != null && high != null ? ` [${told(low)}, ${told(high)}]` : ""} for ${group.label || "all runs"} (n = ${whole(group.n[place] ?? 0)}${place < group.n.length - 1 && place >= 0 ? `, after ${whole(curves.at[place]!)}` : ""})`;
    }).join(", ")}; ${Math.round(curves.level * 100)} % intervals.`;
    write(
      text,
      `Mean of ${curves.measure} by ${curves.x} over all finished runs of each group` +
        (how.single ? ", with single runs (at most 50 a group) as thin lines." : `, with ${Math.round(curves.level * 100)} % intervals; no band for fewer than ${BAND_FROM} runs. Drag to zoom, double-click for all.`) +
        (isShare(curves) ? " Slivers along walls, which do not count as reachable, can be entered: a curve may end a little above the share in the table." : ""),
    );
  };
  return { element, draw, stop: chart.stop };
}

/** The last place at which there is a run. */
const lastOf = (n: readonly number[]): number => n.findLastIndex((count) => count > 0);

const isShare = (curves: Curves): boolean => curves.measure.endsWith("_fraction");

/** The line of a group in a legend. */
export function swatch(place: number): HTMLElement {
  const { colour, dash } = look(place);
  const style = dash.length === 0 ? "solid" : dash[0]! > 4 ? "dashed" : "dotted";
  const line = h("span", { class: "swatch", "aria-hidden": true });
  // Not as an attribute: the page's policy refuses styles in its text.
  line.style.borderTop = `3px ${style} ${colour}`;
  return line;
}
