// The runs of a job as a table, a page of the server's at a time; failed and odd ones are marked.

import { h, keyed, show, write } from "../dom";
import { link } from "../route";
import { read } from "../server";
import type { Page, Run } from "../types";
import { duration, percent, sentence, whole } from "../words";

const A_PAGE = 50;
const COLUMNS = ["run", "state", "seed", "group", "p1", "p10", "of reach", "progress"];

export interface RunsTable {
  element: HTMLElement;
  refresh(job: string, signal: AbortSignal): Promise<void>;
}

export function runsTable(): RunsTable {
  const body = h("tbody", {});
  const table = h(
    "table",
    { class: "runs" },
    h("thead", {}, h("tr", {}, ...COLUMNS.map((name) => h("th", { scope: "col" }, name)))),
    body,
  );
  const before = h("button", { type: "button" }, "Previous runs");
  const after = h("button", { type: "button" }, "Next runs");
  const where = h("span", { class: "quiet" });
  const element = h("div", {}, h("div", { class: "scroll", tabindex: 0 }, table), h("p", { class: "pages" }, before, " ", after, " ", where));
  let starts = ["0"];
  let next: string | null = null;
  let again: () => void = () => undefined;

  const refresh: RunsTable["refresh"] = async (job, signal) => {
    again = () => void refresh(job, signal);
    const page = await read<Page<Run>>(`/v1/jobs/${job}/runs?limit=${A_PAGE}&cursor=${starts.at(-1)}`, signal);
    next = page.next;
    keyed(body, page.items, (run) => `${run.index}`, row, fill);
    show(before, starts.length > 1);
    show(after, next !== null);
    const first = page.items[0]?.index ?? 0;
    write(where, page.items.length ? `runs ${whole(first + 1)} to ${whole(first + page.items.length)}` : "");
  };
  before.addEventListener("click", () => {
    starts.pop();
    again();
  });
  after.addEventListener("click", () => {
    if (next !== null) starts = [...starts, next];
    again();
  });
  return { element, refresh };
}

function row(run: Run): HTMLTableRowElement {
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, h("a", { href: link("run", run.id) }, run.id.slice(0, 8))),
    h("td", {}, h("span", { class: "badge" })),
    ...COLUMNS.slice(2).map(() => h("td", {})),
  );
}

function fill(item: HTMLTableRowElement, run: Run): void {
  const badge = item.cells[1]!.firstElementChild as HTMLElement;
  write(badge, run.state);
  badge.dataset["state"] = run.state;
  const cells = [
    whole(run.seed),
    run.label || run.method,
    run.result ? whole(run.result.p1) : "",
    run.result ? whole(run.result.p10) : "",
    run.result ? percent(run.result.fractions.p1) : "",
    run.error ??
      (run.state === "running" && run.progress
        ? sentence(percent(run.progress.fraction), run.progress.eta_s !== null && `${duration(run.progress.eta_s)} left`)
        : ""),
  ];
  cells.forEach((text, place) => write(item.cells[place + 2]!, text));
}
