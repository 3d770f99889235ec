// Going on from a run: the same with more epochs, or from its newest kept state with other
// parameters; both make a job of one run and leave this one as it is.

import { h, show, write } from "../dom";
import { link } from "../route";
import { post, Problem } from "../server";
import type { Job, Run } from "../types";
import { whole } from "../words";

/** What a fork may change of a table's decisions, as the server takes it. */
const CHANGES = ["alpha", "eta", "lambda_total", "insufficiency", "ties", "action_hold_steps"];

export interface ForkDialog {
  button: HTMLButtonElement;
  run(run: Run): void;
}

export function forkDialog(id: string): ForkDialog {
  const button = h("button", { type: "button", class: "changes", hidden: true }, "Go on from here");
  let run: Run | null = null;
  button.addEventListener("click", () => { if (run) open(id, run); });
  return {
    button,
    run: (next) => {
      run = next;
      show(button, !["queued", "failed", "cancelled"].includes(next.state));
    },
  };
}

function open(id: string, run: Run): void {
  const kind = (value: string, text: string, checked: boolean): HTMLElement =>
    h("label", {}, h("input", { type: "radio", name: "fork-kind", value, checked }), ` ${text}`);
  const epochs = h("input", { id: "fork-epochs", type: "number", min: 1, step: 1 });
  const name = h("select", { id: "fork-field" }, h("option", { value: "" }, "nothing"), ...CHANGES.map((one) => h("option", { value: `controller.${one}` }, one)));
  const value = h("input", { id: "fork-value", size: 10 });
  const label = h("label", { for: "fork-epochs" });
  const change = h("p", { class: "tools" }, h("label", { for: "fork-field" }, "Change"), name, h("label", { for: "fork-value" }, "to"), value);
  const says = h("p", { class: "quiet" });
  const wrong = h("p", { class: "bad", role: "alert", hidden: true });
  const make = h("button", { type: "submit", class: "primary" }, "Make the job");
  const leave = h("button", { type: "button" }, "Leave it");
  const total = run.progress?.epochs_total ?? 0;
  const form = h("form", { method: "dialog" },
    h("h2", { id: "fork-title" }, "Go on from this run"),
    h("p", { class: "tools" }, kind("extend", "more epochs", true), kind("fork", "fork: from its newest kept state, with changes", false)),
    h("p", { class: "tools" }, label, epochs), change, says, wrong,
    h("p", { class: "tools" }, make, leave));
  const dialog = h("dialog", { "aria-labelledby": "fork-title" }, form);
  const isFork = (): boolean => form.querySelector<HTMLInputElement>("input[value=fork]")!.checked;
  const tell = (): void => {
    show(change, isFork());
    write(label, isFork() ? "Epochs in all" : "Epochs more");
    epochs.value = String(isFork() ? total : Math.max(total, 1));
    write(says, isFork()
      ? `A new job of one run goes on from the newest state of this one that is kept, with these changes; what was found till then is part of what it finds. This run of ${whole(total)} epochs stays as it is. The job can be cancelled and deleted.`
      : `A new job of one run: this one with so many more epochs than its ${whole(total)}, to the last bit as if it had been simulated whole. This run stays as it is. The job can be cancelled and deleted.`);
  };
  form.addEventListener("change", (event) => {
    if ((event.target as HTMLInputElement).name === "fork-kind") tell();
  });
  leave.addEventListener("click", () => dialog.close());
  dialog.addEventListener("close", () => dialog.remove());
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    make.disabled = true;
    const changes: Record<string, unknown> = Number(epochs.value) === total ? {} : { epochs: Number(epochs.value) };
    if (name.value) changes[name.value] = value.value.trim() !== "" && Number.isFinite(Number(value.value)) ? Number(value.value) : value.value.trim();
    const body = isFork() ? { changes } : { epochs: Number(epochs.value) };
    post<Job>(`/v1/runs/${id}/${isFork() ? "fork" : "extend"}`, JSON.stringify(body)).then(
      (job) => {
        dialog.close();
        location.hash = link("job", job.id);
      },
      (error: unknown) => {
        make.disabled = false;
        const fields = error instanceof Problem ? error.errors.map((one) => `${one.pointer} ${one.message}${one.allowed ? ` (allowed: ${one.allowed})` : ""}`) : [];
        write(wrong, fields.length > 0 ? fields.join("; ") : (error as Error).message);
        show(wrong, true);
      },
    );
  });
  tell();
  document.body.append(dialog);
  dialog.showModal();
}
