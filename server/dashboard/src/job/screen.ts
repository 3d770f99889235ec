// A job: which group is better and how sure that is, then curves, differences, strips, runs. All
// figures are pooled by the server over every run of the job, never over a page of them.

import { h, show, write } from "../dom";
import { choose, link } from "../route";
import { post, read, remove, watch } from "../server";
import type { Job, Summary } from "../types";
import { calm, trouble, type Screen } from "../main";
import { title } from "../jobs/list";
import { pace, percent, sentence, whole } from "../words";
import { curvesChart } from "./curves";
import { forestPlot } from "./forest";
import { stripPlots } from "./strips";
import { runsTable } from "./runs";
import type { Comparison, Curves } from "./pooled";

const EVERY_MS = 2_000;
/** Ten methods on each of three arenas. */
const CHAPTER_5_GROUPS = 30;
/** The measures that a reader may choose, and what they are called. */
const MEASURES: [string, string][] = [
  ["p1", "squares entered once"],
  ["p2", "… twice"],
  ["p5", "… five times"],
  ["p10", "… ten times"],
];

export function jobScreen(id: string, options: URLSearchParams): Screen {
  let measure = options.get("measure") ?? "p1";
  let scale = options.get("scale") ?? "linear";
  const heading = h("h2", {}, `Job ${id}`);
  const badge = h("span", { class: "badge" });
  const bar = h("progress", { max: 1, "aria-label": "Share of the work done" });
  const facts = h("p", { class: "facts" });
  const verdict = h("p", { class: "verdict", role: "status" });
  const copy = h("button", { type: "button", hidden: true }, "Copy as sentence");
  copy.addEventListener("click", () => void navigator.clipboard.writeText(verdict.textContent ?? ""));

  const act = (name: string, what: string, sure?: string): HTMLButtonElement => {
    const button = h("button", { type: "button", hidden: true }, name);
    button.addEventListener("click", () => {
      if (sure && !confirm(sure)) return;
      const path = `/v1/jobs/${id}`;
      const done = what === "delete" ? remove(path) : post(`${path}/${what}`);
      done.then(
        () => {
          if (what === "delete") location.hash = link("overview");
          else watching.now();
        },
        trouble,
      );
    });
    return button;
  };
  const pause = act("Pause", "pause");
  const resume = act("Resume", "resume");
  const cancel = act("Cancel", "cancel", "Cancel this job? Runs that are not done stop for good; results stay.");
  const retry = act("Try again", "retry");
  const erase = act("Delete", "delete", "Delete this job and the results that only it has? This cannot be undone.");
  const clone = h("a", { class: "button", href: link("new", "", { from: id }) }, "Clone");

  const select = h("select", { id: "measure" }, ...MEASURES.map(([name, text]) =>
    h("option", { value: name, selected: name === measure }, `${name}: ${text}`)));
  const log = h("select", { id: "scale" }, ...["linear", "log"].map((name) =>
    h("option", { value: name, selected: name === scale }, name)));
  const tools = h(
    "div",
    { class: "tools" },
    h("label", { for: "measure" }, "Measure"), select,
    h("label", { for: "scale" }, "Scale"), log,
  );
  const curves = curvesChart();
  const forest = forestPlot();
  const strips = stripPlots();
  const table = runsTable();
  const downloads = h("p", { class: "facts" });
  const charts = h("div", { hidden: true }, tools, curves.element, forest.element, strips.element);
  const waiting = h("p", { class: "quiet" }, "Charts come when the first runs are done.");
  const element = h(
    "article",
    { class: "screen panel" },
    h("div", { class: "head" }, heading, badge,
      h("span", { class: "actions" }, pause, resume, cancel, retry, clone, erase)),
    bar, facts,
    h("div", { class: "said" }, verdict, copy),
    waiting, charts,
    h("h3", {}, "Runs"), table.element, downloads,
  );

  let pooled_at = "";
  const look = async (signal: AbortSignal): Promise<void> => {
    const job = await read<Job>(`/v1/jobs/${id}`, signal);
    calm();
    write(heading, title(job));
    document.title = `${title(job)} – evswarm`;
    write(badge, job.state);
    badge.dataset["state"] = job.state;
    if (bar.value !== job.progress) bar.value = job.progress;
    const ended = ["done", "failed", "cancelled"].includes(job.state);
    show(pause, ["queued", "running"].includes(job.state));
    show(resume, job.state === "paused");
    show(cancel, !ended);
    show(retry, ended && job.runs.failed + job.runs.cancelled > 0);
    show(erase, ended);
    write(
      facts,
      sentence(
        percent(job.progress),
        `${whole(job.runs.done)} of ${whole(job.runs.total)} runs done`,
        job.runs.failed > 0 && `${whole(job.runs.failed)} failed`,
        pace(job),
        `accepted ${new Date(job.created_at).toLocaleString()}`,
      ),
    );
    await table.refresh(id, signal);
    // What is pooled changes with the runs that are done, and with what was chosen.
    const now = `${job.runs.done} ${measure}`;
    if (now === pooled_at) return;
    show(waiting, job.runs.done === 0);
    show(charts, job.runs.done > 0);
    if (job.runs.done === 0) return;
    const [summary, comparison, lines] = await Promise.all([
      read<Summary>(`/v1/jobs/${id}/summary`, signal),
      read<Comparison>(`/v1/jobs/${id}/comparison?measure=${measure}`, signal),
      read<Curves>(`/v1/jobs/${id}/curves?measure=${measure}&points=200`, signal),
    ]);
    const labels = summary.groups.map((group) => group.label);
    // Only the experiments of chapter 5 have as many groups and a report.
    show(report, summary.groups.length >= CHAPTER_5_GROUPS);
    write(verdict, comparison.verdict);
    show(copy, comparison.verdict !== "");
    curves.draw(lines, labels, { log: scale === "log", measure });
    forest.draw(comparison);
    await strips.draw(id, summary, signal);
    pooled_at = now;
  };
  const watching = watch(EVERY_MS, look, trouble);
  select.addEventListener("change", () => {
    measure = select.value;
    choose("measure", measure);
    watching.now();
  });
  log.addEventListener("change", () => {
    scale = log.value;
    choose("scale", scale);
    pooled_at = "";
    watching.now();
  });
  const report = h("a", { href: `/v1/jobs/${id}/report.html`, hidden: true }, "report on chapter 5");
  downloads.append(
    h("a", { href: `/v1/jobs/${id}/summary.csv` }, "summary as CSV"), " ",
    h("a", { href: `/v1/jobs/${id}/summary.md` }, "summary as Markdown"), " ",
    h("a", { href: `/v1/jobs/${id}/comparison.csv?measure=p1` }, "comparison as CSV"), " ",
    report,
  );
  return { element, title: `Job ${id}`, stop: () => { watching.stop(); curves.stop(); } };
}
