// The timeline under the scene: a recording is played, scrubbed, stepped through; another run's can
// be shown beside it, in step.

import { trouble } from "../alert";
import { h, show, write } from "../dom";
import { choose } from "../route";
import { post, read, watch } from "../server";
import type { Arena, Page, RecordingSummary, Run } from "../types";
import { percent, sentence, whole } from "../words";
import type { Frame } from "./frames";
import { Player } from "./player";
import { scene } from "./scene";

const LOOK_EVERY_MS = 2_000;
/** Times as fast as robots drive. */
const SPEEDS = [0.25, 1, 4, 8, 32, 128, 1024];

export interface Replay {
  element: HTMLElement;
  /** The scene beside, where another run is shown. */
  beside: HTMLElement;
  /** The job whose runs can be shown beside. */
  job(id: string): void;
  stop(): void;
}

/** `onFrame` gets what to show; null goes back to what is live. */
export function replay(run: string, options: URLSearchParams, onFrame: (frame: Frame | null) => void): Replay {
  let player: Player | null = null;
  let other: Player | null = null;
  let step = Number(options.get("at")) || 0;
  let playing = false;
  let speed = Number(options.get("speed")) || 8;
  let last = 0;
  let tick = 0;
  let items: RecordingSummary[] = [];
  let shown = "";

  const source = h("select", { id: "recording" }, h("option", { value: "" }, "live"));
  const play = h("button", { type: "button", "aria-pressed": "false" }, "Play");
  const back = h("button", { type: "button", "aria-label": "One moment back" }, "◀");
  const on = h("button", { type: "button", "aria-label": "One moment on" }, "▶");
  const time = h("input", { type: "range", id: "timeline", min: 0, max: 1, step: 1, "aria-label": "Step of the recording" });
  const pace = h("select", { id: "speed" }, ...SPEEDS.map((one) => h("option", { value: one, selected: one === speed }, `${one}x`)));
  const epoch = h("input", { type: "number", id: "epoch", min: 0 });
  const where = h("p", { class: "facts" });
  const beside = h("select", { id: "beside" }, h("option", { value: "" }, "nothing"));
  const marks = h("datalist", { id: "epochs" });
  time.setAttribute("list", "epochs");
  const controls = h("div", { class: "timeline", hidden: true },
    h("p", { class: "tools" }, back, play, on, h("label", { for: "speed" }, "Speed"), pace, h("label", { for: "epoch" }, "Epoch"), epoch,
      h("label", { for: "beside" }, "Beside it"), beside),
    time, marks, where);

  const from = h("input", { id: "record-from", inputmode: "numeric", value: "0", size: 6 });
  const epochs = h("input", { id: "record-epochs", inputmode: "numeric", value: "5", size: 6 });
  const every = h("input", { id: "record-every", inputmode: "numeric", value: "1", size: 4 });
  const record = h("button", { type: "submit" }, "Record");
  const asked = h("p", { class: "facts", role: "status" });
  const form = h("form", { class: "tools" },
    h("label", { for: "record-from" }, "From epoch"), from, h("label", { for: "record-epochs" }, "epochs"), epochs,
    h("label", { for: "record-every" }, "every steps"), every, record);
  const recorder = h("details", {}, h("summary", {}, "Record a stretch of this run"),
    h("p", { class: "quiet" }, "The run is stepped again in the background; results stay as they are. Epochs are counted from 0 over all phases, training included."),
    form, asked);
  const element = h("section", { "aria-label": "Replay" },
    h("p", { class: "tools" }, h("label", { for: "recording" }, "Show"), source), controls, recorder);

  const second = scene(() => undefined);
  const besideElement = h("div", { class: "beside", hidden: true }, h("p", { class: "facts" }), second.element);

  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const body = { from_epoch: Number(from.value), epochs: Number(epochs.value), every_steps: Number(every.value), fields: ["pose", "command", "sensors", "decision"] };
    post<RecordingSummary>(`/v1/runs/${run}/recordings`, JSON.stringify(body)).then((made) => {
      wanted = made.name;
      looking.now();
    }, trouble);
  });

  let wanted = options.get("replay") ?? "";
  const looking = watch(
    LOOK_EVERY_MS,
    async (signal) => {
      const isMade = items.some((one) => ["queued", "recording"].includes(one.state));
      if (items.length > 0 && !isMade && !wanted && shown !== "") return;
      items = (await read<{ items: RecordingSummary[] }>(`/v1/runs/${run}/recordings`, signal)).items;
      const names = items.map((one) => one.name).join(" ");
      if (names !== shown || shown === "") {
        shown = names || "none";
        source.replaceChildren(
          h("option", { value: "" }, "live"),
          ...items.map((one) => h("option", { value: one.name }, `recording ${one.name}: epochs ${whole(one.from_epoch)} to ${whole(one.from_epoch + one.epochs - 1)}, every ${one.every_steps === 1 ? "step" : `${one.every_steps} steps`}`)),
        );
        source.value = player?.name ?? "";
      }
      const made = items.find((one) => ["queued", "recording"].includes(one.state));
      write(asked, made ? `Recording ${made.name} is ${made.state}${made.progress != null ? `, ${percent(made.progress)}` : ""}.` : "");
      const ready = items.find((one) => one.name === wanted && (one.state === "done" || (one.state === "recording" && one.bytes > 0)));
      if (ready && player?.name !== wanted) await choosePlayer(wanted);
      if (player && player.recording?.state === "recording") await player.open(signal).then(bounds);
    },
    trouble,
  );
  const bounds = (): void => {
    if (!player) return;
    time.min = String(player.from);
    time.max = String(Math.max(player.from, player.to - 1));
    time.step = String(player.recording?.every_steps ?? 1);
  };
  const choosePlayer = async (name: string): Promise<void> => {
    stopPlaying();
    choose("replay", name || null);
    source.value = name;
    show(controls, name !== "");
    if (!name) {
      player = null;
      wanted = "";
      choose("at", null);
      show(besideElement, false);
      onFrame(null);
      return;
    }
    const next = new Player(run, name, trouble);
    const head = await next.open();
    player = next;
    wanted = "";
    bounds();
    if (step < next.from || step >= next.to) step = next.from;
    const per = head.steps_per_epoch;
    const count = Math.ceil((next.to - next.from) / per);
    epoch.min = String(head.from_epoch);
    epoch.max = String(head.from_epoch + Math.max(count - 1, 0));
    marks.replaceChildren(...(count <= 200 ? Array.from({ length: count }, (_, n) => h("option", { value: next.from + n * per })) : []));
    if (options.get("beside")) await chooseBeside(options.get("beside")!);
    await draw();
  };
  /** Draws the moment, waiting until it has been read. */
  const draw = async (): Promise<void> => {
    const now = player;
    if (!now) return;
    for (let tries = 0; tries < 100 && player === now; tries++) {
      const frame = now.frameAt(step);
      if (frame) {
        showFrame(frame);
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  };
  const showFrame = (frame: Frame): void => {
    onFrame(frame);
    time.value = String(step);
    const per = player!.recording!.steps_per_epoch;
    const number = Math.min(Math.floor(frame.step / per), Number(epoch.max));
    if (document.activeElement !== epoch) epoch.value = String(number);
    const said = sentence(`epoch ${whole(number)}`, `step ${whole(frame.step - number * per)} of ${whole(per)}`, frame.phase, `${frame.time_s.toFixed(1)} s simulated`, frame.isTraining && "in the training arena");
    write(where, said);
    time.setAttribute("aria-valuetext", said);
    if (other) {
      const beside = other.frameAt(step);
      if (beside) second.frame(beside);
    }
  };
  const stopPlaying = (): void => {
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
    const next = Math.min(Math.floor(exact), player.to - 1);
    const frame = player.frameAt(next);
    if (frame && (!other || other.frameAt(next))) {
      step = next;
      showFrame(frame);
    } else {
      // What has not come yet is waited for.
      exact = step;
    }
    if (step >= player.to - 1) return stopPlaying();
    tick = requestAnimationFrame(advance);
  };
  let exact = 0;
  const toggle = (): void => {
    if (!player) return;
    if (playing) return stopPlaying();
    if (step >= player.to - 1) step = player.from;
    playing = true;
    exact = step;
    last = performance.now();
    write(play, "Pause");
    play.setAttribute("aria-pressed", "true");
    tick = requestAnimationFrame(advance);
  };
  const go = (to: number): void => {
    if (!player) return;
    step = Math.min(Math.max(to, player.from), player.to - 1);
    exact = step;
    if (!playing) choose("at", String(step));
    void draw();
  };
  const every_steps = (): number => player?.recording?.every_steps ?? 1;
  play.addEventListener("click", toggle);
  back.addEventListener("click", () => go(step - every_steps()));
  on.addEventListener("click", () => go(step + every_steps()));
  time.addEventListener("input", () => go(Number(time.value)));
  epoch.addEventListener("change", () => go(Number(epoch.value) * (player?.recording?.steps_per_epoch ?? 1)));
  pace.addEventListener("change", () => {
    speed = Number(pace.value);
    choose("speed", speed === 8 ? null : pace.value);
  });
  source.addEventListener("change", () => void choosePlayer(source.value).catch(trouble));

  const chooseBeside = async (id: string): Promise<void> => {
    choose("beside", id || null);
    if (beside.value !== id) {
      if (![...beside.options].some((option) => option.value === id)) beside.append(h("option", { value: id }, id.slice(0, 8)));
      beside.value = id;
    }
    show(besideElement, id !== "");
    other = null;
    if (!id || !player?.recording) return;
    // The same stretch of the other run: recorded now if it is not there yet.
    const { from_epoch, epochs: count, every_steps } = player.recording;
    const body = { from_epoch, epochs: count, every_steps, fields: ["pose", "command", "sensors", "decision"] };
    const [arena, about, made] = await Promise.all([
      read<Arena>(`/v1/runs/${id}/arena`), read<Run>(`/v1/runs/${id}`),
      post<RecordingSummary>(`/v1/runs/${id}/recordings`, JSON.stringify(body)),
    ]);
    write(besideElement.querySelector("p")!, sentence(about.label || about.method, about.arena, `seed ${about.seed}`));
    second.arena(arena, player.recording.body_radius_m, null);
    const next = new Player(id, made.name, trouble);
    for (let look = 0; look < 300; look++) {
      const { items } = await read<{ items: RecordingSummary[] }>(`/v1/runs/${id}/recordings`);
      const state = items.find((one) => one.name === made.name)?.state;
      if (state === "done" || state === undefined) break;
      await new Promise((resolve) => setTimeout(resolve, 500));
    }
    if (beside.value !== id) return;
    await next.open();
    other = next;
    for (let look = 0; look < 100 && !other.frameAt(step); look++) await new Promise((resolve) => setTimeout(resolve, 50));
    await draw();
  };
  beside.addEventListener("change", () => void chooseBeside(beside.value).catch(trouble));
  const key = (event: KeyboardEvent): void => {
    if (!player || (event.target as HTMLElement | null)?.matches("input:not([type=range]), select, textarea, canvas")) return;
    if (event.key === " " && !(event.target as HTMLElement | null)?.matches("button, a, summary")) toggle();
    else if (event.key === "ArrowRight" && !(event.target as HTMLElement | null)?.matches("input")) go(step + every_steps());
    else if (event.key === "ArrowLeft" && !(event.target as HTMLElement | null)?.matches("input")) go(step - every_steps());
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  };
  addEventListener("keydown", key);
  let job = "";
  return {
    element,
    beside: besideElement,
    job: (id) => {
      if (job === id) return;
      job = id;
      read<Page<Run>>(`/v1/jobs/${id}/runs?limit=50`).then(({ items: runs }) => {
        const chosen = beside.value;
        beside.replaceChildren(h("option", { value: "" }, "nothing"), ...runs.filter((one) => one.id !== run).map((one) =>
          h("option", { value: one.id }, sentence(one.label || one.method, `seed ${one.seed}`))));
        if (chosen) beside.value = chosen;
      }, trouble);
    },
    stop: () => {
      playing = false;
      cancelAnimationFrame(tick);
      looking.stop();
      second.stop();
      removeEventListener("keydown", key);
    },
  };
}
