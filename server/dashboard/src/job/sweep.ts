// A sweep of two fields as a heat map: one measure, pooled over seeds and whatever else varies.

import { h, show, svg, write } from "../dom";
import { heat } from "../looks";
import { choose } from "../route";
import { savers } from "../charts/save";
import type { Summary } from "../types";
import { figure, whole } from "../words";
import { plain, varied } from "./groups";

const CELL = 64;
const LOW = 30;
const LEFT = 150;

export function sweepMap(options: URLSearchParams) {
  const rows = h("select", { id: "sweep-rows" });
  const columns = h("select", { id: "sweep-columns" });
  const plot = h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Sweep" });
  const text = h("p", { class: "quiet" });
  let csv = "";
  const element = h(
    "section",
    { hidden: true },
    h("h3", {}, "Two fields at once"),
    h("p", { class: "tools" }, h("label", { for: "sweep-rows" }, "Rows"), rows, h("label", { for: "sweep-columns" }, "Columns"), columns),
    plot, text,
    savers("sweep", { svg: () => plot.querySelector("svg"), csv: () => csv }),
  );
  let last: [Summary, string] | null = null;
  const draw = (summary: Summary, measure: string): void => {
    last = [summary, measure];
    const fields = varied(summary);
    show(element, fields.length > 1);
    if (fields.length < 2) return;
    for (const [select, place] of [[rows, 0], [columns, 1]] as const) {
      if (select.options.length !== fields.length) {
        select.replaceChildren(...fields.map((field) => h("option", { value: field }, field)));
        const wished = options.get(place === 0 ? "rows" : "columns");
        select.value = wished && fields.includes(wished) ? wished : fields[place]!;
      }
    }
    const [ys, xs] = [rows.value, columns.value].map((field) => [...new Set(summary.groups.map((group) => plain(group.values[field] ?? "")))]);
    const cells = new Map<string, { sum: number; n: number }>();
    for (const group of summary.groups) {
      const found = group.measures.find((one) => one.name === measure);
      if (found?.mean == null) continue;
      const key = `${plain(group.values[rows.value] ?? "")}\n${plain(group.values[columns.value] ?? "")}`;
      const cell = cells.get(key) ?? { sum: 0, n: 0 };
      cells.set(key, { sum: cell.sum + found.mean * found.n, n: cell.n + found.n });
    }
    const means = [...cells.values()].map((cell) => cell.sum / cell.n);
    const [least, most] = [Math.min(...means), Math.max(...means)];
    const width = LEFT + xs!.length * CELL;
    const height = ys!.length * LOW + 30;
    const drawing = svg("svg", { viewBox: `0 0 ${width} ${height}`, width, class: "as-is", role: "img", "aria-label": `${measure} by ${rows.value} and ${columns.value}` });
    const table = [["", ...xs!].map((cell) => JSON.stringify(cell)).join(",")];
    ys!.forEach((y, row) => {
      drawing.append(svg("text", { x: LEFT - 8, y: row * LOW + 20, "text-anchor": "end" }, y.slice(0, 22)));
      const line = [JSON.stringify(y)];
      xs!.forEach((x, column) => {
        const cell = cells.get(`${y}\n${x}`);
        line.push(cell ? String(cell.sum / cell.n) : "");
        if (!cell) return;
        const mean = cell.sum / cell.n;
        const colour = heat(most > least ? (mean - least) / (most - least) : 0.5);
        const light = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2] > 120;
        drawing.append(
          svg("rect", { x: LEFT + column * CELL, y: row * LOW, width: CELL - 2, height: LOW - 2, fill: `rgb(${colour.join(",")})` },
            svg("title", {}, `${y}, ${x}: mean ${figure(mean)}, n ${cell.n}`)),
          svg("text", { x: LEFT + column * CELL + CELL / 2 - 1, y: row * LOW + 19, "text-anchor": "middle", class: light ? "on-light" : "on-dark" }, figure(mean)),
        );
      });
      table.push(line.join(","));
    });
    xs!.forEach((x, column) => drawing.append(svg("text", { x: LEFT + column * CELL + CELL / 2, y: height - 12, "text-anchor": "middle", class: "tick" }, x.slice(0, 10))));
    csv = table.join("\n");
    plot.replaceChildren(drawing);
    const n = [...cells.values()].reduce((sum, cell) => sum + cell.n, 0);
    write(text, `Means of ${measure} from ${figure(least)} to ${figure(most)}, n = ${whole(n)} runs in all${fields.length > 2 ? "; what else varies is pooled" : ""}.`);
  };
  for (const [select, name] of [[rows, "rows"], [columns, "columns"]] as const) {
    select.addEventListener("change", () => {
      choose(name, select.value);
      if (last) draw(...last);
    });
  }
  return { element, draw };
}
