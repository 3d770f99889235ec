// What stands on the timeline of a recording: its phases, where epochs begin, and the stretches in
// which a robot stayed where it was.

import { h } from "../dom";
import { whole } from "../words";
import type { Stayed } from "../types";
import type { Head } from "./player";

/** Epochs up to which each has a line. */
const MOST_EPOCHS = 100;

export interface Marks {
  element: HTMLElement;
  draw(head: Head, from: number, last: number, stayed: readonly Stayed[]): void;
}

export function marks(go: (step: number, robot?: number) => void): Marks {
  const phases = h("div", { class: "phases" });
  const stretches = h("div", { class: "stretches" });
  const element = h("div", { class: "marks" }, phases, stretches);
  return {
    element,
    draw: (head, from, last, stayed) => {
      const per = head.steps_per_epoch;
      const share = (step: number): number => (Math.min(Math.max(step - from, 0), last - from) / Math.max(last - from, 1)) * 100;
      const place = <E extends HTMLElement>(one: E, begin: number, end: number): E => {
        one.style.left = `${share(begin).toFixed(2)}%`;
        one.style.width = `${Math.max(share(end) - share(begin), 0).toFixed(2)}%`;
        return one;
      };
      const epochs = Math.round((last - from) / per);
      const lines = epochs > 1 && epochs <= MOST_EPOCHS
        ? Array.from({ length: epochs - 1 }, (_, n) => place(h("span", { class: "epoch" }), from + (n + 1) * per, from + (n + 1) * per))
        : [];
      phases.replaceChildren(
        ...head.phases.flatMap((phase) => {
          const [begin, end] = [phase.from_epoch * per, (phase.from_epoch + phase.epochs) * per];
          if (end <= from || begin >= last) return [];
          const text = `${phase.phase}${phase.in_training ? " (training)" : ""}`;
          return [place(h("span", { class: "phase", title: text }, text), begin, end)];
        }),
        ...lines,
      );
      stretches.replaceChildren(...stayed.flatMap((one) => {
        if (one.from_step + one.steps <= from || one.from_step >= last) return [];
        const text = `Robot ${one.robot} ${one.behaviour}, ${whole(one.steps)} steps from epoch ${one.epoch}, step ${one.epoch_step}`;
        const mark = h("button", { type: "button", class: "stretch", title: text, "aria-label": text });
        mark.addEventListener("click", () => go(one.from_step, one.robot));
        return [place(mark, one.from_step, one.from_step + one.steps)];
      }));
    },
  };
}
