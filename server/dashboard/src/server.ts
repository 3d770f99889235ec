// Asking the server: refusals as errors with their fields, a token where it wants one, and looks
// that repeat while the page is seen.

import { h } from "./dom";
import type { FieldError } from "./types";

/** A refusal of the server. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    message: string,
    readonly errors: FieldError[],
  ) {
    super(message);
  }
}

async function problem(response: Response): Promise<Problem> {
  const body: Record<string, unknown> = await response.json().catch(() => ({}));
  const text = body["detail"] ?? body["title"] ?? `the server answers ${response.status}`;
  const errors = Array.isArray(body["errors"]) ? (body["errors"] as FieldError[]) : [];
  return new Problem(response.status, String(body["code"] ?? ""), String(text), errors);
}

export async function ask(path: string, options: RequestInit = {}): Promise<Response> {
  for (;;) {
    const headers = new Headers(options.headers);
    const token = sessionStorage.getItem("token");
    if (token) headers.set("authorization", `Bearer ${token}`);
    const response = await fetch(path, { cache: "no-cache", ...options, headers });
    if (response.ok) return response;
    if (response.status !== 401) throw noted(await problem(response));
    if (token) sessionStorage.removeItem("token");
    await logIn(token !== null);
  }
}

export async function read<T>(path: string, signal?: AbortSignal): Promise<T> {
  const response = await ask(path, signal ? { signal } : {});
  return (await response.json()) as T;
}

export async function post<T>(path: string, body?: string): Promise<T> {
  const headers: Record<string, string> = body === undefined ? {} : { "content-type": "application/json" };
  const response = await ask(path, { method: "POST", headers, ...(body !== undefined && { body }) });
  return (response.status === 204 ? undefined : await response.json()) as T;
}

export async function remove(path: string): Promise<void> {
  await ask(path, { method: "DELETE" });
}

/** A token that only reads is not offered what it would be refused. */
function noted(refusal: Problem): Problem {
  if (refusal.code === "read-only-token") document.body.classList.add("read-only");
  return refusal;
}

let asking: Promise<void> | null = null;

/** Asks the person for the server's token, once however many requests wait for it. */
function logIn(isWrong: boolean): Promise<void> {
  asking ??= new Promise<void>((resolve) => {
    const token = h("input", {
      id: "token", type: "password", autocomplete: "current-password", required: true,
    });
    const dialog = h(
      "dialog",
      { "aria-labelledby": "login-title" },
      h(
        "form",
        { method: "dialog" },
        h("h2", { id: "login-title" }, "This server asks for a token"),
        isWrong && h("p", { class: "bad" }, "What was given is not a token of this server."),
        h("label", { for: "token" }, "Token"),
        token,
        h("button", {}, "Continue"),
      ),
    );
    dialog.addEventListener("close", () => {
      sessionStorage.setItem("token", token.value);
      document.body.classList.remove("read-only");
      dialog.remove();
      asking = null;
      resolve();
    });
    document.body.append(dialog);
    dialog.showModal();
  });
  return asking;
}

/** What a look that repeats tells of itself. */
export interface Watch {
  /** Looks at once. */
  now(): void;
  /** Ends it. */
  stop(): void;
}

/**
 * Looks again and again, `every_ms` after the last look ended, or as long as `rest` says; not while
 * the page is hidden. What goes wrong is told, and tried again with longer and longer rests.
 */
export function watch(
  every_ms: number,
  look: (signal: AbortSignal) => Promise<void>,
  trouble: (error: unknown) => void,
  rest: () => number = () => every_ms,
): Watch {
  const stopping = new AbortController();
  let timer = 0;
  let rest_ms = every_ms;
  let busy = false;
  let again = false;
  const next = async (): Promise<void> => {
    if (stopping.signal.aborted) return;
    if (busy) {
      again = true;
      return;
    }
    clearTimeout(timer);
    if (document.hidden) return;
    busy = true;
    try {
      await look(stopping.signal);
      rest_ms = rest();
    } catch (error) {
      if (!stopping.signal.aborted) trouble(error);
      rest_ms = Math.min(rest_ms * 2, 15_000);
    }
    busy = false;
    if (again) {
      again = false;
      return next();
    }
    if (!stopping.signal.aborted) timer = window.setTimeout(() => void next(), rest_ms);
  };
  document.addEventListener("visibilitychange", () => void next(), { signal: stopping.signal });
  void next();
  return {
    now: () => void next(),
    stop: () => {
      stopping.abort();
      clearTimeout(timer);
    },
  };
}
