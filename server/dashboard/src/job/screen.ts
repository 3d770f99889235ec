// A job: which group is better and how sure that is, then curves, differences, strips, maps, runs.
// All that is pooled is pooled by the server over every run of the job, never over a page of them.

import { trouble, type Screen } from "../alert";
import { h, measure as fill, show, write } from "../dom";
import { choose, link } from "../route";
import { post, Problem, read, remove, watch } from "../server";
import { hear, isHeard } from "../feed";
import { onTheme } from "../looks";
import type { Comparison, Curves, Job, Run, Summary } from "../types";
import { title } from "../jobs/list";
import { pace, percent, sentence, whole } from "../words";
import { AllRuns, MOST } from "./all_runs";
import { curvesChart } from "./curves";
import { forestPlot } from "./forest";
import { grouping, standsOut, varied } from "./groups";
import { coverageMaps } from "./maps";
import { parallelPlot } from "./parallel";
import { runsTable } from "./runs";
import { scalingPlots } from "./scaling";
import { stripPlots } from "./strips";
import { sweepMap } from "./sweep";

/** Least time between two looks at what is pooled, and at runs on their way. */
const EVERY_MS = 2_000;
/** The same for jobs of many runs. */
const MANY_RUNS = 300;
const EVERY_OF_MANY_MS = 10_000;
/** Groups that the server compares. */
const MOST_COMPARED = 32;
/** Methods that the report on chapter 5 compares. */
const CHAPTER_5_METHODS = 10;
const ENDED = ["done", "failed", "cancelled"];
const ABOUT: Record<string, string> = {
  p1: "squares entered once", p2: "… twice", p5: "… five times", p10: "… ten times",
  p1_fraction: "share of what can be reached", p2_fraction: "… twice", p5_fraction: "… five times", p10_fraction: "… ten times",
};
const FIRST = ["p1", "p2", "p5", "p10", "p1_fraction", "p2_fraction", "p5_fraction", "p10_fraction"];

