// The page's one stream of events: of all jobs, and of the run that is open what is heard of it. While
// it cannot be had, whoever needs to know asks again and again.

import { calm, trouble } from "./alert";
import { Problem } from "./server";
import { events, type Stream } from "./stream";
import type { CurveRow, Job, MetricsRow, Progress, Run, State } from "./types";

/** What is heard; `begin` and `lost` are of the stream itself. */
export type Heard =
  | { name: "job"; data: Job }
  | { name: "gone"; data: { job_id: string } }
  | { name: "state"; data: { run_id: string; state: State } }
  | { name: "run"; data: Run }
  | { name: "progress"; data: Progress }
  | { name: "coverage"; data: CurveRow }
  | { name: "metrics"; data: MetricsRow }
  | { name: "begin" | "lost"; data: null };

const OF_A_RUN = new Set(["run", "progress", "coverage", "metrics"]);
const listeners = new Set<(event: Heard) => void>();
let stream: Stream | null = null;
let live = false;
let followed = "";
let asked = "";

const tell = (event: Heard): void => listeners.forEach((listener) => listener(event));

const open = (): Stream =>
  events(
    {
      path: () => {
        asked = followed;
        return followed ? `/v1/events?${new URLSearchParams({ run: followed })}` : "/v1/events";
      },
      begun: () => {
        live = true;
        tell({ name: "begin", data: null });
      },
      lost: () => {
        const was = live;
        live = false;
        if (was) tell({ name: "lost", data: null });
      },
      failed: (error) => {
        if (!(error instanceof Problem)) trouble(error);
        // Of a run that is not there its screen tells; where too many listen, asking does as well.
        else if (error.status === 404) followed = "";
        return false;
      },
    },
    (name, data) => {
      calm();
      const event = { name, data } as Heard;
      // Of the run that was followed before, parts may still come.
      if (OF_A_RUN.has(name) && asked !== followed) return;
      tell(event);
    },
  );

/** Hears events until what it gives is called. */
export function hear(listener: (event: Heard) => void): () => void {
  listeners.add(listener);
  stream ??= open();
  return () => listeners.delete(listener);
}

/** Hears of a run what is not told of others, until another is followed. */
export function follow(run: string): void {
  followed = run;
  if (run && run !== asked) stream?.again();
}

/** Whether events are heard at present. */
export const isHeard = (): boolean => live;
