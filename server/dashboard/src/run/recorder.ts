// The recordings of a run: which there are, and how one is asked for of a stretch that has none.

import { trouble } from "../alert";
import { h, measure, show, write } from "../dom";
import { post, read, watch } from "../server";
import type { RecordingSummary } from "../types";
import { duration, percent, sentence, whole } from "../words";

const LOOK_EVERY_MS = 1_000;
export const FIELDS = ["pose", "command", "sensors", "decision"];

export interface Recorder {
  /** The form and how far the one is that is being made. */
  element: HTMLElement;
  readonly items: readonly RecordingSummary[];
  /** Tells `ready` as soon as this recording can be read. */
  want(name: string): void;
  /** Asks for a stretch, and wants it. */
  record(from_epoch: number, epochs: number, every_steps: number): void;
  /** Looks again, as the run has changed. */
  look(): void;
  stop(): void;
}

export function recorder(run: string, listed: (items: RecordingSummary[]) => void, ready: (name: string) => Promise<void>): Recorder {
  const from = h("input", { id: "record-from", inputmode: "numeric", value: "0", size: 6 });
  const epochs = h("input", { id: "record-epochs", inputmode: "numeric", value: "5", size: 6 });
  const every = h("input", { id: "record-every", inputmode: "numeric", value: "1", size: 4 });
  const button = h("button", { type: "submit" }, "Record");
  const status = h("p", { class: "facts", role: "status" });
  const bar = h("progress", { max: 1, hidden: true, "aria-label": "Share of the recording that is made" });
  const none = h("p", { class: "quiet", hidden: true }, "Nothing of this run is recorded yet: ask for a stretch of it, and it can be played, scrubbed and set beside another run.");
  const form = h("form", { class: "tools" },
    h("label", { for: "record-from" }, "From epoch"), from, h("label", { for: "record-epochs" }, "epochs"), epochs,
    h("label", { for: "record-every" }, "every steps"), every, button);
  const details = h("details", { class: "changes" }, h("summary", {}, "Record a stretch of this run"), none,
    h("p", { class: "quiet" }, "The run is stepped again in the background; results stay as they are. Epochs are counted from 0 over all phases, training included."),
    form);
  const element = h("div", { class: "recorder" }, status, bar, details);

  let items: RecordingSummary[] = [];
  let wanted = "";
  let isStale = true;
  let isFirst = true;
  let begun: { name: string; at: number } | null = null;

  const pending = (): RecordingSummary | undefined => items.find((one) => ["queued", "recording"].includes(one.state) && one.name !== "live");
  const tell = (): void => {
    const made = pending();
    const lost = items.find((one) => one.name === wanted && one.state === "cut" && one.bytes === 0);
    show(bar, made !== undefined);
    if (made && begun?.name !== made.name) begun = { name: made.name, at: performance.now() };
    if (!made) begun = null;
    const share = made?.progress ?? 0;
    if (made) measure(bar, share);
    const left = begun && share > 0.02 ? ((performance.now() - begun.at) / 1000) * (1 / share - 1) : null;
    if (lost) wanted = "";
    write(status, made
      ? sentence(`Recording ${made.name}, epochs ${whole(made.from_epoch)} to ${whole(made.from_epoch + made.epochs - 1)}, ${made.state === "queued" ? "waits" : "is being made"}`,
        made.progress != null && percent(made.progress), left !== null && `${duration(left)} left`)
      : lost ? `Recording ${lost.name} was given up: ${lost.reason ?? "no reason is known"}.` : "");
  };
  const looking = watch(
    LOOK_EVERY_MS,
    async (signal) => {
      if (!isStale && !wanted && !pending()) return;
      isStale = false;
      items = (await read<{ items: RecordingSummary[] }>(`/v1/runs/${run}/recordings`, signal)).items;
      if (isFirst && items.length === 0) show(none, true);
      isFirst = false;
      if (items.length > 0) show(none, false);
      listed(items);
      tell();
      const there = items.find((one) => one.name === wanted && (["done", "cut"].includes(one.state) || one.name === "live") && one.bytes > 0);
      if (!there) return;
      wanted = "";
      await ready(there.name);
    },
    trouble,
  );
  const record: Recorder["record"] = (from_epoch, count, every_steps) => {
    button.disabled = true;
    post<RecordingSummary>(`/v1/runs/${run}/recordings`, JSON.stringify({ from_epoch, epochs: count, every_steps, fields: FIELDS }))
      .then((made) => {
        wanted = made.name;
        looking.now();
      }, trouble)
      .finally(() => { button.disabled = false; });
  };
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    record(Number(from.value), Number(epochs.value), Number(every.value));
  });
  return {
    element,
    get items() { return items; },
    want: (name) => {
      wanted = name;
      isStale = true;
      looking.now();
    },
    record,
    look: () => {
      isStale = true;
      looking.now();
    },
    stop: () => looking.stop(),
  };
}