export function jobScreen(id: string, options: URLSearchParams): Screen {
  let measure = options.get("measure") ?? "p1";
  let by: string | null = options.get("by");
  const hidden = new Set((options.get("hide") ?? "").split("|").filter(Boolean));
  const [from, to] = (options.get("zoom") ?? "").split("-").map(Number);
  const zoom: [number, number] | null = from && to && from < to ? [from, to] : null;
  const heading = h("h2", {}, `Job ${id}`);
  const badge = h("span", { class: "badge" });
  const bar = h("progress", { max: 1, "aria-label": "Share of the work done" });
  const facts = h("p", { class: "facts" });
  const verdict = h("p", { class: "verdict", role: "status" });
  const copy = h("button", { type: "button", hidden: true }, "Copy as sentence");
  copy.addEventListener("click", () => {
    navigator.clipboard.writeText(verdict.textContent ?? "").then(
      () => {
        write(copy, "Copied");
        setTimeout(() => write(copy, "Copy as sentence"), 1_500);
      },
      () => getSelection()?.selectAllChildren(verdict),
    );
  });

  const act = (name: string, what: string, sure?: string): HTMLButtonElement => {
    const button = h("button", { type: "button", class: "changes", hidden: true }, name);
    button.addEventListener("click", () => {
      if (sure && !confirm(sure)) return;
      const path = `/v1/jobs/${id}`;
      if (what === "delete") remove(path).then(() => { location.hash = link("overview"); }, trouble);
      else post<Job>(`${path}/${what}`).then(showJob, trouble);
    });
    return button;
  };
  const pause = act("Pause", "pause");
  const resume = act("Resume", "resume");
  const cancel = act("Cancel", "cancel", "Cancel this job? Runs that are not done stop for good; results stay.");
  const retry = act("Try again", "retry");
  const erase = act("Delete", "delete", "Delete this job and the results that only it has? This cannot be undone.");
  const clone = h("a", { class: "button", href: link("new", "", { from: id }) }, "Clone");
  const extend = h("button", { type: "button", class: "changes" }, "More seeds");
  extend.addEventListener("click", () => {
    const seeds = Number(prompt("How many more seeds for each group? Their runs wait in the queue at once.", "5"));
    if (Number.isInteger(seeds) && seeds > 0) post<Job>(`/v1/jobs/${id}/extend`, JSON.stringify({ seeds })).then(showJob, trouble);
  });

  const select = h("select", { id: "measure" });
  const groups = h("select", { id: "by" }, h("option", { value: "" }, "each combination"));
  const log = h("select", { id: "scale" }, ...["linear", "log"].map((name) => h("option", { value: name }, name)));
  log.value = options.get("scale") === "log" ? "log" : "linear";
  const single = h("input", { type: "checkbox", checked: options.get("runs") === "1" });
  const fillMeasures = (names: string[]): void => {
    const all = [...FIRST, ...names.filter((name) => !FIRST.includes(name))];
    if (select.options.length === all.length) return;
    select.replaceChildren(...all.map((name) => h("option", { value: name }, ABOUT[name] ? `${name}: ${ABOUT[name]}` : name)));
    select.value = measure;
  };
  fillMeasures([]);
  const tools = h(
    "div",
    { class: "tools" },
    h("label", { for: "measure" }, "Measure"), select,
    h("label", { for: "by" }, "Groups"), groups,
    h("label", { for: "scale" }, "Scale"), log,
    h("label", {}, single, " single runs"),
  );
  const curves = curvesChart(hidden, zoom);
  const forest = forestPlot();
  const strips = stripPlots();
  const scaling = scalingPlots();
  const sweep = sweepMap(options);
  const parallel = parallelPlot();
  const maps = coverageMaps(id, options.get("maps") === "1");
  const table = runsTable(options);
  const report = h("a", { href: `/v1/jobs/${id}/report.html`, hidden: true }, "report on chapter 5");
  const downloads = h("p", { class: "files" },
    ...["summary.csv", "summary.md", "comparison.csv", "comparison.md", "runs.csv", "runs.parquet", "curves.parquet", "metrics.parquet"].map((name) =>
      h("a", { href: `/v1/jobs/${id}/${name}` }, name)),
    report);
  const cut = h("p", { class: "quiet", hidden: true }, `The table and the strips have the first ${whole(MOST)} runs; what is pooled has all.`);
  const charts = h("div", { class: "screen", hidden: true }, tools, curves.element, forest.element, strips.element, scaling.element, sweep.element, parallel.element, maps.element);
  const waiting = h("p", { class: "quiet" }, "Charts come when the first runs are done.");
  const element = h(
    "article",
    { class: "screen panel" },
    h("div", { class: "head" }, heading, badge,
      h("span", { class: "actions" }, pause, resume, cancel, retry, extend, clone, erase)),
    bar, facts,
    h("div", { class: "said" }, verdict, copy),
    waiting, charts,
    h("h3", {}, "Runs"), table.element, cut,
    h("h3", {}, "Files"), downloads,
  );

  let job: Job | null = null;
  let pooled = "";
  let changed = true;
  let isSure = false;
  const all = new AllRuns();
  let summary: Summary | null = null;

  function showJob(next: Job): void {
    job = next;
    changed = true;
    write(heading, title(next));
    document.title = `${title(next)} – evswarm`;
    write(badge, next.state);
    badge.dataset["state"] = next.state;
    fill(bar, next.progress);
    const ended = ENDED.includes(next.state);
    show(pause, ["queued", "running"].includes(next.state));
    show(resume, next.state === "paused");
    show(cancel, !ended);
    show(retry, ended && next.runs.failed + next.runs.cancelled > 0);
    show(erase, ended);
    write(
      facts,
      sentence(
        percent(next.progress),
        `${whole(next.runs.done)} of ${whole(next.runs.total)} runs done`,
        next.runs.failed > 0 && `${whole(next.runs.failed)} failed`,
        pace(next),
        `accepted ${new Date(next.created_at).toLocaleString()}`,
      ),
    );
  }
  const showRuns = (): void => {
    const runs: Run[] = all.runs;
    table.draw(runs, standsOut(runs, summary));
    show(cut, (job?.runs.total ?? 0) > MOST);
  };
  let key = "";
  const look = async (signal: AbortSignal): Promise<void> => {
    // While nothing is heard of it, it is asked for.
    if (!job || !isSure) {
      const now = await read<Job>(`/v1/jobs/${id}`, signal);
      if (JSON.stringify(now) !== JSON.stringify(job)) showJob(now);
      isSure = isHeard();
    }
    const { done, total } = job!.runs;
    const ended = ENDED.includes(job!.state);
    // What is pooled changes with the runs that are done, and with what was chosen.
    const now = `${done} ${total} ${measure} ${by} ${single.checked} ${ended}`;
    const isPooled = now === pooled;
    if (!changed && isPooled) return;
    changed = false;
    await all.refresh(job!, signal);
    if (isPooled || done === 0) {
      showRuns();
      show(waiting, done === 0);
      show(charts, done > 0);
      return;
    }
    show(waiting, false);
    show(charts, true);
    const curved = FIRST.includes(measure) ? measure : "p1";
    const query = (more: Record<string, string>): string => new URLSearchParams({ ...more, ...(by && { by }) }).toString();
    summary = await read<Summary>(`/v1/jobs/${id}/summary`, signal);
    fillMeasures(summary.groups[0]?.measures.map((one) => one.name) ?? []);
    fillGroups(varied(summary));
    const isMany = by === null && summary.groups.length > MOST_COMPARED;
    const [comparison, lines] = await Promise.all([
      isMany ? null : read<Comparison>(`/v1/jobs/${id}/comparison?${query({ measure })}`, signal),
      read<Curves>(`/v1/jobs/${id}/curves?${query({ measure: curved, points: "200", ...(single.checked && { runs: "true" }) })}`, signal),
    ]);
    const labels = lines.groups.map((group) => group.label);
    // Only the experiments of chapter 5 have as many methods and a report.
    const methods = new Set(summary.groups.map((group) => group.values["controller.method"]));
    show(report, methods.size >= CHAPTER_5_METHODS && ended);
    write(verdict, comparison?.verdict ? `${by ? `By ${by}: ` : ""}${comparison.verdict}` : comparison ? "" : `${whole(summary.groups.length)} groups are more than can be compared in pairs: choose a field under "Groups".`);
    show(copy, (comparison?.verdict ?? "") !== "");
    curves.draw(lines, { log: log.value === "log", single: single.checked });
    forest.draw(comparison);
    strips.draw(all.runs, labels, grouping(summary, by), summary);
    scaling.draw(summary.scaling ?? []);
    sweep.draw(summary, measure);
    parallel.draw(summary, measure);
    showRuns();
    key = `${done} ${total}`;
    pooled = now;
    await maps.draw(by, labels.length, key);
  };
  const fillGroups = (fields: string[]): void => {
    if (groups.options.length === fields.length + 1) return;
    groups.append(...fields.map((field) => h("option", { value: field }, `by ${field}`)));
    groups.value = by ?? "";
  };
  const watching = watch(EVERY_MS, look, trouble, () => ((job?.runs.total ?? 0) > MANY_RUNS && job?.state === "running" ? EVERY_OF_MANY_MS : EVERY_MS));
  const hearing = hear((event) => {
    if (event.name === "job" && event.data.id === id) {
      showJob(event.data);
      if (ENDED.includes(event.data.state)) watching.now();
    } else if (event.name === "gone" && event.data.job_id === id) {
      watching.stop();
      trouble(new Problem(404, "job-not-found", "This job was deleted.", []));
    } else if (event.name === "begin" || event.name === "lost") {
      isSure = false;
      watching.now();
    }
  });
  const again = (): void => {
    changed = true;
    watching.now();
  };
  select.addEventListener("change", () => {
    measure = select.value;
    choose("measure", measure === "p1" ? null : measure);
    again();
  });
  groups.addEventListener("change", () => {
    by = groups.value || null;
    hidden.clear();
    choose("hide", null);
    choose("by", by);
    again();
  });
  log.addEventListener("change", () => {
    choose("scale", log.value === "linear" ? null : log.value);
    pooled = "";
    again();
  });
  const themed = onTheme(() => {
    pooled = "";
    again();
  });
  single.addEventListener("change", () => {
    choose("runs", single.checked ? "1" : null);
    again();
  });
  return {
    element,
    title: `Job ${id}`,
    stop: () => {
      for (const stopping of [watching, curves, maps]) stopping.stop();
      hearing();
      themed();
    },
  };
}
