// The transition table of the chosen robot as a heat map, states by actions, with the cell that the
// robot is in.

import { h, show, write } from "../dom";
import { heat, onTheme, ramp, themed } from "../looks";
import type { Learnt, LearntTable } from "../types";
import { figure, whole } from "../words";

const KINDS = {
  score: "score (what actions are chosen by)",
  entropy: "Q: entropy of what followed, nats",
  counts: "tries remembered",
} as const;
type Kind = keyof typeof KINDS;

export interface TableView {
  element: HTMLElement;
  draw(learnt: Learnt): void;
  /** Where the robot is now: more often than the table is read. */
  at(choice: readonly [number, number] | null): void;
  stop(): void;
}

export function tableView(): TableView {
  const kind = h("select", { id: "table-kind" }, ...Object.entries(KINDS).map(([value, text]) => h("option", { value }, text)));
  const canvas = h("canvas", { role: "img", tabindex: 0, "aria-label": "Transition table" });
  const low = h("span", {});
  const high = h("span", {});
  const colours = ramp();
  const cell = h("p", { class: "facts", "aria-live": "off" });
  const element = h(
    "section",
    { hidden: true, "aria-labelledby": "table-title" },
    h("h3", { id: "table-title" }, "What it has learnt"),
    h("p", { class: "tools" }, h("label", { for: "table-kind" }, "Show"), kind),
    h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Transition table" }, canvas),
    h("p", { class: "legend-row quiet" }, low, colours, high),
    cell,
  );
  let table: LearntTable | null = null;
  let now: readonly [number, number] | null = null;
  let picked: readonly [number, number] | null = null;
  let box = 10;

  const value = (t: LearntTable, i: number, j: number): number | null => t[kind.value as Kind][i]?.[j] ?? null;
  const draw = (): void => {
    const brush = canvas.getContext("2d");
    if (!table || !brush) return;
    const rows = table.counts.length;
    const columns = table.counts[0]?.length ?? 0;
    const density = devicePixelRatio || 1;
    box = Math.max(4, Math.min(16, Math.floor(300 / Math.max(columns, 1)), Math.floor(420 / Math.max(rows, 1))));
    canvas.width = columns * box * density;
    canvas.height = rows * box * density;
    canvas.style.width = `${columns * box}px`;
    canvas.style.height = `${rows * box}px`;
    let [least, most] = [Infinity, -Infinity];
    for (const row of table[kind.value as Kind]) {
      for (const one of row) {
        if (one === null) continue;
        least = Math.min(least, one);
        most = Math.max(most, one);
      }
    }
    if (least > most) [least, most] = [0, 0];
    const floor = themed("--line");
    const side = box * density;
    for (let i = 0; i < rows; i++) {
      for (let j = 0; j < columns; j++) {
        const one = value(table, i, j);
        brush.fillStyle = one === null || (kind.value !== "counts" && table.counts[i]?.[j] === 0)
          ? floor
          : `rgb(${heat(most > least ? (one - least) / (most - least) : 0.5).join(",")})`;
        brush.fillRect(j * side, i * side, side - density, side - density);
      }
    }
    const at = now ?? [table.state, table.action];
    brush.strokeStyle = themed("--bad");
    brush.lineWidth = 2 * density;
    brush.strokeRect(density, at[0] * side, columns * side - 2 * density, side - density);
    brush.strokeStyle = themed("--ink");
    brush.strokeRect(at[1] * side, at[0] * side, side - density, side - density);
    write(low, figure(least));
    write(high, figure(most));
    const [i, j] = picked ?? at;
    const tried = table.counts[i]?.[j] ?? 0;
    const score = table.score[i]?.[j] ?? null;
    write(
      cell,
      `${picked ? "Cell" : "Now in"} state ${i} of ${whole(table.states_total)}, action ${j} of ${columns}: ` +
        (tried === 0
          ? "never tried"
          : `tried ${whole(tried)} times, Q ${figure(table.entropy[i]?.[j])} nats, score ${figure(score)}`),
    );
    canvas.setAttribute(
      "aria-label",
      `Table of ${whole(table.states_total)} states by ${columns} actions; the robot is in state ${at[0]}, its last action is ${at[1]}. Arrow keys move through cells.`,
    );
  };
  const pick = (i: number, j: number): void => {
    if (!table) return;
    picked = [
      Math.min(Math.max(i, 0), table.counts.length - 1),
      Math.min(Math.max(j, 0), (table.counts[0]?.length ?? 1) - 1),
    ];
    draw();
  };
  canvas.addEventListener("click", (event) => pick(Math.floor(event.offsetY / box), Math.floor(event.offsetX / box)));
  canvas.addEventListener("mouseleave", () => {
    picked = null;
    draw();
  });
  canvas.addEventListener("blur", () => { picked = null; });
  canvas.addEventListener("keydown", (event) => {
    const move = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
    if (!move || !table) return;
    event.preventDefault();
    event.stopPropagation();
    const [i, j] = picked ?? now ?? [table.state, table.action];
    pick(i + move[0]!, j + move[1]!);
  });
  kind.addEventListener("change", draw);
  return {
    element,
    stop: onTheme(draw),
    draw: (learnt) => {
      table = learnt.table ?? null;
      show(element, table !== null && table.counts.length > 0);
      draw();
    },
    at: (choice) => {
      if (choice?.[0] === now?.[0] && choice?.[1] === now?.[1]) return;
      now = choice;
      if (!element.hidden) draw();
    },
  };
}
