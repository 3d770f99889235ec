// Another run of the job beside the one that is replayed: the same stretch of it, recorded where it
// is not yet, shown in step.

import { trouble } from "../alert";
import { h, show, write } from "../dom";
import { post, read } from "../server";
import type { RecordingSummary, Run, RunSpec } from "../types";
import { percent, sentence } from "../words";
import { arenasOf, type Arenas } from "./arenas";
import { reachOf } from "./explain";
import { watchFrames } from "./frames";
import { countedSteps, Player, type Head } from "./player";
import { FIELDS } from "./recorder";
import { scene, type Scene } from "./scene";

const LOOK_EVERY_MS = 500;

export interface Beside {
  element: HTMLElement;
  scene: Scene;
  /** Shows the stretch of a recording of another run; nothing for an empty id. */
  choose(run: string, head: Head | null): Promise<void>;
  /** Draws a step, where it has been read; whether it could. */
  frame(step: number): boolean;
  load(step: number): Promise<void>;
  stop(): void;
}

export function beside(): Beside {
  const about = h("p", { class: "facts", role: "status" });
  const picture = scene(() => undefined);
  const element = h("div", { class: "beside", hidden: true });
  let player: Player | null = null;
  let arenas: Arenas | null = null;
  let chosen = "";
  let squares: { stop(): void } | null = null;

  const frame = (step: number): boolean => {
    if (!player || !arenas) return true;
    const next = player.frameAt(step);
    if (!next) return false;
    picture.arena(next.isTraining ? arenas.training : arenas.target, player.recording!.body_radius_m, null);
    picture.until(countedSteps(player.recording!, step));
    picture.frame(next);
    return true;
  };
  const choose: Beside["choose"] = async (id, head) => {
    chosen = id;
    player = null;
    squares?.stop();
    squares = null;
    if (id) element.replaceChildren(about, picture.element);
    else element.replaceChildren();
    show(element, id !== "");
    if (!id || !head) return;
    write(about, "");
    const { from_epoch, epochs, every_steps } = head;
    const [spec, run, made] = await Promise.all([
      read<RunSpec>(`/v1/runs/${id}/spec`), read<Run>(`/v1/runs/${id}`),
      post<RecordingSummary>(`/v1/runs/${id}/recordings`, JSON.stringify({ from_epoch, epochs, every_steps, fields: FIELDS })),
    ]);
    const title = sentence(run.label || run.method, run.arena, `seed ${run.seed}`);
    let state: RecordingSummary | undefined = made;
    while (state && ["queued", "recording"].includes(state.state)) {
      write(about, sentence(title, `its stretch is being recorded${state.progress != null ? `, ${percent(state.progress)}` : ""}`));
      await new Promise((resolve) => setTimeout(resolve, LOOK_EVERY_MS));
      if (chosen !== id) return;
      const { items } = await read<{ items: RecordingSummary[] }>(`/v1/runs/${id}/recordings`);
      state = items.find((one) => one.name === made.name);
    }
    const [found, reach] = await Promise.all([arenasOf(id, spec), reachOf(id)]);
    const next = new Player(id, made.name, trouble);
    await next.open();
    if (chosen !== id) return;
    write(about, title);
    arenas = found;
    picture.reach(reach);
    player = next;
    let isSeen = false;
    squares = watchFrames(id, {
      frame: () => undefined,
      squares: (covered) => {
        isSeen = true;
        picture.squares(covered);
        squares?.stop();
      },
      waiting: () => undefined,
      isOver: () => isSeen,
    });
  };
  return {
    element,
    scene: picture,
    choose,
    frame,
    load: async (step) => {
      await player?.load(step);
      frame(step);
    },
    stop: () => {
      chosen = "";
      squares?.stop();
      picture.stop();
    },
  };
}
