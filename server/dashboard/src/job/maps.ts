// Where the runs of each group went: the share of them that entered each square, or mean entries.

import { h, keyed, show, write } from "../dom";
import { heatPixels, onTheme, ramp } from "../looks";
import { choose } from "../route";
import { read } from "../server";
import { savers } from "../charts/save";
import type { GroupCoverage } from "../types";
import { figure, whole } from "../words";

/** Groups whose maps are read at once. */
const AT_ONCE = 12;
const KINDS = { runs: "share of runs that entered", mean_entries: "mean entries (log scale)" } as const;

export function coverageMaps(job: string, isOpen: boolean) {
  const kind = h("select", { id: "map-kind" }, ...Object.entries(KINDS).map(([value, text]) => h("option", { value }, text)));
  const low = h("span", {});
  const high = h("span", {});
  const colours = ramp();
  const maps = h("div", { class: "maps" });
  const more = h("button", { type: "button", hidden: true }, "More groups");
  const element = h(
    "details",
    { open: isOpen },
    h("summary", {}, "Coverage maps by group"),
    h("p", { class: "tools" }, h("label", { for: "map-kind" }, "Show"), kind, h("span", { class: "legend-row quiet" }, low, colours, high)),
    maps, more,
  );
  let found: GroupCoverage[] = [];
  let wanted: { by: string | null; groups: number; key: string } | null = null;
  let limit = AT_ONCE;
  let read_key = "";
  const csvs = new WeakMap<HTMLCanvasElement, string>();

  const draw = (): void => {
    const values = (map: GroupCoverage): number[][] =>
      kind.value === "runs" ? map.runs.map((row) => row.map((runs) => runs / Math.max(map.n, 1))) : map.mean_entries;
    let most = kind.value === "runs" ? 1 : 0;
    if (kind.value !== "runs") for (const map of found) for (const row of values(map)) for (const value of row) most = Math.max(most, value);
    write(low, kind.value === "runs" ? "one run" : "0");
    write(high, kind.value === "runs" ? "all runs" : figure(most));
    keyed(
      maps, found, (map) => `${map.group}`,
      () => {
        const canvas = h("canvas", { role: "img" });
        const caption = h("figcaption", { class: "facts" });
        return h("figure", {}, canvas, caption, savers("map", { png: () => canvas, csv: () => csvs.get(canvas) ?? "" }));
      },
      (item, map) => {
        const canvas = item.querySelector("canvas")!;
        const [columns, rows] = map.squares as [number, number];
        canvas.width = columns;
        canvas.height = rows;
        const brush = canvas.getContext("2d");
        if (!brush || columns === 0) return;
        const image = brush.createImageData(columns, rows);
        const pixels = new Uint32Array(image.data.buffer);
        const heat = heatPixels();
        values(map).forEach((row, y) => row.forEach((value, x) => {
          if (value <= 0) return;
          const share = kind.value === "runs" ? value : Math.log1p(value) / Math.log1p(most || 1);
          pixels[(rows - 1 - y) * columns + x] = heat[Math.round(share * 255)]!;
        }));
        brush.putImageData(image, 0, 0);
        csvs.set(canvas, values(map).map((row) => row.join(",")).join("\n"));
        const label = map.label || "all runs";
        write(item.querySelector("figcaption")!, `${label}: n ${whole(map.n)}, ${figure(map.mean_squares)} squares a run, ${whole(map.union_squares)} by any`);
        canvas.setAttribute("aria-label", `Squares that runs of ${label} entered`);
      },
    );
  };
  const fetchAll = async (): Promise<void> => {
    if (!wanted || !element.open || wanted.key === read_key) return;
    const { by, groups, key } = wanted;
    read_key = key;
    const next: GroupCoverage[] = [];
    for (let group = 0; group < Math.min(groups, limit); group++) {
      const query = new URLSearchParams({ group: String(group), ...(by && { by }) });
      next.push(await read<GroupCoverage>(`/v1/jobs/${job}/coverage?${query}`));
    }
    found = next.filter((map) => map.n > 0);
    show(more, groups > limit);
    draw();
  };
  kind.addEventListener("change", draw);
  const stop = onTheme(draw);
  more.addEventListener("click", () => {
    limit += AT_ONCE;
    read_key = "";
    void fetchAll();
  });
  element.addEventListener("toggle", () => {
    choose("maps", element.open ? "1" : null);
    void fetchAll();
  });
  return {
    element,
    stop,
    draw: async (by: string | null, groups: number, key: string): Promise<void> => {
      wanted = { by, groups, key: `${by} ${groups} ${key}` };
      await fetchAll();
    },
  };
}
