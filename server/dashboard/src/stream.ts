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
  /** Begins anew at once: what is asked for has changed. */
  again(): void;
}

export interface Reading {
  /** What is asked for, each time. */
  path(): string;
  headers?(): Record<string, string>;
  /** It has begun; gives what takes its parts. */
  begin(): (part: Uint8Array<ArrayBuffer>) => void;
  /** It has broken off or ended. */
  lost?(): void;
  /** Whether its end is for good. */
  isOver(): boolean;
  /** Told of what goes wrong; whether it is to be given up. */
  failed?(error: unknown): boolean;
}

/** Told on the page; what is not there, or not any more, is given up. */
function toldFailure(error: unknown): boolean {
  trouble(error);
  return error instanceof Problem && [404, 409].includes(error.status);
}

/** Reads something again and again, a part at a time, until that is over. */
export function stream({ path, headers, begin, lost, isOver, failed = toldFailure }: Reading): Stream {
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
  let isAgain = false;
  const run = async (): Promise<void> => {
    // Whoever makes it may still say what is asked for.
    await Promise.resolve();
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
        isAgain = false;
        const response = await ask(path(), { signal: controller.signal, headers: headers?.() ?? {} });
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
        if (stopped || document.hidden || isAgain) continue;
        if (failed(error)) break;
        rest_ms = Math.min(rest_ms * 2, LONGEST_REST_MS);
      } finally {
        clearTimeout(silence);
        lost?.();
      }
      if (!stopped) await rest(rest_ms);
    }
  };
  void run();
  return {
    again: () => {
      isAgain = true;
      reading?.abort();
      wake();
    },
    stop: () => {
      stopped = true;
      document.removeEventListener("visibilitychange", onVisibility);
      reading?.abort();
      wake();
    },
  };
}

/** Server-sent events; comes back with the id of the last one. */
export function events(reading: Omit<Reading, "headers" | "begin" | "isOver"> & { begun(): void }, hear: (name: string, data: unknown) => void): Stream {
  let last = "";
  return stream({
    ...reading,
    headers: () => (last ? { "last-event-id": last } : {}) as Record<string, string>,
    isOver: () => false,
    begin: () => {
      reading.begun();
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
  });
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
