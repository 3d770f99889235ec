// A run: how far it is, what it covered so far, and what it holds; while it runs and after.

import { h, keyed, show, write } from "../dom";
import { link } from "../route";
import { post, read, watch } from "../server";
import type { Arena, Coverage, Run } from "../types";
import { calm, trouble, type Screen } from "../main";
import { scene, type Walls } from "./scene";
import { bytes, figure, pace, percent, sentence, whole } from "../words";

const EVERY_MS = 1_000;
/** A file of a run, as the server's own table lists it. */
interface RunFile {
  route: string;
  needs_result: boolean;
  needs_objects: boolean;
  needs_findings: boolean;
}

interface Spec {
  arena: string | Partial<Arena>;
  robots: number;
  epochs: number;
  steps_per_epoch: number;
  engine: string;
  memory_budget_bytes: number | null;
}

export function runScreen(id: string, _options: URLSearchParams): Screen {
  const heading = h("h2", {}, `Run ${id.slice(0, 8)}`);
  const badge = h("span", { class: "badge" });
  const bar = h("progress", { max: 1, "aria-label": "Share of the work done" });
  const facts = h("p", { class: "facts" });
  const why = h("p", { class: "bad", hidden: true });
  const job = h("a", { class: "button" }, "Its job");
  const cancel = h("button", { type: "button", hidden: true }, "Cancel");
  const picture = scene();
  const drawn = h("img", { hidden: true, alt: "Coverage of the run over its arena" });
  const figures = h("dl", { class: "figures" });
  const files = h("ul", { class: "plain files", "aria-label": "Files of this run" });
  const element = h(
    "article",
    { class: "screen panel" },
    h("div", { class: "head" }, heading, badge, h("span", { class: "actions" }, cancel, job)),
    bar, facts, why,
    h("div", { class: "two" }, h("div", {}, picture.element, drawn), figures),
    files,
  );
  cancel.addEventListener("click", () => {
    if (confirm("Cancel this run, in every job that has it? It stops for good.")) {
      post(`/v1/runs/${id}/cancel`).then(() => watching.now(), trouble);
    }
  });

  let spec: Spec | null = null;
  let walls: Walls | null = null;
  let seen = "";
  const watching = watch(
    EVERY_MS,
    async (signal) => {
      const run = await read<Run>(`/v1/runs/${id}`, signal);
      calm();
      spec ??= await read<Spec>(`/v1/runs/${id}/spec`, signal);
      write(heading, sentence(run.label || run.method, run.arena, `seed ${run.seed}`));
      write(badge, run.state);
      badge.dataset["state"] = run.state;
      bar.value = run.progress?.fraction ?? (run.state === "done" ? 1 : 0);
      job.href = link("job", run.job_id);
      show(cancel, ["queued", "running", "paused"].includes(run.state));
      write(
        facts,
        sentence(
          run.progress && run.state !== "done" && `${run.progress.phase}, epoch ${whole(run.progress.epochs_done)} of ${whole(run.progress.epochs_total)}`,
          run.progress && percent(run.progress.fraction),
          run.progress && pace(run.progress),
          `${whole(spec.robots)} ${spec.robots === 1 ? "robot" : "robots"}, ${spec.engine}`,
        ),
      );
      show(why, run.error !== null);
      write(why, run.error ?? "");
      const now = `${run.state} ${run.progress?.robot_steps_done ?? 0}`;
      if (now === seen || ["failed", "cancelled"].includes(run.state)) return;
      seen = now;
      const coverage = await read<Coverage & { reachable: number; fractions: Record<string, number> }>(
        `/v1/runs/${id}/coverage`, signal,
      );
      walls ??= await wallsOf(spec, signal);
      const sides = coverage.squares as unknown as number | [number, number];
      const [columns, rows] = typeof sides === "number" ? [sides, sides] : sides;
      if (walls) {
        picture.draw(walls, { columns, rows, counts: coverage.visits });
      } else {
        show(picture.element, false);
        drawn.src = `/v1/runs/${id}/coverage.svg?at=${encodeURIComponent(now)}`;
        show(drawn, true);
      }
      list(figures, rowsOf(run, spec, coverage));
      const listed = await fileTable();
      keyed(
        files,
        listed.filter((file) => !file.needs_objects && (!file.needs_result || run.result !== null)),
        (file) => file.route,
        (file) => h("li", {}, h("a", { href: `/v1/runs/${id}/${file.route}` }, file.route)),
        () => undefined,
      );
    },
    trouble,
  );
  return { element, title: `Run ${id.slice(0, 8)}`, stop: () => { watching.stop(); picture.stop(); } };
}

async function fileTable(): Promise<RunFile[]> {
  const script = "/files.js";
  return ((await import(/* @vite-ignore */ script)) as { FILES: RunFile[] }).FILES;
}

/** The walls of a run's arena, where they are written out or the arena has a name. */
async function wallsOf(spec: Spec, signal: AbortSignal): Promise<Walls | null> {
  const arena = typeof spec.arena === "string"
    ? await read<Arena>(`/v1/arenas/${encodeURIComponent(spec.arena)}`, signal)
    : spec.arena;
  const { width_m, height_m, walls_m, starts } = arena;
  if (!width_m || !height_m || !walls_m) return null;
  return { width_m, height_m, walls_m, starts: starts ?? [] };
}

function rowsOf(
  run: Run,
  spec: Spec,
  coverage: Record<string, unknown> & { reachable: number; fractions: Record<string, number> },
): [string, string][] {
  const rows: [string, string][] = ["p1", "p2", "p5", "p10"].map((name) => [
    name,
    `${whole(Number(coverage[name]))} of ${whole(coverage.reachable)} squares, ${percent(coverage.fractions[name] ?? 0)}`,
  ]);
  if (run.result) {
    const { metrics, memory } = run.result;
    for (const [name, value] of Object.entries(metrics)) if (value !== null) rows.push([name, figure(value)]);
    rows.push([
      "memory of a learner",
      `${bytes(memory.most_bytes)} of ${spec.memory_budget_bytes === null ? `at most ${bytes(memory.plan.bytes)}` : bytes(spec.memory_budget_bytes)}`,
    ]);
  }
  return rows;
}

function list(element: HTMLElement, rows: [string, string][]): void {
  keyed(
    element,
    rows,
    ([name]) => name,
    ([name]) => h("div", {}, h("dt", {}, name), h("dd", {})),
    (row, [, value]) => write(row.querySelector("dd")!, value),
  );
}
