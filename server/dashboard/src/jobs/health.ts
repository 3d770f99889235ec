// The server itself: threads and what each is at, the queue, memory and disk, whether it is ready.

import { trouble } from "../alert";
import { h, keyed, measure, show, write } from "../dom";
import { link } from "../route";
import { ask, Problem, read, watch } from "../server";
import type { Version, Workers } from "../types";
import { bytes, duration, pace, percent, sentence, whole } from "../words";
import { only, parseMetrics, type Metrics } from "./metrics";

const EVERY_MS = 4_000;
/** Room below which the disk is said to get full, beside what the server refuses at. */
const LITTLE_ROOM_BYTES = 2 * 1024 ** 3;

export function serverPanel(): { element: HTMLElement; stop(): void } {
  const state = h("p", { class: "facts", role: "status" });
  const list = h("dl", { class: "figures halved" });
  const threads = h("ol", { class: "plain", "aria-label": "Threads and their runs" });
  const idle = h("p", { class: "quiet", hidden: true }, "No thread has a run.");
  const element = h("section", { class: "panel", "aria-labelledby": "server-title" },
    h("h2", { id: "server-title" }, "Server"), state, list, h("h3", {}, "Threads"), threads, idle);
  let version: Version | null = null;

  const rows = (metrics: Metrics, workers: Workers): [string, string][] => {
    const parts = (metrics.get("evswarm_store_bytes") ?? []).filter(([, size]) => size > 0);
    const [room, memory] = [only(metrics, "store_room_bytes"), only(metrics, "memory_resident_bytes")];
    const runs = (metrics.get("evswarm_runs") ?? []).filter(([, count]) => count > 0);
    const rate = workers.items.reduce((sum, one) => sum + (one.progress?.robot_steps_per_s ?? 0), 0);
    return [
      ["threads", `${whole(workers.items.length)} of ${whole(workers.threads)} step a run`],
      ["queue", `${whole(workers.queued)} ${workers.queued === 1 ? "run waits" : "runs wait"}`],
      ["rate", rate > 0 ? pace({ robot_steps_per_s: rate }) : "nothing is stepped"],
      ["memory", memory ? bytes(memory) : "not told"],
      ["disk used", parts.length ? sentence(bytes(parts.reduce((sum, [, size]) => sum + size, 0)), ...parts.map(([part, size]) => `${part} ${bytes(size)}`)) : "nothing yet"],
      ["disk left", room === null ? "not told" : `${bytes(room)}${room < LITTLE_ROOM_BYTES ? ": little" : ""}`],
      ["runs", runs.length ? sentence(...runs.map(([name, count]) => `${whole(count)} ${name}`)) : "none"],
      ["version", version ? `${version.version}, results ${version.results_version}` : ""],
    ];
  };
  const ready = (): Promise<string> => ask("/health/readyz").then(() => "", (error: unknown) => {
    if (error instanceof Problem) return error.message;
    throw error;
  });
  const watching = watch(EVERY_MS, async (signal) => {
    version ??= await read<Version>("/v1/version", signal);
    const [workers, text, wrong] = await Promise.all([
      read<Workers>("/v1/workers", signal), ask("/metrics", { signal }).then((answer) => answer.text()), ready(),
    ]);
    write(state, wrong ? `It cannot do its work: ${wrong}` : "It is ready.");
    state.classList.toggle("bad", wrong !== "");
    keyed(list, rows(parseMetrics(text), workers), ([name]) => name,
      ([name]) => h("div", {}, h("dt", {}, name), h("dd", {})),
      (row, [, value]) => write(row.querySelector("dd")!, value));
    keyed(threads, workers.items, (one) => one.run ?? "",
      () => h("li", { class: "row" }, h("a", {}), h("progress", { max: 1, "aria-hidden": true }), h("span", { class: "facts" })),
      (item, one) => {
        const [name, bar, facts] = item.children as unknown as [HTMLAnchorElement, HTMLProgressElement, HTMLElement];
        name.href = one.run ? link("run", one.run) : "#/";
        write(name, one.run ? `${one.run.slice(0, 8)} of job ${one.job_id}` : "a run that is gone");
        measure(bar, one.progress?.fraction ?? 0);
        write(facts, sentence(one.progress ? one.progress.phase : "is set up", one.progress && percent(one.progress.fraction), one.progress && pace(one.progress), `here for ${duration(one.seconds)}`));
      });
    show(idle, workers.items.length === 0);
  }, trouble);
  return { element, stop: () => watching.stop() };
}
