// One place on the page that says what went wrong, and how old what is shown is.

import { h, show, write } from "./dom";
import { Problem } from "./server";

/** What a screen is made of. */
export interface Screen {
  element: HTMLElement;
  title: string;
  /** Ends its streams and watches. */
  stop(): void;
}

export const alert = h("p", { id: "alert", role: "alert", hidden: true });
let heard_at = Date.now();
let lost = false;

/** Tells what went wrong; of a connection that is lost, the age of what is shown. */
export function trouble(error: unknown): void {
  if (error instanceof Problem) {
    write(alert, error.message);
    show(alert, true);
  } else if (!lost) {
    lost = true;
    age();
  }
}

/** The server has answered. */
export function calm(): void {
  heard_at = Date.now();
  lost = false;
  show(alert, false);
}

function age(): void {
  if (!lost) return;
  const age_s = Math.round((Date.now() - heard_at) / 1000);
  // Screen readers hear the first alone: the text changes by tens of seconds later.
  const shown = age_s < 10 ? age_s : Math.floor(age_s / 10) * 10;
  write(alert, `The server cannot be reached; what is shown is ${shown} s old. Trying again.`);
  show(alert, true);
}
setInterval(age, 1_000);
