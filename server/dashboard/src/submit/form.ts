// The form of a job: methods, arena, sizes, seeds and parameters, each with default, range and unit.

import { h, show, write } from "../dom";
import type { ArenaListing, Controllers, Parameter } from "../types";
import { fieldOf, parseValues, pathOf, valuesAt, withValues, type Json } from "./document";
import type { FieldError } from "../types";

export interface JobForm {
  element: HTMLElement;
  /** Shows a document. */
  show(job: Json): void;
  /** Shows errors at their fields; returns those that have none here. */
  errors(errors: FieldError[]): FieldError[];
  /** What can be chosen. */
  offer(controllers: Controllers, arenas: ArenaListing[]): void;
}

/** Fields with one text each: dotted path, name, hint, unit. */
const FIELDS: [string, string, string][] = [
  ["epochs", "Epochs", "counted epochs; several values, separated by commas, are compared"],
  ["steps_per_epoch", "Steps an epoch", "default 2000; a step is 0.064 s"],
  ["robots", "Robots", "default 1; more need the placement grid or random, or an arena with as many starts"],
  ["memory_budget_bytes", "Memory budget", "bytes for each robot's learner, e-puck or e-puck2; empty for none"],
];
const CHOICES: [string, string, string[]][] = [
  ["placement", "Placement", ["start", "grid", "random"]],
  ["episodes", "Episodes", ["reset", "continue"]],
  ["engine", "Engine", ["kinematic", "rapier"]],
];
const OWN = "(drawn below)";

