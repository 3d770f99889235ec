// Why a run did what it did, in a sentence; asked for, as the server steps the run again for it.

import { trouble } from "../alert";
import { h, measure, show, write } from "../dom";
import { choose } from "../route";
import { ask, read } from "../server";
import type { Explanation, ExplanationPending, Stayed } from "../types";
import { compact, figure, percent, sentence, whole } from "../words";

/** Stretches that are listed. */
const LISTED = 8;
const AGAIN_MS = 1_000;

export interface Explainer {
  /** The button that asks. */
  button: HTMLElement;
  element: HTMLElement;
  stop(): void;
}

/** `found` gets the stretches when they are known, `go` the moment that a person wants to see. */
export function explainer(run: string, options: URLSearchParams, found: (stayed: Stayed[]) => void, go: (stayed: Stayed) => void): Explainer {
  const button = h("button", { type: "button" }, "Explain");
  const said = h("p", { class: "verdict", role: "status" });
  const copy = h("button", { type: "button", hidden: true }, "Copy as sentence");
  const bar = h("progress", { max: 1, "aria-label": "Share of the run that was stepped again", hidden: true });
  const facts = h("p", { class: "facts" });
  const list = h("ul", { class: "plain stayed" });
  const more = h("details", { hidden: true }, h("summary", {}, "When and where, by which scores"), list);
  const element = h("section", { class: "explained", "aria-label": "What it did", hidden: true }, h("div", { class: "said" }, said, copy), bar, facts, more);
  const stopping = new AbortController();
  let asking = false;

  copy.addEventListener("click", () => {
    navigator.clipboard.writeText(said.textContent ?? "").then(() => write(copy, "Copied"), () => getSelection()?.selectAllChildren(said));
  });
  const tell = (explanation: Explanation): void => {
    show(bar, false);
    show(copy, true);
    write(said, explanation.sentence);
    write(facts, sentence(
      ...explanation.behaviours.map((one) => `${one.name} ${percent(one.share)}`),
      `${whole(explanation.robots_watched)} of ${whole(explanation.robots)} ${explanation.robots === 1 ? "robot" : "robots"} watched over ${whole(explanation.epochs)} counted epochs`,
    ));
    const stayed = [...explanation.standing, ...explanation.confined].sort((a, b) => b.steps - a.steps);
    show(more, stayed.length > 0);
    list.replaceChildren(...stayed.slice(0, LISTED).map((one) => item(one, go)));
    found(stayed);
  };
  const look = async (): Promise<void> => {
    if (asking) return;
    asking = true;
    choose("explain", "1");
    show(element, true);
    show(button, false);
    write(said, "");
    write(facts, "The run is stepped again before a watcher …");
    try {
      for (;;) {
        const response = await ask(`/v1/runs/${run}/explain`, { signal: stopping.signal });
        if (response.status !== 202) {
          tell((await response.json()) as Explanation);
          return;
        }
        const { progress, robot_steps } = (await response.json()) as ExplanationPending;
        show(bar, true);
        measure(bar, progress);
        write(facts, `The run is stepped again before a watcher: ${percent(progress)} of ${compact(robot_steps)} robot-steps.`);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    } catch (error) {
      if (stopping.signal.aborted) return;
      show(element, false);
      show(button, true);
      trouble(error);
    } finally {
      asking = false;
    }
  };
  button.addEventListener("click", () => void look());
  button.title = "Steps the run again, once, and says what robots did most of what is odd";
  if (options.get("explain")) void look();
  return { button, element, stop: () => stopping.abort() };
}

function item(one: Stayed, go: (stayed: Stayed) => void): HTMLElement {
  const button = h("button", { type: "button" }, "Show");
  button.setAttribute("aria-label", `Show robot ${one.robot} at epoch ${one.epoch}, step ${one.epoch_step}`);
  button.addEventListener("click", () => go(one));
  const numbers = (what: string, tried: { number: number; steps: number }[]): string | false =>
    tried.length > 0 && `${what} ${tried.slice(0, 3).map((each) => each.number).join(", ")}`;
  const scores = [...one.scores].sort((a, b) => b.score - a.score).slice(0, 3);
  return h("li", { class: "row" }, button, h("span", {}, sentence(
    `robot ${one.robot} ${one.behaviour} for ${whole(one.steps)} steps`,
    `epoch ${one.epoch}, step ${one.epoch_step}`,
    `at ${one.x_m.toFixed(2)}, ${one.y_m.toFixed(2)} m`,
    numbers(one.states.length === 1 ? "state" : "states", one.states),
    numbers(one.actions.length === 1 ? "action" : "actions", one.actions),
    scores.length > 0 && `best scores in state ${one.scored_state}: ${scores.map((each) => `action ${each.action} ${figure(each.score)} (${whole(each.tries)} tries)`).join(", ")}`,
  )));
}

/** Which squares of a run can be reached; null where that is not known. */
export const reachOf = (run: string): Promise<readonly string[] | null> =>
  read<{ reachable_rows: string[] }>(`/v1/runs/${run}/reach`).then((reach) => reach.reachable_rows, () => null);
