// The shell: a bar, the list of jobs, and the screen that the address names.

import "./style.css";
import { jobList } from "./jobs/list";
import { overview } from "./jobs/overview";
import { jobScreen } from "./job/screen";
import { runScreen } from "./run/screen";
import { submitScreen } from "./submit/screen";
import { alert, calm, type Screen } from "./alert";
import { h, write } from "./dom";
import { link, parse } from "./route";

const rate = h("p", { class: "rate", "aria-live": "polite" });
const main = h("main", {});
const jobs = jobList((text) => write(rate, text));
const menu = h(
  "button",
  { type: "button", class: "menu", "aria-expanded": "false", "aria-controls": "jobs" },
  "Jobs",
);
menu.addEventListener("click", () => {
  const open = document.body.classList.toggle("list-open");
  menu.setAttribute("aria-expanded", String(open));
});

document.getElementById("app")?.append(
  h(
    "header",
    { class: "bar" },
    menu,
    h("h1", {}, h("a", { href: link("overview") }, "evswarm")),
    rate,
    h("span", { class: "badge only-read", title: "This token allows to read, not to change anything" }, "read only"),
    h("a", { class: "button primary", href: link("new") }, "New job"),
  ),
  alert,
  h("div", { class: "columns" }, jobs.element, main),
);

let screen: Screen | null = null;

/** Opens what the address names. What a screen itself changes of it does not come here. */
function go(): void {
  const route = parse(location.hash);
  jobs.choose(route.view === "job" ? route.id : "");
  screen?.stop();
  calm();
  const opened: Screen = {
    overview: () => overview(),
    job: () => jobScreen(route.id, route.options),
    run: () => runScreen(route.id, route.options),
    new: () => submitScreen(route.options),
  }[route.view]();
  screen = opened;
  document.title = `${opened.title} – evswarm`;
  main.replaceChildren(opened.element);
  document.body.classList.remove("list-open");
  menu.setAttribute("aria-expanded", "false");
  scrollTo(0, 0);
}

addEventListener("hashchange", go);
addEventListener("keydown", (event) => {
  const target = event.target as HTMLElement | null;
  if (target?.matches("input, textarea, select") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "/") {
    event.preventDefault();
    jobs.search();
  }
  // Up and down the runs of a screen, else the jobs.
  const step = { j: 1, k: -1 }[event.key];
  if (step === undefined) return;
  const links = [main.querySelectorAll<HTMLElement>("table.runs tbody a"), jobs.element.querySelectorAll<HTMLElement>("a.card")]
    .map((list) => [...list]);
  const list = links.find((one) => one.includes(document.activeElement as HTMLElement)) ?? links.find((one) => one.length > 0);
  const at = list?.indexOf(document.activeElement as HTMLElement) ?? -1;
  list?.[at < 0 ? 0 : at + step]?.focus();
});
go();