export function jobForm(onChange: (job: Json) => void): JobForm {
  let job: Json = {};
  let controllers: Controllers | null = null;
  const controls = new Map<string, HTMLElement>();
  const told = new Map<string, HTMLElement>();
  let number = 0;
  const field = (path: string, title: string, control: HTMLElement, hint = ""): HTMLElement => {
    const id = `field-${number++}`;
    control.id = id;
    const error = h("span", { class: "bad", id: `${id}-error`, hidden: true });
    control.setAttribute("aria-describedby", `${id}-error ${id}-hint`);
    controls.set(path, control);
    told.set(path, error);
    return h("div", { class: "field" },
      h("label", { for: id }, title), control,
      h("span", { class: "hint quiet", id: `${id}-hint` }, hint), error);
  };
  const change = (next: Json): void => {
    job = next;
    onChange(next);
  };
  const set = (path: string, values: unknown[]): void => change(withValues(job, path, values));

  const name = h("input", { type: "text", maxlength: 200 });
  name.addEventListener("input", () => change({ ...job, name: name.value }));
  const arena = h("select", {});
  arena.addEventListener("change", () => set("arena", arena.value === OWN ? [] : [arena.value]));
  const methods = h("select", { multiple: true, size: 6 });
  methods.addEventListener("change", () => set("controller.method", [...methods.selectedOptions].map((one) => one.value)));
  const train = h("select", {});
  train.addEventListener("change", () => set("controller.train.arena", train.value ? [train.value] : []));
  const trainEpochs = h("input", { inputmode: "numeric" });
  trainEpochs.addEventListener("input", () => set("controller.train.epochs", parseValues(trainEpochs.value)));
  const aboutMethod = h("p", { class: "quiet facts" });
  const texts = FIELDS.map(([path, title, hint]) => {
    const input = h("input", { inputmode: path === "memory_budget_bytes" ? "text" : "numeric" });
    input.addEventListener("input", () => set(path, parseValues(input.value)));
    return field(path, title, input, hint);
  });
  const choices = CHOICES.map(([path, title, values]) => {
    const select = h("select", {}, ...values.map((value, place) => h("option", { value }, place === 0 ? `${value} (default)` : value)));
    select.addEventListener("change", () => set(path, select.value === values[0] ? [] : [select.value]));
    return field(path, title, select);
  });
  const first = h("input", { inputmode: "numeric" });
  const count = h("input", { inputmode: "numeric" });
  const seeds = (): void => change({ ...job, seeds: { first: Number(first.value) || 1, count: Number(count.value) || 1 } });
  first.addEventListener("input", seeds);
  count.addEventListener("input", seeds);

  const parameters = h("div", { class: "fields" });
  const add = h("select", { id: "add-parameter" });
  add.addEventListener("change", () => {
    const parameter = known(add.value);
    add.value = "";
    if (parameter) {
      set(parameter.path, [parameter.parameter.default]);
      showParameters();
      controls.get(parameter.path)?.focus();
    }
  });
  const all = (): { path: string; parameter: Parameter }[] => {
    if (!controllers) return [];
    const chosen = valuesAt(job, "controller.method");
    const own = controllers.methods.filter((method) => chosen.includes(method.name)).flatMap((method) => method.parameters ?? []);
    return [
      ...[...controllers.parameters, ...own].map((parameter) => ({ path: `controller.${parameter.name}`, parameter })),
      ...controllers.robot_parameters.map((parameter) => ({ path: `robot.${parameter.name}`, parameter })),
    ];
  };
  const known = (path: string) => all().find((one) => one.path === path);
  const range = ({ domain, unit, default: initial }: Parameter): string =>
    `${domain.names ? domain.names.join(", ") : `${domain.min} to ${domain.max}`}${unit && unit !== "1" ? ` ${unit}` : ""}, default ${initial}`;
  const shownParameters = new Map<string, HTMLElement>();
  function showParameters(): void {
    for (const { path, parameter } of all()) {
      const values = valuesAt(job, path);
      const there = shownParameters.get(path);
      if (values.length === 0) {
        if (there && !there.contains(document.activeElement)) {
          there.remove();
          shownParameters.delete(path);
          controls.delete(path);
          told.delete(path);
        }
      } else if (!there) {
        const input = h("input", {});
        input.addEventListener("input", () => set(path, parseValues(input.value)));
        const drop = h("button", { type: "button", "aria-label": `Leave ${parameter.name} at its default` }, "×");
        const made = field(path, parameter.name, input, `${parameter.about}; ${range(parameter)}`);
        drop.addEventListener("click", () => {
          add.focus();
          set(path, []);
          showParameters();
        });
        made.append(drop);
        shownParameters.set(path, made);
        parameters.append(made);
      }
    }
  }

  const element = h(
    "div",
    { class: "form" },
    h("div", { class: "fields" },
      field("name", "Name", name),
      field("controller.method", "Methods", methods, "choose several to compare them"),
      field("arena", "Arena", arena, "where visits count"),
      field("controller.train.arena", "Train in", train, "for methods that train first"),
      field("controller.train.epochs", "Training epochs", trainEpochs, "for methods that train first"),
      ...texts, ...choices,
      field("seeds.first", "First seed", first),
      field("seeds.count", "Seeds", count, "runs of each combination; 10 or more tell differences apart")),
    aboutMethod,
    h("h3", {}, "Parameters that differ from their defaults"),
    h("p", { class: "tools" }, h("label", { for: "add-parameter" }, "Add"), add),
    parameters,
  );
  const text = (values: unknown[]): string =>
    values.map((value) => (typeof value === "object" && value !== null ? JSON.stringify(value) : String(value))).join(", ");
  return {
    element,
    offer: (offered, arenas) => {
      controllers = offered;
      methods.replaceChildren(...offered.methods.map((method) => h("option", { value: method.name }, method.name)));
      const names = arenas.map((one) => h("option", { value: one.name }, `${one.name} (${one.width_m} m x ${one.height_m} m)`));
      arena.replaceChildren(...names, h("option", { value: OWN }, OWN));
      train.replaceChildren(h("option", { value: "" }, "the same arena"), ...names.map((option) => option.cloneNode(true) as HTMLElement));
      add.replaceChildren(h("option", { value: "" }, "choose …"), ...all().map(({ path, parameter }) =>
        h("option", { value: path }, `${path}: ${parameter.about.slice(0, 70)}`)));
    },
    show: (next) => {
      job = next;
      const keep = document.activeElement;
      const put = (control: HTMLInputElement | HTMLSelectElement, value: string): void => {
        if (control !== keep && control.value !== value) control.value = value;
      };
      put(name, String(job["name"] ?? ""));
      const arenaValue = valuesAt(job, "arena")[0];
      put(arena, typeof arenaValue === "string" ? arenaValue : arenaValue === undefined ? "easy" : OWN);
      const chosen = valuesAt(job, "controller.method").map(String);
      for (const option of methods.options) option.selected = chosen.includes(option.value);
      const trained = valuesAt(job, "controller.train.arena")[0];
      put(train, typeof trained === "string" ? trained : "");
      put(trainEpochs, text(valuesAt(job, "controller.train.epochs")));
      for (const [path] of FIELDS) put(controls.get(path) as HTMLInputElement, text(valuesAt(job, path)));
      for (const [path, , values] of CHOICES) {
        const value = valuesAt(job, path)[0];
        put(controls.get(path) as HTMLSelectElement, typeof value === "string" ? value : values[0]!);
      }
      const given = job["seeds"] as { first?: number; count?: number } | undefined;
      put(first, String(given?.first ?? 1));
      put(count, String(given?.count ?? 1));
      showParameters();
      for (const [path] of shownParameters) put(controls.get(path) as HTMLInputElement, text(valuesAt(job, path)));
      write(aboutMethod, (controllers?.methods ?? []).filter((method) => chosen.includes(method.name)).map((method) => `${method.name}: ${method.about}`).join(". "));
    },
    errors: (errors) => {
      const rest: FieldError[] = [];
      const messages = new Map<string, string>();
      for (const error of errors) {
        const path = fieldOf(pathOf(error.pointer), [...controls.keys()]);
        if (path === null) rest.push(error);
        else messages.set(path, `${error.message}${error.allowed ? `; allowed: ${error.allowed}` : ""}`);
      }
      for (const [path, error] of told) {
        const message = messages.get(path);
        show(error, message !== undefined);
        write(error, message ?? "");
        if (message) controls.get(path)?.setAttribute("aria-invalid", "true");
        else controls.get(path)?.removeAttribute("aria-invalid");
      }
      return rest;
    },
  };
}
