// Runs that need a look: those that failed, and those that paused by themselves, with why; what
// failed since the last visit is marked.

import { trouble } from "../alert";
import { h, keyed, show, write } from "../dom";
import { hear, isHeard } from "../feed";
import { link } from "../route";
import { read, watch } from "../server";
import type { Page, Run } from "../types";
import { sentence } from "../words";

/** Time between two looks while nothing is heard, and while something is. */
const EVERY_MS = 10_000;
const RARELY_MS = 600_000;
/** Least time between two looks at what is heard of. */
const GATHERED_MS = 1_000;
const SHOWN = 10;
const SEEN = "seen-troubles";

export function troubled(): { element: HTMLElement; stop(): void } {
  const list = h("ol", { class: "plain" });
  const element = h("section", { hidden: true, "aria-labelledby": "troubled-title" }, h("h3", { id: "troubled-title" }, "Runs to look at"), list);
  const seen = new Set<string>((localStorage.getItem(SEEN) ?? "").split(" ").filter(Boolean));
  const watching = watch(EVERY_MS, async (signal) => {
    const [failed, paused] = await Promise.all(["failed", "paused"].map((state) =>
      read<Page<Run>>(`/v1/runs?state=${state}&limit=${SHOWN}`, signal)));
    const runs = [...failed!.items, ...paused!.items.filter((run) => run.error != null)];
    show(element, runs.length > 0);
    keyed(list, runs, (run) => run.id,
      (run) => h("li", { class: "row" }, h("a", { href: link("run", run.id) }), h("span", { class: "badge" }), h("span", { class: "facts" })),
      (item, run) => {
        const [name, badge, why] = item.children as unknown as [HTMLElement, HTMLElement, HTMLElement];
        write(name, sentence(run.label || run.method, run.arena, `seed ${run.seed}`));
        write(badge, seen.has(run.id) ? run.state : `new: ${run.state}`);
        badge.dataset["state"] = run.state;
        write(why, run.error ?? "");
      });
    localStorage.setItem(SEEN, runs.map((run) => run.id).join(" "));
  }, trouble, () => (isHeard() ? RARELY_MS : EVERY_MS));
  let due = 0;
  const listed = (run: string): boolean => [...list.children].some((item) => (item as HTMLElement).dataset["key"] === run);
  const hearing = hear((event) => {
    const isConcerned = event.name === "state"
      ? ["failed", "paused"].includes(event.data.state) || listed(event.data.run_id)
      : event.name === "gone" || event.name === "begin" || event.name === "lost";
    if (isConcerned && due === 0) {
      due = window.setTimeout(() => {
        due = 0;
        watching.now();
      }, GATHERED_MS);
    }
  });
  return {
    element,
    stop: () => {
      hearing();
      clearTimeout(due);
      watching.stop();
    },
  };
}
