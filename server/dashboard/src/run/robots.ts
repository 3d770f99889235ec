// How far each robot has learnt: clusters, fitness, memory against its bound; a page of them at a time.

import { h, keyed, measure, show, write } from "../dom";
import { choose } from "../route";
import { Problem, read, watch } from "../server";
import type { Learning, Run } from "../types";
import { bytes, figure, sentence, whole } from "../words";
import { trouble } from "../alert";

const EVERY_MS = 2_000;
/** Robots of a page. */
const A_PAGE = 20;
const HEAD = ["robot", "sensors", "commands", "fitness", "memory", ""];

export interface Robots {
  element: HTMLElement;
  /** The run as it is. */
  run(run: Run): void;
  stop(): void;
}

/** `pick` gets the robot that a person chooses. */
export function robotsTable(id: string, options: URLSearchParams, pick: (robot: number) => void): Robots {
  const said = h("p", { class: "facts", role: "status" });
  const body = h("tbody", {});
  const before = h("button", { type: "button", hidden: true }, "Previous robots");
  const after = h("button", { type: "button", hidden: true }, "Next robots");
  const table = h("table", {}, h("thead", {}, h("tr", {}, ...HEAD.map((name) => h("th", { scope: "col" }, name || h("span", { class: "unseen" }, "share of its bound"))))), body);
  const element = h("details", { open: options.get("robots") === "1" },
    h("summary", {}, "How far each robot has learnt"), said,
    h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Robots" }, table), h("p", { class: "pages" }, before, " ", after));
  let from = 0;
  let run: Run | null = null;
  /** What is shown, where it does not change any more. */
  let settled = "";

  const draw = (learning: Learning): void => {
    const most = learning.budget_bytes ?? learning.memory.plan.bytes;
    const { model } = learning;
    write(said, sentence(
      `${learning.phase}, epoch ${whole(learning.epochs_done)} of ${whole(learning.epochs_total)}`,
      `learners hold ${bytes(learning.memory.least_bytes)} to ${bytes(learning.memory.most_bytes)} of ${bytes(most)}${learning.budget_bytes === null ? "" : " (budget)"}`,
      learning.memory.robots_saturated > 0 && `${whole(learning.memory.robots_saturated)} had vectors without room`,
      model && `robot 0's table is ${figure(model.divergence_nats / Math.max(model.pairs, 1))} nats a pair from the reference, over ${whole(model.pairs)} pairs`,
      learning.items.length === 0 && "its last state is not kept any more, only its result",
    ));
    keyed(body, learning.items, (one) => `${one.robot}`,
      (one) => {
        const button = h("button", { type: "button", "aria-label": `Choose robot ${one.robot}` }, `${one.robot}`);
        button.addEventListener("click", () => pick(one.robot));
        return h("tr", {}, h("th", { scope: "row" }, button), ...HEAD.slice(2).map(() => h("td", {})), h("td", {}, h("progress", { max: 1, "aria-hidden": true })));
      },
      (row, one) => {
        const cells = [
          `${whole(one.sensor_clusters)}`, `${whole(one.actuator_clusters)}`,
          one.fitness == null ? "–" : figure(one.fitness), bytes(one.bytes),
        ];
        cells.forEach((text, place) => write((row as HTMLTableRowElement).cells[place + 1]!, text));
        measure(row.querySelector("progress")!, Math.min(one.bytes / Math.max(most, 1), 1));
      });
    show(before, from > 0);
    show(after, learning.next != null);
  };
  const watching = watch(EVERY_MS, async (signal) => {
    if (!element.open || !run || ["failed", "cancelled"].includes(run.state)) return;
    const what = `${run.state} ${from}`;
    if (run.state !== "running" && what === settled) return;
    try {
      draw(await read<Learning>(`/v1/runs/${id}/learning?limit=${A_PAGE}&cursor=${from}`, signal));
      settled = what;
    } catch (error) {
      if (!(error instanceof Problem && error.status === 409)) throw error;
      settled = what;
      write(said, error.message);
    }
  }, trouble);
  const turn = (by: number): void => {
    from = Math.max(0, from + by);
    watching.now();
  };
  before.addEventListener("click", () => turn(-A_PAGE));
  after.addEventListener("click", () => turn(A_PAGE));
  element.addEventListener("toggle", () => {
    choose("robots", element.open ? "1" : null);
    watching.now();
  });
  return {
    element,
    run: (next) => {
      const isNew = run?.state !== next.state;
      run = next;
      // A method that learns nothing has nothing to show.
      show(element, next.state !== "done" || next.result?.clusters.sensor !== 0);
      if (isNew) watching.now();
    },
    stop: () => watching.stop(),
  };
}
