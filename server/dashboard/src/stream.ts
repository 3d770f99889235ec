// Streams of the server, read as they come: they end while the page is hidden, are taken up again
// when they break off, and are given up for lost when nothing comes for too long. `EventSource` is
// not used, as it cannot send a token.

import { calm, trouble } from "./alert";
import { ask, Problem } from "./server";

/** The server gives a sign of life every 15 s. */
const SILENCE_MS = 40_000;
const FIRST_REST_MS = 500;
const LONGEST_REST_MS = 10_000;

export interface Stream {
  stop(): void;
}

/** Reads `path` again and again, a part at a time, until `part` says that it is over. */
export function stream(
  path: string,
  headers: () => Record<string, string>,
  begin: () => (part: Uint8Array<ArrayBuffer>) => void,
  isOver: () => boolean,
): Stream {
  let stopped = false;
  let reading: AbortController | null = null;
  let wake: () => void = () => undefined;
  const seen = (): Promise<void> => new Promise((resolve) => { wake = resolve; });
  const rest = (ms: number): Promise<void> =>
    new Promise((resolve) => {
      const timer = setTimeout(resolve, ms);
      wake = () => {
        clearTimeout(timer);
        resolve();
      };
    });
  const onVisibility = (): void => {
    if (document.hidden) reading?.abort();
    else wake();
  };
  document.addEventListener("visibilitychange", onVisibility);
  const run = async (): Promise<void> => {
    let rest_ms = FIRST_REST_MS;
    while (!stopped) {
      if (document.hidden) {
        await seen();
        continue;
      }
      const controller = new AbortController();
      reading = controller;
      let silence = 0;
      const alive = (): void => {
        clearTimeout(silence);
        silence = window.setTimeout(() => controller.abort(), SILENCE_MS);
      };
      try {
        const response = await ask(path, { signal: controller.signal, headers: headers() });
        const reader = response.body!.getReader();
        const part = begin();
        alive();
        for (;;) {
          const { value, done } = await reader.read();
          if (done) break;
          alive();
          calm();
          rest_ms = FIRST_REST_MS;
          part(value);
        }
        if (isOver()) break;
      } catch (error) {
        if (stopped || document.hidden) continue;
        if (error instanceof Problem && [404, 409].includes(error.status)) {
          trouble(error);
          break;
        }
        trouble(error);
        rest_ms = Math.min(rest_ms * 2, LONGEST_REST_MS);
      } finally {
        clearTimeout(silence);
      }
      if (!stopped) await rest(rest_ms);
    }
  };
  void run();
  return {
    stop: () => {
      stopped = true;
      document.removeEventListener("visibilitychange", onVisibility);
      reading?.abort();
      wake();
    },
  };
}

/** Server-sent events; comes back with the id of the last one. */
export function events(path: string, hear: (name: string, data: unknown) => void): Stream {
  let last = "";
  return stream(
    path,
    () => (last ? { "last-event-id": last } : {}) as Record<string, string>,
    () => {
      const decoder = new TextDecoder();
      let text = "";
      return (part) => {
        text += decoder.decode(part, { stream: true });
        const blocks = text.split("\n\n");
        text = blocks.pop() ?? "";
        for (const block of blocks) {
          const event = parseEvent(block);
          if (event.id) last = event.id;
          if (event.data) hear(event.name, JSON.parse(event.data));
        }
      };
    },
    () => false,
  );
}

/** One event of a stream. */
export function parseEvent(block: string): { name: string; id: string; data: string } {
  const event = { name: "message", id: "", data: "" };
  for (const line of block.split("\n")) {
    const [, field, value] = /^(\w+): ?(.*)$/.exec(line) ?? [];
    if (field === "event") event.name = value ?? "";
    else if (field === "id") event.id = value ?? "";
    else if (field === "data") event.data += value ?? "";
  }
  return event;
}
