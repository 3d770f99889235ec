// A new job: JSON, started from a template or another job, with errors beside the text.

import { h, show, write } from "../dom";
import { link } from "../route";
import { post, Problem, read } from "../server";
import type { Controllers, Job, Template } from "../types";
import { trouble, type Screen } from "../main";
import { whole } from "../words";

const FIRST = {
  name: "three methods",
  base: { arena: "easy", epochs: 100 },
  matrix: { "controller.method": ["brownian", "im", "ev-iter-c"] },
  seeds: { first: 1, count: 5 },
};

export function submitScreen(options: URLSearchParams): Screen {
  const text = h("textarea", { id: "document", rows: 22, spellcheck: "false", "aria-describedby": "errors" });
  const errors = h("ul", { id: "errors", class: "plain bad" });
  const start = h("button", { type: "submit", class: "primary" }, "Start");
  const template = h("select", { id: "template" }, h("option", { value: "" }, "choose …"));
  const about = h("p", { class: "quiet" });
  const size = h("p", { class: "facts", "aria-live": "polite" });
  const parameters = h("tbody", {});
  const form = h(
    "form",
    {},
    h("p", {}, h("label", { for: "template" }, "Start from "), template),
    about,
    h("label", { for: "document" }, "The job as JSON"),
    text, size,
    h("div", { role: "alert" }, errors),
    h("p", {}, start),
  );
  const element = h(
    "article",
    { class: "screen panel" },
    h("h2", {}, "New job"),
    form,
    h(
      "details",
      {},
      h("summary", {}, "Parameters of methods: defaults, ranges, units"),
      h("div", { class: "scroll", tabindex: 0 }, h("table", {},
        h("thead", {}, h("tr", {}, ...["controller.", "default", "allowed", "unit", "what it does"].map((name) => h("th", { scope: "col" }, name)))),
        parameters)),
    ),
  );
  const put = (document: unknown): void => {
    text.value = JSON.stringify(document, null, 2);
    count();
  };
  const count = (): void => {
    const runs = runCount(text.value);
    write(size, runs === null ? "" : `${whole(runs)} ${runs === 1 ? "run" : "runs"}`);
  };
  text.addEventListener("input", count);
  put(FIRST);

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
    put({ name: chosen.name, ...chosen.job });
  });
  const from = options.get("from");
  if (from) {
    read<Record<string, unknown>>(`/v1/jobs/${from}/document`).then(
      (document) => put(document),
      (error) => {
        if (error instanceof Problem && error.status === 404) write(about, "This job's document is not kept.");
        else trouble(error);
      },
    );
  }
  read<Controllers>("/v1/controllers").then((controllers) => {
    parameters.replaceChildren(
      ...controllers.parameters.map((parameter) =>
        h("tr", {},
          h("th", { scope: "row" }, parameter.name),
          h("td", {}, String(parameter.default)),
          h("td", {}, parameter.domain.names?.join(", ") ?? `${parameter.domain.min} to ${parameter.domain.max}`),
          h("td", {}, parameter.unit),
          h("td", {}, `${parameter.about} (${parameter.source})`))),
    );
  }, trouble);

  form.addEventListener("submit", (event) => {
    event.preventDefault();
    start.disabled = true;
    errors.replaceChildren();
    post<Job>("/v1/jobs", text.value).then(
      (job) => { location.hash = link("job", job.id); },
      (error) => {
        start.disabled = false;
        if (!(error instanceof Problem)) return trouble(error);
        const fields = error.errors.length
          ? error.errors.map((one) => h("li", {}, h("code", {}, one.pointer || "(document)"), ` ${one.message}`, one.allowed ? h("span", { class: "quiet" }, ` allowed: ${one.allowed}`) : null))
          : [h("li", {}, error.message)];
        errors.replaceChildren(...fields);
        text.setAttribute("aria-invalid", "true");
        select(text, error.errors[0]?.pointer ?? "");
      },
    );
  });
  show(errors, true);
  return { element, title: "New job", stop: () => undefined };
}

/** Runs of a job, by its matrix and seeds; null where the text is no such document. */
export function runCount(text: string): number | null {
  try {
    const job = JSON.parse(text) as Record<string, unknown>;
    if (job["parts"] || job["template"]) return null;
    const matrix = (job["matrix"] ?? {}) as Record<string, unknown[]>;
    const combinations = Object.values(matrix).reduce((product, values) => product * values.length, 1);
    const seeds = job["seeds"] as { count?: number } | number[] | undefined;
    const repeats = Array.isArray(seeds) ? seeds.length : (seeds?.count ?? 1);
    return Number.isFinite(combinations * repeats) ? combinations * repeats : null;
  } catch {
    return null;
  }
}

/** Selects, in the text of a document, the field that a JSON pointer ends with. */
function select(text: HTMLTextAreaElement, pointer: string): void {
  const name = pointer.split("/").at(-1);
  if (!name) return;
  const at = text.value.indexOf(`"${name}"`);
  if (at < 0) return;
  text.focus();
  text.setSelectionRange(at, at + name.length + 2);
}
