// The list of jobs at the side: search, states, progress; newest first. It follows the page's events,
// and asks again and again while there are none.

import { h, keyed, measure, show, write } from "../dom";
import { hear, isHeard } from "../feed";
import { link } from "../route";
import { read, watch } from "../server";
import type { Job, Page } from "../types";
import { calm, trouble } from "../alert";
import { compact, duration, percent, sentence, whole } from "../words";

/** Time between two looks while nothing is heard, and while something is. */
const EVERY_MS = 4_000;
const RARELY_MS = 600_000;
const A_PAGE = 50;
/** Jobs that are held; beyond that the oldest are forgotten. */
const MOST_HELD = 5_000;

let shown: Job[] | null = null;
/** The jobs that the list has; null before the first answer. Whoever hears `jobs` of the window has them anew. */
export const jobsNow = (): Job[] | null => shown;

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
  let known = new Map<string, Job>();
  /** Whether the server has more of them, older ones. */
  let hasMore = false;
  /** What is heard while the server is asked: it may be newer than the answer. */
  let meanwhile: Map<string, Job | null> | null = null;
  let isDue = false;
  let isRead = false;

  const newestFirst = (): Job[] => [...known.values()].sort((a, b) => Number(b.id) - Number(a.id));
  const draw = (): void => {
    isDue = false;
    if (!isRead) return;
    const wanted = search.value.trim().toLowerCase();
    const jobs = newestFirst();
    for (const old of jobs.splice(MOST_HELD)) known.delete(old.id);
    const fits = jobs.filter(
      (job) =>
        (!state.value || job.state === state.value) &&
        (!wanted || wanted.split(/\s+/).every((word) => `${title(job)} ${job.id}`.toLowerCase().includes(word))),
    );
    keyed(items, fits.slice(0, limit), (job) => job.id, card, update);
    show(none, jobs.length > 0 && fits.length === 0);
    show(older, hasMore || fits.length > limit);
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
    shown = jobs;
    dispatchEvent(new CustomEvent("jobs", { detail: jobs }));
  };
  /** Many events come at once, for which one picture is enough. */
  const drawSoon = (): void => {
    if (isDue) return;
    isDue = true;
    queueMicrotask(draw);
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

  const set = (id: string, job: Job | null): void => {
    if (job) known.set(id, job);
    else known.delete(id);
    meanwhile?.set(id, job);
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
      meanwhile = new Map();
      try {
        const [[all, more], [some, someMore]] = await Promise.all([newest(signal), isFiltered ? newest(signal, wanted) : [[], false] as [Job[], boolean]]);
        // Those that should be among all and are not are gone; older ones may still be there.
        const oldest = more ? Number(all.at(-1)?.id ?? 0) : 0;
        known = new Map([...known].filter(([id]) => Number(id) < oldest));
        for (const job of [...all, ...some]) known.set(job.id, job);
        hasMore = isFiltered ? someMore : more;
        for (const [id, job] of meanwhile) set(id, job);
      } finally {
        meanwhile = null;
      }
      calm();
      isRead = true;
      draw();
    },
    trouble,
    () => (isHeard() ? RARELY_MS : EVERY_MS),
  );
  let heardBefore = false;
  hear((event) => {
    if (event.name === "job") {
      set(event.data.id, event.data);
      drawSoon();
    } else if (event.name === "gone") {
      set(event.data.job_id, null);
      drawSoon();
    } else if (event.name === "lost") {
      watching.now();
    } else if (event.name === "begin") {
      // What went while nothing was heard.
      if (heardBefore) watching.now();
      heardBefore = true;
    }
  });
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
