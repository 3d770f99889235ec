// A run, live: where its robots are, what they covered, what one of them senses and has learnt.

import { trouble, type Screen } from "../alert";
import { h, keyed, measure, show, write } from "../dom";
import { choose, link } from "../route";
import { post, read, watch } from "../server";
import { follow, hear, isHeard } from "../feed";
import type { Coverage, CurveRow, Learnt, Progress, Run, RunSpec } from "../types";
import { bytes, figure, pace, percent, sentence, whole } from "../words";
import { arenasOf, type Arenas } from "./arenas";
import { curveChart } from "./curve";
import { explainer, reachOf } from "./explain";
import { forkDialog } from "./fork";
import { watchFrames } from "./frames";
import { choiceOf, type Frame } from "./messages";
import { hearers } from "./overlays";
import { replay } from "./replay";
import { robotsTable } from "./robots";
import { LAYERS, scene, type Layer, type Over, type Scene } from "./scene";
import { senses } from "./senses";
import { tableView } from "./table";

/** What one robot senses is read by people: it need not be written with every picture. */
const ROBOT_EVERY_MS = 100;
const LEARNT_EVERY_MS = 1_000;
const FINDINGS_EVERY_MS = 2_000;
const ENDED = ["done", "failed", "cancelled"];
const WAITS_FOR = { lossless_readers: "readers of its lossless channel", controllers: "the programs that steer it", store: "the store, to keep its end" };

/** A file of a run, as the server's own table lists it. */
interface RunFile {
  route: string;
  needs_result: boolean;
  needs_objects: boolean;
}

