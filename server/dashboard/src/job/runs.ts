// The runs of a job as a table that sorts and filters; what stands out comes first.

import { h, keyed, show, write } from "../dom";
import { choose, link } from "../route";
import type { Run } from "../types";
import { duration, percent, sentence, whole } from "../words";
import { measureOf, type Odd } from "./groups";

/** Runs of a page of the table. */
const SIZES = [10, 50, 200];
const SIZE = 50;
const COLUMNS: [string, string, (run: Run) => number | string | null][] = [
  ["run", "id", (run) => run.index],
  ["state", "state", (run) => run.state],
  ["seed", "seed", (run) => run.seed],
  ["group", "group", (run) => run.label || run.method],
  ["p1", "p1", (run) => measureOf(run, "p1")],
  ["p10", "p10", (run) => measureOf(run, "p10")],
  ["of reach", "share", (run) => measureOf(run, "p1_fraction")],
  ["t90", "t90", (run) => measureOf(run, "t90_steps")],
  ["what stands out", "odd", () => null],
];

export interface RunsTable {
  element: HTMLElement;
  draw(runs: Run[], odd: Map<string, Odd>): void;
}

export function runsTable(options: URLSearchParams): RunsTable {
  let [sort, falling] = [options.get("sort") ?? "odd", options.get("falling") === "1"];
  let page = Math.max(0, (Number(options.get("page")) || 1) - 1);
  const size = h("select", { id: "runs-size" }, ...SIZES.map((one) => h("option", { value: one }, `${one}`)));
  size.value = SIZES.includes(Number(options.get("size"))) ? options.get("size")! : String(SIZE);
  let last: [Run[], Map<string, Odd>] | null = null;
  const filter = h("input", {
    type: "search", id: "runs-filter", placeholder: "Filter: words, states, seeds", "aria-label": "Filter runs",
    value: options.get("filter") ?? "",
  });
  const heads = COLUMNS.map(([title, name]) => {
    const button = h("button", { type: "button", class: "head-button" }, title);
    button.addEventListener("click", () => {
      falling = sort === name ? !falling : false;
      sort = name;
      choose("sort", sort === "odd" ? null : sort);
      choose("falling", falling ? "1" : null);
      turn(0);
    });
    return h("th", { scope: "col" }, button);
  });
  const body = h("tbody", {});
  const table = h("table", { class: "runs" }, h("thead", {}, h("tr", {}, ...heads)), body);
  const before = h("button", { type: "button" }, "Previous runs");
  const after = h("button", { type: "button" }, "Next runs");
  const where = h("span", { class: "quiet" });
  const element = h("div", {},
    h("p", { class: "tools" }, filter, h("label", { for: "runs-size" }, "a page"), size),
    h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Runs" }, table),
    h("p", { class: "pages" }, before, " ", after, " ", where));

  const draw: RunsTable["draw"] = (runs, odd) => {
    last = [runs, odd];
    const words = filter.value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    const fits = words.length === 0 ? runs : runs.filter((run) => {
      const text = `${run.id} ${run.state} ${run.seed} ${run.label} ${run.method} ${run.arena} ${odd.get(run.id)?.said ?? ""}`.toLowerCase();
      return words.every((word) => text.includes(word));
    });
    const value = COLUMNS.find(([, name]) => name === sort)?.[2] ?? (() => null);
    const key = (run: Run): number | string | null => (sort === "odd" ? (odd.get(run.id)?.rank ?? odd.size) : value(run));
    const ordered = [...fits].sort((a, b) => {
      const [x, y] = [key(a), key(b)];
      // What has no value comes last either way.
      if (x === null || y === null) return x === y ? a.index - b.index : x === null ? 1 : -1;
      const order = typeof x === "string" || typeof y === "string" ? String(x).localeCompare(String(y)) : x - y;
      return (falling ? -order : order) || a.index - b.index;
    });
    const a_page = Number(size.value);
    // Before the first answer there are no runs, and the page that a link names is still to come.
    if (runs.length > 0) page = Math.min(page, Math.max(0, Math.ceil(ordered.length / a_page) - 1));
    const shown = ordered.slice(page * a_page, (page + 1) * a_page);
    keyed(body, shown, (run) => `${run.index}`, row, (item, run) => fill(item, run, odd.get(run.id)));
    heads.forEach((head, place) => {
      if (COLUMNS[place]![1] === sort) head.setAttribute("aria-sort", falling ? "descending" : "ascending");
      else head.removeAttribute("aria-sort");
    });
    show(before, page > 0);
    show(after, (page + 1) * a_page < ordered.length);
    write(where, ordered.length === 0 ? "No run fits." : `${whole(page * a_page + 1)} to ${whole(page * a_page + shown.length)} of ${whole(ordered.length)} runs`);
  };
  const again = (): void => {
    if (last) draw(...last);
  };
  const turn = (to: number): void => {
    page = to;
    choose("page", page === 0 ? null : String(page + 1));
    again();
  };
  before.addEventListener("click", () => turn(page - 1));
  after.addEventListener("click", () => turn(page + 1));
  size.addEventListener("change", () => {
    choose("size", Number(size.value) === SIZE ? null : size.value);
    turn(0);
  });
  filter.addEventListener("input", () => {
    choose("filter", filter.value.trim() || null);
    turn(0);
  });
  return { element, draw };
}

function row(run: Run): HTMLTableRowElement {
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, h("a", { href: link("run", run.id) }, run.id.slice(0, 8))),
    h("td", {}, h("span", { class: "badge" })),
    ...COLUMNS.slice(3).map(() => h("td", {})),
    h("td", {}, h("span", {}), " ", h("a", { hidden: true, href: link("run", run.id, { explain: "1" }), title: "Steps the run again, once, and says why it did what it did" }, "Why?")),
  );
}

function fill(item: HTMLTableRowElement, run: Run, odd: Odd | undefined): void {
  const badge = item.cells[1]!.firstElementChild as HTMLElement;
  write(badge, run.state);
  badge.dataset["state"] = run.state;
  const number = (name: string): string => {
    const value = measureOf(run, name);
    return value === null ? "" : whole(value);
  };
  const cells = [
    String(run.seed),
    run.label || run.method,
    number("p1"), number("p10"),
    run.result ? percent(run.result.fractions.p1) : "",
    run.result ? number("t90_steps") || "never" : "",
    odd?.said ??
      (run.state === "running" && run.progress
        ? sentence(percent(run.progress.fraction), run.progress.eta_s != null && `${duration(run.progress.eta_s)} left`)
        : ""),
  ];
  const last = item.cells[COLUMNS.length - 1]!;
  const [said, why] = last.children as unknown as [HTMLElement, HTMLElement];
  cells.forEach((text, place) => write(place === cells.length - 1 ? said : item.cells[place + 2]!, text));
  show(why, odd?.why ?? false);
  item.classList.toggle("odd", odd !== undefined);
}
