// The list of jobs at the side: search, states, progress; newest first.

import { h, keyed, measure, show, write } from "../dom";
import { link } from "../route";
import { read, watch } from "../server";
import type { Job, Page } from "../types";
import { calm, trouble } from "../alert";
import { compact, duration, percent, sentence, whole } from "../words";

const EVERY_MS = 4_000;
const A_PAGE = 50;

export const title = (job: { id: string; name: string }): string => job.name || `Job ${job.id}`;

export interface JobList {
  element: HTMLElement;
  choose(id: string): void;
  search(): void;
}

export function jobList(tell: (rate: string) => void): JobList {
  const search = h("input", {
    type: "search", id: "search", placeholder: "Search jobs", "aria-label": "Search jobs by name",
  });
  const state = h(
    "select",
    { "aria-label": "Jobs in state" },
    ...["all", "running", "queued", "paused", "done", "failed", "cancelled"].map((name) =>
      h("option", { value: name === "all" ? "" : name }, name),
    ),
  );
  const items = h("ol", { class: "plain" });
  const older = h("button", { type: "button", hidden: true }, "Older jobs");
  const none = h("p", { class: "quiet", hidden: true }, "No job fits.");
  const element = h(
    "nav",
    { class: "jobs", id: "jobs", "aria-label": "Jobs" },
    h("div", { class: "filters" }, search, state),
    items, none, older,
  );
  let chosen = "";
  let limit = A_PAGE;
  let jobs: Job[] = [];
  let fitting: Job[] = [];

  const draw = (): void => {
    const wanted = search.value.trim().toLowerCase();
    const known = new Map([...jobs, ...fitting].map((job) => [job.id, job]));
    const fits = [...known.values()].filter(
      (job) =>
        (!state.value || job.state === state.value) &&
        (!wanted || wanted.split(/\s+/).every((word) => `${title(job)} ${job.id}`.toLowerCase().includes(word))),
    ).sort((a, b) => Number(b.id) - Number(a.id));
    keyed(items, fits, (job) => job.id, card, update);
    show(none, jobs.length > 0 && fits.length === 0);
  };
  const card = (job: Job): HTMLLIElement =>
    h(
      "li",
      {},
      h(
        "a",
        { class: "card", href: link("job", job.id) },
        h("span", { class: "title" }),
        h("span", { class: "badge" }),
        h("progress", { max: 1, "aria-hidden": true }),
        h("span", { class: "facts" }),
      ),
    );
  const update = (item: HTMLLIElement, job: Job): void => {
    const [name, badge, bar, facts] = item.firstElementChild!.children as unknown as [
      HTMLElement, HTMLElement, HTMLProgressElement, HTMLElement,
    ];
    write(name, title(job));
    write(badge, job.state);
    badge.dataset["state"] = job.state;
    measure(bar, job.progress);
    write(
      facts,
      sentence(
        `${whole(job.runs.done)} of ${whole(job.runs.total)} runs`,
        job.runs.failed > 0 && `${whole(job.runs.failed)} failed`,
        job.state === "running" && percent(job.progress),
        job.eta_s !== null && `${duration(job.eta_s)} left`,
      ),
    );
    if (job.id === chosen) item.firstElementChild!.setAttribute("aria-current", "page");
    else item.firstElementChild!.removeAttribute("aria-current");
  };

  /** So many jobs, newest first, and whether there are more. */
  const newest = async (signal: AbortSignal, wanted: Record<string, string> = {}): Promise<[Job[], boolean]> => {
    const found: Job[] = [];
    let next: string | null = null;
    do {
      const size = Math.min(limit - found.length, 200);
      const query = new URLSearchParams({ ...wanted, limit: String(size), ...(next && { cursor: next }) });
      const page: Page<Job> = await read(`/v1/jobs?${query}`, signal);
      found.push(...page.items);
      next = page.next ?? null;
    } while (next !== null && found.length < limit);
    return [found, next !== null];
  };
  const watching = watch(
    EVERY_MS,
    async (signal) => {
      const q = search.value.trim();
      const wanted = { ...(q && { q }), ...(state.value && { state: state.value }) };
      const isFiltered = Object.keys(wanted).length > 0;
      const [[all, more], [some, someMore]] = await Promise.all([newest(signal), isFiltered ? newest(signal, wanted) : [[], false] as [Job[], boolean]]);
      jobs = all;
      // Older jobs than those that are shown are found by the server.
      fitting = some;
      show(older, isFiltered ? someMore : more);
      calm();
      const running = jobs.filter((job) => job.state === "running");
      const rate = running.reduce((sum, job) => sum + (job.robot_steps_per_s ?? 0), 0);
      tell(
        running.length === 0
          ? "nothing runs"
          : sentence(
              `${running.length} ${running.length === 1 ? "job runs" : "jobs run"}`,
              rate > 0 && `${compact(rate)} robot-steps/s`,
            ),
      );
      draw();
      dispatchEvent(new CustomEvent("jobs", { detail: jobs }));
    },
    trouble,
  );
  older.addEventListener("click", () => {
    limit += A_PAGE;
    watching.now();
  });
  let soon = 0;
  const again = (): void => {
    draw();
    clearTimeout(soon);
    soon = window.setTimeout(() => watching.now(), 250);
  };
  search.addEventListener("input", again);
  state.addEventListener("change", again);
  element.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const cards = [...items.querySelectorAll<HTMLElement>("a.card")];
    const at = cards.indexOf(document.activeElement as HTMLElement);
    if (step === undefined || at < 0) return;
    event.preventDefault();
    cards[at + step]?.focus();
  });
  return {
    element,
    choose: (id) => {
      chosen = id;
      draw();
    },
    search: () => search.focus(),
  };
}