export function runScreen(id: string, options: URLSearchParams): Screen {
  const heading = h("h2", {}, `Run ${id.slice(0, 8)}`);
  const badge = h("span", { class: "badge" });
  const bar = h("progress", { max: 1, "aria-label": "Share of the work done" });
  const facts = h("p", { class: "facts" });
  const moment = h("p", { class: "facts moment" });
  const about = h("p", { class: "facts about" });
  const told = h("p", { class: "facts", hidden: true });
  const why = h("p", { class: "bad", hidden: true });
  const waits = h("span", { class: "quiet", hidden: true });
  const job = h("a", { class: "button" }, "Its job");
  const figures = h("dl", { class: "figures" });
  const learner = h("dl", { class: "figures" });
  const files = h("ul", { class: "plain files", "aria-label": "Files of this run" });

  const act = (name: string, what: string, body?: string, sure?: string): HTMLButtonElement => {
    const button = h("button", { type: "button", class: "changes", hidden: true }, name);
    button.addEventListener("click", () => {
      if (sure && !confirm(sure)) return;
      post<Run>(`/v1/runs/${id}/${what}`, body).then(showRun, trouble);
    });
    return button;
  };
  const pause = act("Pause", "pause");
  const resume = act("Resume", "resume");
  const step = act("One epoch", "step", '{"epochs":1}');
  const cancel = act("Cancel", "cancel", undefined, "Cancel this run, in every job that has it? It stops for good.");

  let robot = Math.max(0, Number(options.get("robot")) || 0);
  const picture = scene((chosen) => chooseRobot(chosen));
  let isReplaying = false;
  const player = replay(id, options, (next, counted) => {
    const was = isReplaying;
    isReplaying = next !== null;
    picture.until(counted);
    if (next) {
      // Nothing live is sent while a recording is shown.
      if (!was) {
        isLive = false;
        if (isCovered) seeing.stop();
      }
      seen(next);
      write(moment, "");
    } else if (was) {
      seeing.stop();
      isLive = true;
      seeing = watchNow();
    }
  }, (chosen) => chooseRobot(chosen));
  const scenes: Scene[] = [picture, player.scene];
  const why_it_did = explainer(id, options, player.stayed, (one) => {
    if (spec) player.show(one, spec.steps_per_epoch);
    picture.element.scrollIntoView({ block: "nearest" });
  });
  const fork = forkDialog(id);
  const body = senses();
  const table = tableView();
  const robots = robotsTable(id, options, (chosen) => chooseRobot(chosen));
  const curve = curveChart();
  const layer = h("select", { id: "layer" }, ...Object.entries(LAYERS).map(([value, text]) => h("option", { value }, text)));
  const chosenLayer = options.get("layer");
  if (chosenLayer && chosenLayer in LAYERS) layer.value = chosenLayer;
  for (const one of scenes) one.layer(layer.value as Layer);
  layer.addEventListener("change", () => {
    choose("layer", layer.value === "visits" ? null : layer.value);
    for (const one of scenes) one.layer(layer.value as Layer);
  });
  const on = new Set((options.get("show") ?? "robots trails").split(" "));
  const over = (what: Over, text: string): HTMLElement => {
    const box = h("input", { type: "checkbox", checked: on.has(what) });
    for (const one of scenes) one.over(what, on.has(what));
    box.addEventListener("change", () => {
      if (box.checked) on.add(what);
      else on.delete(what);
      choose("show", [...on].join(" "));
      for (const one of scenes) one.over(what, box.checked);
    });
    return h("label", {}, box, ` ${text}`);
  };
  const radio = over("radio", "who tells whom by radio");
  const number = h("input", { id: "robot", type: "number", min: 0, value: robot });
  number.addEventListener("change", () => chooseRobot(Number(number.value)));
  const tools = h(
    "div",
    { class: "tools" },
    h("label", { for: "layer" }, "Map"), layer,
    over("robots", "robots"), over("rays", "rays"), over("trails", "trails"), radio,
  );
  const chooser = h("p", { class: "tools" }, h("label", { for: "robot" }, "Robot"), number);
  const element = h(
    "article",
    { class: "screen panel run" },
    h("div", { class: "head" }, heading, badge, waits, h("span", { class: "actions" }, pause, resume, step, cancel, why_it_did.button, fork.button, job)),
    why_it_did.element, bar, facts, why,
    h("div", { class: "two" },
      h("div", { class: "left" }, tools, h("div", { class: "scenes" }, h("div", {}, about, picture.element), player.beside), player.element, moment, told, curve.element),
      h("div", { class: "right" }, h("h3", {}, "This run"), figures, h("h3", {}, "One robot"), chooser, learner, body.element, table.element, robots.element)),
    h("h3", {}, "Files"),
    files,
  );

  let run: Run | null = null;
  let spec: RunSpec | null = null;
  let arenas: Arenas | null = null;
  let frame: Frame | null = null;
  let running = false;
  let rate = { at: 0, step: 0, pictures: 0 };
  let isStale = true;
  let isLive = true;
  let isCovered = false;
  let asked = "";
  let robotDue = 0;

  const chooseRobot = (next: number): void => {
    const most = (frame?.robots ?? spec?.robots ?? 1) - 1;
    robot = Math.min(Math.max(0, Math.floor(next) || 0), most);
    number.value = String(robot);
    choose("robot", robot === 0 ? null : String(robot));
    for (const one of scenes) one.choose(robot);
    if (frame) showRobot(frame);
    asking.now();
  };
  for (const one of scenes) one.choose(robot);

  const showRobot = (f: Frame): void => {
    body.draw(f, robot);
    table.at(choiceOf(f, robot));
    const range = rangeOf(spec);
    show(told, range !== null && on.has("radio"));
    if (range !== null && on.has("radio")) {
      const heard = hearers(f, robot, range);
      const some = heard.slice(0, 20).join(", ");
      write(told, heard.length === 0
        ? `Robot ${robot} tells nobody at this step: none is in range of its radio.`
        : `Robot ${robot} and ${heard.length === 1 ? "robot" : "robots"} ${some}${heard.length > 20 ? ` and ${whole(heard.length - 20)} more` : ""} tell each other at this step.`);
    }
  };
  const showArena = (): void => {
    if (!spec || !arenas) return;
    const where = frame?.isTraining ? arenas.training : arenas.target;
    const range = rangeOf(spec);
    show(radio, range !== null);
    picture.arena(where, spec.robot?.body_radius_m ?? 0.037, range);
  };
  const showMoment = (f: Frame): void => {
    const now = performance.now();
    rate.pictures += 1;
    if (now - rate.at < 500) return;
    const seconds = (now - rate.at) / 1000;
    const [fps, steps] = [rate.pictures / seconds, (f.step - rate.step) / Math.max(rate.pictures, 1)];
    const first = rate.at === 0;
    rate = { at: now, step: f.step, pictures: 0 };
    write(moment, sentence(
      `step ${whole(f.step)}`, `${whole(f.time_s)} s simulated`, f.isTraining && "in the training arena",
      !first && `${fps.toFixed(0)} pictures/s, ${steps < 2 ? "every step" : `one in ${whole(Math.round(steps))} steps`}`,
    ));
  };
  const showProgress = (progress: Progress | null): void => {
    measure(bar, progress?.fraction ?? (run?.state === "done" ? 1 : 0));
    write(
      facts,
      sentence(
        progress && run?.state !== "done" && `${progress.phase}, epoch ${whole(progress.epochs_done)} of ${whole(progress.epochs_total)}`,
        progress && percent(progress.fraction),
        progress && pace(progress),
        spec && `${whole(spec.robots)} ${spec.robots === 1 ? "robot" : "robots"}, ${spec.engine}`,
      ),
    );
  };
  function showRun(next: Run): void {
    run = next;
    const title = sentence(next.label || next.method, next.arena, `seed ${next.seed}`);
    write(heading, title);
    write(about, title);
    document.title = `${title} – evswarm`;
    write(badge, next.state);
    badge.dataset["state"] = next.state;
    show(waits, next.waits_for != null);
    write(waits, next.waits_for ? `waits for ${WAITS_FOR[next.waits_for]}` : "");
    job.href = link("job", next.job_id);
    player.run(next);
    fork.run(next);
    robots.run(next);
    running = next.state === "running";
    show(pause, ["queued", "running"].includes(next.state));
    show(resume, next.state === "paused");
    show(step, next.state === "paused");
    show(cancel, !ENDED.includes(next.state));
    show(why, next.error != null);
    write(why, next.error ?? "");
    showProgress(next.progress ?? null);
    isStale = true;
  }

  const readRun = (): Promise<void> => read<Run>(`/v1/runs/${id}`).then(showRun);
  const hearing = hear((event) => {
    if (event.name === "run" && event.data.id === id) showRun(event.data);
    else if (event.name === "progress" && running) {
      showProgress(event.data);
      isStale = true;
    } else if (event.name === "state" && event.data.run_id === id) readRun().catch(trouble);
  });
  follow(id);
  const showRobotSoon = (): void => {
    if (robotDue !== 0) return;
    robotDue = window.setTimeout(() => {
      robotDue = 0;
      if (frame) showRobot(frame);
    }, ROBOT_EVERY_MS);
  };
  const seen = (next: Frame): void => {
    frame = next;
    showArena();
    picture.frame(next);
    showRobotSoon();
  };
  const watchNow = () => watchFrames(id, {
    frame: (next) => {
      if (isReplaying) return;
      seen(next);
      showMoment(next);
    },
    squares: (squares) => {
      picture.squares(squares);
      isCovered = true;
      // Beside a recording what was covered in all is wanted once.
      if (!isLive) seeing.stop();
    },
    waiting: () => write(moment, run?.state === "paused" ? "Paused: this is where the robots stand." : "Waits for a worker."),
    isOver: () => !isLive || (run !== null && ENDED.includes(run.state)),
  });
  let seeing = watchNow();
  // What a robot has learnt is asked for while it changes, and of a method that learns.
  const asking = watch(
    LEARNT_EVERY_MS,
    async (signal) => {
      if (!run || ["failed", "cancelled"].includes(run.state)) return;
      // Whether there is something to ask for: the result of a run that is done has a model then.
      const learns = run.state === "done"
        ? run.result?.model != null
        : (frame?.learns ?? (run.state === "paused" && spec !== null && !["brownian", "levy"].includes(spec.controller.method)));
      const what = `${run.state} ${robot}`;
      if (!learns || (!running && what === asked)) return;
      asked = what;
      const learnt = await read<Learnt>(`/v1/runs/${id}/learnt?robot=${robot}`, signal);
      if (learnt.robot !== robot) return;
      table.draw(learnt);
      list(learner, learnerRows(learnt));
    },
    (error) => {
      // It may end between two looks.
      if (running) trouble(error);
    },
  );
  // What the run covered: again when it has gone on.
  const finding = watch(
    FINDINGS_EVERY_MS,
    async (signal) => {
      if (!spec) {
        spec = await read<RunSpec>(`/v1/runs/${id}/spec`, signal);
        number.max = String(spec.robots - 1);
        show(chooser, spec.robots > 1);
        arenas = await arenasOf(id, spec, signal);
        if (run) showProgress(run.progress ?? null);
        showArena();
        void reachOf(id).then((rows) => picture.reach(rows));
      }
      // What is not heard is asked for, and what may be heard late.
      if (!run || !isHeard()) await readRun();
      if (!run || !isStale || ["failed", "cancelled"].includes(run.state)) return;
      isStale = false;
      const [coverage, rows] = await Promise.all([
        read<Coverage>(`/v1/runs/${id}/coverage`, signal),
        read<CurveRow[] | { rows: CurveRow[] }>(`/v1/runs/${id}/curve?points=500`, signal),
      ]);
      list(figures, rowsOf(run, spec, coverage));
      curve.draw(Array.isArray(rows) ? rows : rows.rows);
      const listed = await fileTable();
      keyed(
        files,
        listed.filter((file) => !file.needs_objects && (!file.needs_result || run?.result != null)),
        (file) => file.route,
        (file) => h("li", {}, h("a", { href: `/v1/runs/${id}/${file.route}` }, file.route)),
        () => undefined,
      );
    },
    trouble,
  );
  const key = (event: KeyboardEvent): void => {
    if ((event.target as HTMLElement | null)?.matches("input, select, textarea, button, canvas, a")) return;
    if (event.key === " " && run) {
      const button = [pause, resume].find((one) => !one.hidden);
      if (button) {
        event.preventDefault();
        button.click();
      }
    } else if (event.key === "ArrowRight" && !step.hidden) step.click();
  };
  addEventListener("keydown", key);
  // For tests of how fluid it is.
  (element as HTMLElement & { drawn?: unknown }).drawn = picture.drawn;
  return {
    element,
    title: `Run ${id.slice(0, 8)}`,
    stop: () => {
      hearing();
      follow("");
      clearTimeout(robotDue);
      for (const stopping of [table, robots, seeing, asking, finding, picture, curve, player, why_it_did]) stopping.stop();
      removeEventListener("keydown", key);
    },
  };
}

