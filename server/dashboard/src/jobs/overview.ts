// Is everything well? What runs, what waits, what failed; and for a first visit, what a job is.

import { h, keyed, show, write } from "../dom";
import { link } from "../route";
import { post, read } from "../server";
import type { Job, Template } from "../types";
import { trouble, type Screen } from "../alert";
import { jobsNow, title } from "./list";
import { serverPanel } from "./health";
import { troubled } from "./troubled";
import { pace, percent, sentence, whole } from "../words";

/** Jobs that are done, and that failed, which are shown. */
const LATELY = 10;

export function overview(): Screen {
  const counts = h("p", { class: "facts" });
  const running = h("ol", { class: "plain" });
  const wrong = h("ol", { class: "plain" });
  const wrongTitle = h("h3", { hidden: true }, "Jobs with failed runs");
  const runningTitle = h("h3", { hidden: true }, "Under way");
  const done = h("ol", { class: "plain" });
  const doneTitle = h("h3", { hidden: true }, "Done lately");
  const odd = troubled();
  const health = serverPanel();
  const start = h("button", { type: "button", class: "primary changes" }, "Start a first job");
  const welcome = h(
    "section",
    { class: "panel", hidden: true, "aria-labelledby": "welcome-title" },
    h("h2", { id: "welcome-title" }, "No jobs yet"),
    h(
      "p",
      {},
      "A job is a sweep: a base run, values to try, and seeds. Each combination is a run of robots " +
        "that learn in an arena; here you watch how much of it they cover and which method is better.",
    ),
    h("p", {}, start, " ", h("a", { class: "button", href: link("new") }, "Write one")),
  );
  const well = h(
    "section",
    { class: "panel", hidden: true, "aria-labelledby": "overview-title" },
    h("h2", { id: "overview-title" }, "Overview"),
    counts, odd.element, runningTitle, running, wrongTitle, wrong, doneTitle, done,
  );

  start.addEventListener("click", () => void first(start));
  const row = (job: Job): HTMLLIElement =>
    h("li", { class: "row" }, h("a", { href: link("job", job.id) }), h("span", { class: "facts" }));
  const fill = (item: HTMLLIElement, job: Job): void => {
    const [name, facts] = item.children as unknown as [HTMLElement, HTMLElement];
    write(name, title(job));
    write(
      facts,
      sentence(
        percent(job.progress),
        `${whole(job.runs.done)} of ${whole(job.runs.total)} runs`,
        job.runs.failed > 0 && `${whole(job.runs.failed)} failed`,
        pace(job),
      ),
    );
  };
  const update = (jobs: Job[]): void => {
    show(welcome, jobs.length === 0);
    show(well, jobs.length > 0);
    const at = (state: string): Job[] => jobs.filter((job) => job.state === state);
    const active = at("running");
    const failed = jobs.filter((job) => job.runs.failed > 0);
    const waiting = jobs.reduce((sum, job) => sum + job.runs.queued, 0);
    write(
      counts,
      sentence(
        `${whole(jobs.length)} ${jobs.length === 1 ? "job" : "jobs"} shown`,
        `${whole(active.length)} under way`,
        `${whole(waiting)} runs wait`,
        `${whole(at("done").length)} done`,
      ),
    );
    keyed(running, active, (job) => job.id, row, fill);
    keyed(wrong, failed.slice(0, LATELY), (job) => job.id, row, fill);
    const ended = at("done").slice(0, LATELY);
    keyed(done, ended, (job) => job.id, row, fill);
    show(doneTitle, ended.length > 0);
    show(runningTitle, active.length > 0);
    show(wrongTitle, failed.length > 0);
  };
  const changed = (event: Event): void => update((event as CustomEvent<Job[]>).detail);
  addEventListener("jobs", changed);
  const now = jobsNow();
  if (now) update(now);
  return {
    element: h("div", { class: "screen" }, welcome, well, health.element),
    title: "Overview",
    stop: () => {
      removeEventListener("jobs", changed);
      health.stop();
      odd.stop();
    },
  };
}

/** Posts the template `first-job`, and goes there. */
async function first(button: HTMLButtonElement): Promise<void> {
  button.disabled = true;
  try {
    const { items } = await read<{ items: Template[] }>("/v1/templates");
    const template = items.find((item) => item.name === "first-job") ?? items[0];
    if (!template) return;
    const job = await post<Job>("/v1/jobs", JSON.stringify({ template: template.name }));
    location.hash = link("job", job.id);
  } catch (error) {
    trouble(error);
  } finally {
    button.disabled = false;
  }
}
