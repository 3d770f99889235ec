// A new job: a form, the document as JSON and the drawing of its arena, three views of one thing.
// While it is written the server says what is wrong with it and what it would take.

import { trouble, type Screen } from "../alert";
import { h, show, write } from "../dom";
import { link } from "../route";
import { post, Problem, read } from "../server";
import type { Arena, ArenaListing, Controllers, FieldError, Job, JobCheck, Template } from "../types";
import { bytes, compact, duration, sentence, whole } from "../words";
import { valuesAt, withValues, type Json } from "./document";
import { arenaEditor } from "./editor";
import { jobForm } from "./form";

const CHECK_AFTER_MS = 500;
const FIRST: Json = {
  name: "three methods",
  base: { arena: "easy", epochs: 100 },
  matrix: { "controller.method": ["brownian", "im", "ev-iter-c"] },
  seeds: { first: 1, count: 10 },
};

export function submitScreen(options: URLSearchParams): Screen {
  const text = h("textarea", { id: "document", rows: 26, spellcheck: "false", "aria-describedby": "errors" });
  const errors = h("ul", { id: "errors", class: "plain bad" });
  const start = h("button", { type: "submit", class: "primary changes" }, "Start");
  const template = h("select", { id: "template" }, h("option", { value: "" }, "choose …"));
  const about = h("p", { class: "quiet" });
  const estimate = h("p", { class: "estimate", role: "status" });
  let job: Json = {};
  const named = new Map<string, Arena>();
  let names: ArenaListing[] = [];

  const fields = jobForm((next) => {
    job = next;
    writeText();
    showArena();
    check();
  });
  const editor = arenaEditor(
    (arena) => {
      job = withValues(job, "arena", [{ name: "drawn", ...arena }]);
      writeText();
      fields.show(job);
      check();
    },
    () => {
      const name = valuesAt(job, "arena")[0];
      const arena = typeof name === "string" ? named.get(name) : undefined;
      if (!arena) return;
      put(withValues(job, "arena", [{ ...arena, name: `${String(name)}-copy` }]));
    },
  );
  const form = h(
    "form",
    {},
    h("p", { class: "tools" }, h("label", { for: "template" }, "Start from"), template),
    about,
    h("div", { class: "halves" },
      h("div", {}, fields.element, editor.element),
      h("div", {}, h("label", { for: "document" }, "The job as JSON"), text)),
    h("div", { role: "alert" }, errors),
    estimate,
    h("p", {}, start),
  );
  const element = h("article", { class: "screen panel" }, h("h2", {}, "New job"), form);

  const writeText = (): void => {
    const next = JSON.stringify(job, null, 2);
    if (text.value !== next) text.value = next;
  };
  const put = (next: Json): void => {
    job = next;
    writeText();
    fields.show(job);
    showArena();
    check();
  };
  text.addEventListener("input", () => {
    try {
      const read = JSON.parse(text.value) as unknown;
      if (typeof read !== "object" || read === null || Array.isArray(read)) return;
      job = read as Json;
      fields.show(job);
      showArena();
      check();
    } catch (error) {
      write(estimate, "");
      tell([{ pointer: "", message: `not JSON yet: ${(error as Error).message}`, allowed: "" }]);
    }
  });
  function showArena(): void {
    const [value, ...others] = valuesAt(job, "arena");
    if (others.length > 0) return editor.show(null, false);
    const name = value === undefined ? "easy" : value;
    if (typeof name === "object" && name !== null && "width_m" in name && "starts" in name) {
      return editor.show(name as Arena, "walls_m" in name);
    }
    if (typeof name !== "string" || !names.some((one) => one.name === name)) return editor.show(null, false);
    const known = named.get(name);
    if (known) return editor.show(known, false);
    read<Arena>(`/v1/arenas/${encodeURIComponent(name)}`).then((arena) => {
      named.set(name, arena);
      showArena();
    }, trouble);
  }
  function tell(wrong: FieldError[]): void {
    const rest = fields.errors(wrong);
    // Those at a field stand there; the list has all of them with their pointers.
    errors.replaceChildren(...wrong.map((one) =>
      h("li", {}, h("code", {}, one.pointer || "(document)"), ` ${one.message}`, one.allowed ? h("span", { class: "quiet" }, ` allowed: ${one.allowed}`) : null)));
    if (wrong.length) text.setAttribute("aria-invalid", "true");
    else text.removeAttribute("aria-invalid");
    show(errors, wrong.length > 0);
    if (rest.length) select(text, rest[0]?.pointer ?? "");
  }
  let timer = 0;
  let asked = 0;
  function check(): void {
    clearTimeout(timer);
    const number = ++asked;
    timer = window.setTimeout(() => {
      post<JobCheck>("/v1/checks/job", JSON.stringify(job)).then(
        (found) => {
          if (number !== asked) return;
          tell([]);
          const time = `about ${duration(found.time_s)} on ${whole(found.workers)} ${found.workers === 1 ? "thread" : "threads"}`;
          write(
            estimate,
            sentence(
              `${whole(found.runs)} ${found.runs === 1 ? "run" : "runs"}`,
              found.combinations > 1 && `${whole(found.combinations)} groups`,
              `${compact(found.robot_steps)} robot-steps`,
              `${time} ${found.is_measured ? "(as such runs took here)" : "(assumed: none was timed here yet)"}`,
              `at most ${bytes(found.learner_bytes)} a learner, about ${bytes(found.run_bytes)} a run`,
            ),
          );
        },
        (error) => {
          if (number !== asked) return;
          write(estimate, "");
          if (error instanceof Problem && error.errors.length) tell(error.errors);
          else trouble(error);
        },
      );
    }, CHECK_AFTER_MS);
  }
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    start.disabled = true;
    clearTimeout(timer);
    asked += 1;
    post<Job>("/v1/jobs", text.value).then(
      (made) => { location.hash = link("job", made.id); },
      (error) => {
        start.disabled = false;
        if (!(error instanceof Problem)) return trouble(error);
        tell(error.errors.length ? error.errors : [{ pointer: "", message: error.message, allowed: "" }]);
      },
    );
  });

  const templates = new Map<string, Template>();
  read<{ items: Template[] }>("/v1/templates").then(({ items }) => {
    for (const item of items) {
      templates.set(item.name, item);
      template.append(h("option", { value: item.name }, `${item.name} (${whole(item.runs)} runs)`));
    }
  }, trouble);
  template.addEventListener("change", () => {
    const chosen = templates.get(template.value);
    if (!chosen) return;
    write(about, chosen.about);
    put({ name: chosen.name, ...(chosen.job as Json) });
  });
  Promise.all([read<Controllers>("/v1/controllers"), read<{ items: ArenaListing[] }>("/v1/arenas")]).then(([controllers, { items }]) => {
    names = items;
    fields.offer(controllers, items);
    fields.show(job);
    showArena();
  }, trouble);
  put(FIRST);
  const from = options.get("from");
  if (from) {
    read<Json>(`/v1/jobs/${from}/document`).then(put, (error) => {
      if (error instanceof Problem && error.status === 409) write(about, "This job's document is not kept.");
      else trouble(error);
    });
  }
  return {
    element,
    title: "New job",
    stop: () => {
      clearTimeout(timer);
      asked += 1;
      editor.stop();
    },
  };
}

/** Selects, in the text of a document, the field that a JSON pointer ends with. */
function select(text: HTMLTextAreaElement, pointer: string): void {
  const name = pointer.split("/").at(-1);
  if (!name || document.activeElement === text) return;
  const at = text.value.indexOf(`"${name}"`);
  if (at >= 0) text.setSelectionRange(at, at + name.length + 2);
}