async function fileTable(): Promise<RunFile[]> {
  const script = "/files.js";
  return ((await import(/* @vite-ignore */ script)) as { FILES: RunFile[] }).FILES;
}

/** How far radios reach; null where robots tell each other nothing by radio. */
function rangeOf(spec: RunSpec | null): number | null {
  return spec?.sharing?.mode === "radio" ? (spec.sharing.range_m ?? Infinity) : null;
}

function rowsOf(run: Run, spec: RunSpec, coverage: Coverage): [string, string][] {
  const rows: [string, string][] = (["p1", "p2", "p5", "p10"] as const).map((name) => [
    name,
    `${whole(coverage[name])} of ${whole(coverage.reachable)} squares, ${percent(coverage.fractions[name])}`,
  ]);
  if (run.result) {
    const { metrics, memory } = run.result;
    for (const [name, value] of Object.entries(metrics ?? {})) {
      if (typeof value === "number") rows.push([name, figure(value)]);
    }
    const most = spec.memory_budget_bytes === null ? `at most ${bytes(memory.plan.bytes)}` : bytes(spec.memory_budget_bytes);
    rows.push(["memory of a learner", `${bytes(memory.most_bytes)} of ${most}`]);
  }
  return rows;
}

function learnerRows(learnt: Learnt): [string, string][] {
  const rows: [string, string][] = [
    [learnt.table ? "states, actions" : "clusters of sensors, commands", `${whole(learnt.sensor_clusters)}, ${whole(learnt.actuator_clusters)}`],
  ];
  if (learnt.sensori_motor_clusters != null) rows.push(["sensori-motor clusters", whole(learnt.sensori_motor_clusters)]);
  if (learnt.fitness != null) rows.push(["fitness of the parent", figure(learnt.fitness)]);
  rows.push(["memory", `${bytes(learnt.bytes)} of ${learnt.budget_bytes != null ? `${bytes(learnt.budget_bytes)} (budget)` : `at most ${bytes(learnt.most_bytes)}`}`]);
  if (learnt.clusters_saturated > 0) rows.push(["vectors without room", whole(learnt.clusters_saturated)]);
  rows.push(["as of", learnt.is_live ? `step ${whole(learnt.arena_step)}` : `step ${whole(learnt.arena_step)}, when its state was last saved`]);
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
