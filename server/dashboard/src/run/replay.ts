// The timeline under the scene: a recording is played, scrubbed, stepped through; another run's can
// be shown beside it, in step.

import { trouble } from "../alert";
import { h, show, write } from "../dom";
import { choose } from "../route";
import { read } from "../server";
import type { Page, RecordingSummary, Run, Stayed } from "../types";
import { sentence, whole } from "../words";
import { beside } from "./beside";
import type { Frame } from "./messages";
import { marks } from "./marks";
import { countedSteps, Player } from "./player";
import { recorder } from "./recorder";
import type { Scene } from "./scene";

/** Times as fast as robots drive. */
const SPEEDS = [0.25, 1, 4, 8, 32, 128, 1024];
/** Epochs that are recorded at most for a moment that is to be seen. */
const MOST_FOR_A_MOMENT = 5;

export interface Replay {
  element: HTMLElement;
  /** The scene beside, where another run is shown. */
  beside: HTMLElement;
  scene: Scene;
  /** The run as it is: its job's runs can be shown beside. */
  run(run: Run): void;
  /** Stretches in which a robot stayed where it was. */
  stayed(all: readonly Stayed[]): void;
  /** Shows a moment, recording its epochs where they are not yet. */
  show(stayed: Stayed, steps_per_epoch: number): void;
  stop(): void;
}

