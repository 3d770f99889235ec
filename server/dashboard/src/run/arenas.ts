// The arenas of a run, their walls written out: the one where visits count, and the one for training.

import { read } from "../server";
import type { Arena, RunSpec } from "../types";

export interface Arenas {
  target: Arena;
  training: Arena;
}

export async function arenasOf(run: string, spec: RunSpec, signal?: AbortSignal): Promise<Arenas> {
  const target = await read<Arena>(`/v1/runs/${run}/arena`, signal);
  const trains = spec.controller.train?.arena !== undefined;
  return { target, training: trains ? await read<Arena>(`/v1/runs/${run}/arena?of=training`, signal) : target };
}