/** `seen` gets what to show, with the counted steps till then; null goes back to what is live. */
export function replay(run: string, options: URLSearchParams, seen: (frame: Frame | null, counted: number | null) => void, pick: (robot: number) => void): Replay {
  let player: Player | null = null;
  let step = Number(options.get("at")) || 0;
  let exact = 0;
  let playing = false;
  let speed = Number(options.get("speed")) || 8;
  let last = 0;
  let tick = 0;
  let names = "";
  let stayed: readonly Stayed[] = [];

  const source = h("select", { id: "recording" }, h("option", { value: "" }, "live"));
  const play = h("button", { type: "button", "aria-pressed": "false" }, "Play");
  const back = h("button", { type: "button", "aria-label": "One moment back" }, "◀");
  const on = h("button", { type: "button", "aria-label": "One moment on" }, "▶");
  const time = h("input", { type: "range", id: "timeline", min: 0, max: 1, step: 1, "aria-label": "Step of the recording" });
  const pace = h("select", { id: "speed" }, ...SPEEDS.map((one) => h("option", { value: one, selected: one === speed }, `${one}x`)));
  const epoch = h("input", { type: "number", id: "epoch", min: 0 });
  const where = h("p", { class: "facts where" });
  const other = h("select", { id: "beside" }, h("option", { value: "" }, "nothing"));
  const second = beside();
  const marked = marks((to, robot) => {
    if (robot !== undefined) pick(robot);
    void go(to);
  });
  const controls = h("div", { class: "timeline", hidden: true },
    h("p", { class: "tools" }, back, play, on, h("label", { for: "speed" }, "Speed"), pace, h("label", { for: "epoch" }, "Epoch"), epoch,
      h("label", { for: "beside" }, "Beside it"), other),
    h("div", { class: "track" }, time, marked.element), where);
  const recording = recorder(run, (items) => list(items), (name) => open(name));
  const element = h("section", { class: "replay", "aria-label": "Replay" },
    h("p", { class: "tools" }, h("label", { for: "recording" }, "Show"), source), controls, recording.element);

  const list = (items: readonly RecordingSummary[]): void => {
    const known = items.map((one) => `${one.name} ${one.state}`).join(" ");
    if (known === names) return;
    names = known;
    source.replaceChildren(
      h("option", { value: "" }, "live"),
      ...items.filter((one) => one.bytes > 0 && one.state !== "queued").map((one) => h("option", { value: one.name },
        `recording ${one.name}: epochs ${whole(one.from_epoch)} to ${whole(one.from_epoch + one.epochs - 1)}, every ${one.every_steps === 1 ? "step" : `${one.every_steps} steps`}`)),
    );
    source.value = player?.name ?? "";
  };
  const every = (): number => player?.recording?.every_steps ?? 1;
  const close = (): void => {
    halt();
    player = null;
    for (const name of ["replay", "at", "beside"]) choose(name, null);
    source.value = "";
    other.value = "";
    show(controls, false);
    void second.choose("", null);
    seen(null, null);
  };
  const open = async (name: string): Promise<void> => {
    halt();
    if (!name) return close();
    const next = new Player(run, name, trouble);
    const head = await next.open();
    player = next;
    choose("replay", name);
    list(recording.items);
    source.value = name;
    show(controls, true);
    time.min = String(next.from);
    time.max = String(next.last);
    time.step = String(head.every_steps);
    epoch.min = String(head.from_epoch);
    epoch.max = String(head.from_epoch + Math.max(head.epochs - 1, 0));
    if (step < next.from || step > next.last) step = next.from;
    marked.draw(head, next.from, next.last, stayed);
    await go(step);
    if (other.value) await besides(other.value);
  };
  const draw = (frame: Frame): void => {
    const head = player!.recording!;
    seen(frame, countedSteps(head, step));
    time.value = String(step);
    const per = head.steps_per_epoch;
    const number = Math.min(Math.floor(step / per), Number(epoch.max));
    if (document.activeElement !== epoch) epoch.value = String(number);
    const said = sentence(`epoch ${whole(number)}`, `step ${whole(step - number * per)} of ${whole(per)}`, frame.phase, `${frame.time_s.toFixed(1)} s simulated`, frame.isTraining && "in the training arena");
    write(where, said);
    time.setAttribute("aria-valuetext", said);
    second.frame(step);
  };
  const halt = (): void => {
    playing = false;
    cancelAnimationFrame(tick);
    write(play, "Play");
    play.setAttribute("aria-pressed", "false");
    if (player) choose("at", String(step));
  };
  const advance = (now: number): void => {
    if (!playing || !player) return;
    const seconds = Math.min((now - last) / 1000, 0.25);
    last = now;
    exact += (seconds * speed) / (player.recording?.step_s ?? 0.064);
    const next = Math.min(Math.floor(exact), player.last);
    const frame = player.frameAt(next);
    if (frame && second.frame(next)) {
      step = next;
      draw(frame);
    } else {
      // What has not come yet is waited for.
      exact = step;
    }
    if (step >= player.last) return halt();
    tick = requestAnimationFrame(advance);
  };
  const toggle = (): void => {
    if (!player) return;
    if (playing) return halt();
    if (step >= player.last) step = player.from;
    playing = true;
    exact = step;
    last = performance.now();
    write(play, "Pause");
    play.setAttribute("aria-pressed", "true");
    tick = requestAnimationFrame(advance);
  };
  /** Goes to a step, waiting until it has been read. */
  const go = async (to: number): Promise<void> => {
    const now = player;
    if (!now) return;
    step = Math.min(Math.max(to, now.from), now.last);
    exact = step;
    if (!playing) choose("at", String(step));
    const wanted = step;
    const [frame] = await Promise.all([now.load(wanted), second.load(wanted)]);
    if (frame && player === now && step === wanted) draw(frame);
  };
  const besides = async (id: string): Promise<void> => {
    choose("beside", id || null);
    await second.choose(id, player?.recording ?? null);
    await go(step);
  };

  play.addEventListener("click", toggle);
  back.addEventListener("click", () => void go(step - every()));
  on.addEventListener("click", () => void go(step + every()));
  time.addEventListener("input", () => void go(Number(time.value)));
  epoch.addEventListener("change", () => void go(Number(epoch.value) * (player?.recording?.steps_per_epoch ?? 1)));
  pace.addEventListener("change", () => {
    speed = Number(pace.value);
    choose("speed", speed === 8 ? null : pace.value);
  });
  source.addEventListener("change", () => {
    if (source.value) recording.want(source.value);
    else close();
  });
  other.addEventListener("change", () => void besides(other.value).catch(trouble));
  const key = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement | null;
    if (!player || target?.matches("input:not([type=range]), select, textarea, canvas")) return;
    const isRange = target?.matches("input") ?? false;
    if (event.key === " " && !target?.matches("button, a, summary")) toggle();
    else if (event.key === "ArrowRight" && !isRange) void go(step + every());
    else if (event.key === "ArrowLeft" && !isRange) void go(step - every());
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  };
  addEventListener("keydown", key);

  const wished = options.get("beside");
  if (wished) {
    other.append(h("option", { value: wished }, wished.slice(0, 8)));
    other.value = wished;
  }
  if (options.get("replay")) recording.want(options.get("replay")!);
  let job = "";
  let state = "";
  return {
    element,
    beside: second.element,
    scene: second.scene,
    run: (about) => {
      if (state !== about.state && state !== "") recording.look();
      state = about.state;
      if (job === about.job_id) return;
      job = about.job_id;
      read<Page<Run>>(`/v1/jobs/${job}/runs?limit=50`).then(({ items: runs }) => {
        const chosen = other.value;
        const others = runs.filter((one) => one.id !== run);
        other.replaceChildren(h("option", { value: "" }, "nothing"), ...others.map((one) =>
          h("option", { value: one.id }, sentence(one.label || one.method, `seed ${one.seed}`))));
        if (chosen && !others.some((one) => one.id === chosen)) other.append(h("option", { value: chosen }, chosen.slice(0, 8)));
        other.value = chosen;
      }, trouble);
    },
    stayed: (all) => {
      stayed = all;
      if (player?.recording) marked.draw(player.recording, player.from, player.last, stayed);
    },
    show: (one, per) => {
      pick(one.robot);
      step = one.from_step;
      if (player && player.from <= step && step < player.last) return void go(step);
      const there = recording.items.find((item) => item.state === "done" && item.from_epoch <= one.epoch && one.epoch < item.from_epoch + item.epochs);
      if (there) return recording.want(there.name);
      const end = Math.floor((one.from_step + Math.max(one.steps, 1) - 1) / per);
      recording.record(one.epoch, Math.min(Math.max(end - one.epoch + 1, 1), MOST_FOR_A_MOMENT), 1);
    },
    stop: () => {
      playing = false;
      cancelAnimationFrame(tick);
      recording.stop();
      second.stop();
      removeEventListener("keydown", key);
    },
  };
}
