// The page: jobs on the left, the chosen job's curves and coverage on the right. Everything is
// asked for again every second or two; elements stay and only what changed in them is written.
import { drawChart } from "/chart.js";
import { FILES } from "/files.js";

const POLL_MS = 1500;
const RUNS_A_PAGE = 24;
const CURVE_POINTS = 240;

const FIRST_JOB = {
  name: "first job",
  base: {
    arena: "maze",
    controller: { method: "ev-iter-c", train: { arena: "easy", epochs: 20 } },
    epochs: 20,
  },
  matrix: { "controller.alpha": [0.5, 0.7] },
  seeds: { first: 1, count: 3 },
};

const $ = (id) => document.getElementById(id);
const state = { job: null, limit: 50, from: [0], next: null, curves: new Map(), wake: () => {} };

// ---- asking the server

class Problem extends Error {
  constructor(status, body) {
    super(body?.detail ?? body?.title ?? `the server answers ${status}`);
    this.status = status;
    this.errors = body?.errors ?? [];
  }
}

async function ask(path, options = {}) {
  const token = sessionStorage.getItem("token");
  const headers = { ...options.headers, ...(token && { Authorization: `Bearer ${token}` }) };
  const response = await fetch(path, { cache: "no-cache", ...options, headers });
  if (response.ok) return response;
  if (response.status === 401) {
    await logIn();
    return ask(path, options);
  }
  throw new Problem(response.status, await response.json().catch(() => null));
}

const json = async (path, options) => (await ask(path, options)).json();

function logIn() {
  const dialog = $("login");
  $("token").value = "";
  if (!dialog.open) dialog.showModal();
  return new Promise((resolve) => dialog.addEventListener("close", () => {
    sessionStorage.setItem("token", $("token").value);
    resolve();
  }, { once: true }));
}

function complain(error) {
  const reached = error instanceof Problem;
  $("alert").textContent = reached ? error.message : `The server cannot be reached (${error.message}). Trying again.`;
  $("alert").hidden = false;
}

// ---- words and small pieces

const whole = new Intl.NumberFormat("en");
const compact = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 3 });
const percent = new Intl.NumberFormat("en", { style: "percent", maximumFractionDigits: 1 });

function duration(seconds) {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  if (seconds < 172800) return `${(seconds / 3600).toFixed(1)} h`;
  return `${(seconds / 86400).toFixed(1)} days`;
}

const pace = (what) => [
  what.robot_steps_per_s ? `${compact.format(what.robot_steps_per_s)} robot-steps/s` : null,
  what.eta_s === null || what.eta_s === undefined ? null : `${duration(what.eta_s)} left`,
];

const sentence = (parts) => parts.filter(Boolean).join(" · ");

function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function badge(element, name) {
  write(element, name);
  element.dataset.state = name;
}

function make(tag, properties = {}, children = []) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

// Keeps one child for each item, in order; new ones are made, gone ones removed.
function reconcile(parent, items, create, update) {
  const old = new Map([...parent.children].map((child) => [child.dataset.key, child]));
  items.forEach((item, place) => {
    let child = old.get(item.id);
    if (child) old.delete(item.id);
    else {
      child = create(item);
      child.dataset.key = item.id;
    }
    update(child, item);
    if (parent.children[place] !== child) parent.insertBefore(child, parent.children[place] ?? null);
  });
  old.forEach((child) => child.remove());
}

const title = (job) => job.name || `Job ${job.id}`;

// ---- jobs

function jobCard(job) {
  const button = make("button", { type: "button", className: "job-card" }, [
    make("span", { className: "title" }, [make("span"), make("span", { className: "badge" })]),
    make("progress", { max: 1 }),
    make("span", { className: "facts" }),
  ]);
  button.addEventListener("click", () => { location.hash = `job=${job.id}`; });
  return make("li", {}, [button]);
}

function updateJobCard(item, job) {
  const button = item.firstElementChild;
  const [name, mark] = button.querySelectorAll(".title span");
  write(name, title(job));
  badge(mark, job.state);
  button.setAttribute("aria-current", String(job.id === state.job));
  const bar = button.querySelector("progress");
  bar.value = job.progress;
  bar.setAttribute("aria-label", `Progress of ${title(job)}`);
  write(button.querySelector(".facts"), sentence([
    percent.format(job.progress), `${job.runs.done} of ${job.runs.total} runs`, ...pace(job),
  ]));
}

async function showJobs() {
  const jobs = [];
  let next = null;
  do {
    const cursor = next === null ? "" : `&cursor=${next}`;
    const page = await json(`/v1/jobs?limit=${Math.min(50, state.limit - jobs.length)}${cursor}`);
    jobs.push(...page.items);
    next = page.next;
  } while (next !== null && jobs.length < state.limit);
  reconcile($("jobs"), jobs, jobCard, updateJobCard);
  $("older").hidden = next === null;
  $("welcome").hidden = jobs.length > 0;
  const running = jobs.reduce((sum, job) => sum + job.runs.running, 0);
  const queued = jobs.reduce((sum, job) => sum + (job.state === "cancelled" ? 0 : job.runs.queued), 0);
  const speed = jobs.reduce((sum, job) => sum + (job.robot_steps_per_s ?? 0), 0);
  write($("summary"), running
    ? sentence([`${running} ${running === 1 ? "run" : "runs"} running`, `${whole.format(queued)} waiting`, pace({ robot_steps_per_s: speed })[0]])
    : "Idle");
  if (state.job === null && jobs.length > 0) choose(jobs[0].id);
}

// ---- the chosen job

function choose(id) {
  if (state.job === id) return;
  Object.assign(state, { job: id, from: [0], next: null, curves: new Map() });
  $("runs").replaceChildren();
}

async function showJob() {
  if (state.job === null) {
    $("job").hidden = true;
    return;
  }
  const chosen = state.job;
  const [job, page] = await Promise.all([
    json(`/v1/jobs/${chosen}`),
    json(`/v1/jobs/${chosen}/runs?limit=${RUNS_A_PAGE}&cursor=${state.from.at(-1)}`),
  ]);
  if (chosen !== state.job) return;
  const ended = ["done", "failed", "cancelled"].includes(job.state);
  $("job").hidden = false;
  write($("job-title"), title(job));
  badge($("job-state"), job.state);
  $("job-progress").value = job.progress;
  const counts = ["running", "queued", "paused", "failed", "cancelled"]
    .filter((name) => job.runs[name]).map((name) => `${job.runs[name]} ${name}`);
  write($("job-facts"), sentence([
    `Job ${job.id}`, new Date(job.created_at).toLocaleString(), percent.format(job.progress),
    `${job.runs.done} of ${job.runs.total} runs done`, ...counts, ...pace(job),
  ]));
  $("pause").hidden = ended || job.state === "paused";
  $("resume").hidden = job.state !== "paused";
  $("cancel").hidden = ended;
  state.next = page.next;
  $("previous").disabled = state.from.length === 1;
  $("next").disabled = page.next === null;
  reconcile($("runs"), page.items, runCard, updateRunCard);
  const curves = await Promise.all(page.items.map(curve));
  if (chosen !== state.job) return;
  drawChart($("chart"), page.items.map((run, place) => ({
    group: run.label || `${run.arena} · ${run.method}`, epochs: run.progress?.epochs_total ?? 0, rows: curves[place],
  })));
  await Promise.all([...$("runs").children].map(refreshPicture));
}

// The curve of a run; one that cannot grow any more is asked for once.
async function curve(run) {
  const known = state.curves.get(run.id);
  const stamp = `${run.state} ${run.progress?.epochs_done ?? 0}`;
  if (known?.stamp === stamp) return known.rows;
  if (!run.progress) return [];
  const rows = await json(`/v1/runs/${run.id}/curve?points=${CURVE_POINTS}`).catch((error) => {
    if (error.status === 409) return [];
    throw error;
  });
  state.curves.set(run.id, { stamp, rows });
  return rows;
}

function runCard(run) {
  const open = make("button", { type: "button", className: "open" }, [make("img", { alt: "" })]);
  const file = ({ route }) => make("a", { className: "file", href: `/v1/runs/${run.id}/${route}`, textContent: route });
  const cancel = make("button", { type: "button", textContent: "Cancel" });
  const card = make("li", { className: "run-card" }, [
    make("div", { className: "title" }, [make("strong"), make("span", { className: "badge" })]),
    open,
    make("progress", { max: 1 }),
    make("p", { className: "facts" }),
    make("p", { className: "error", hidden: true }),
    make("div", { className: "files" }, [
      ...FILES.map(file), cancel,
    ]),
  ]);
  open.addEventListener("click", () => {
    const picture = $("picture");
    $("picture-title").textContent = open.getAttribute("aria-label");
    picture.querySelector("img").src = open.firstElementChild.src;
    picture.showModal();
  });
  cancel.addEventListener("click", () => act(() => ask(`/v1/runs/${run.id}/cancel`, { method: "POST" })));
  for (const link of card.querySelectorAll("a.file")) link.addEventListener("click", fetchWithToken);
  return card;
}

// A link cannot carry the token, so with one the file is fetched and handed over.
async function fetchWithToken(event) {
  if (!sessionStorage.getItem("token")) return;
  event.preventDefault();
  const { href, textContent } = event.currentTarget;
  await act(async () => {
    const url = URL.createObjectURL(await (await ask(href)).blob());
    make("a", { href: url, download: textContent }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
  });
}

function updateRunCard(card, run) {
  const name = `Run ${run.index}, seed ${run.seed}`;
  write(card.querySelector("strong"), name);
  badge(card.querySelector(".badge"), run.state);
  const bar = card.querySelector("progress");
  bar.value = run.progress?.fraction ?? 0;
  bar.setAttribute("aria-label", `Progress of ${name}`);
  const progress = run.progress;
  const covered = run.result
    ? `${whole.format(run.result.p1)} squares, ${percent.format(run.result.fractions.p1)} of reachable`
    : progress && `${progress.phase}, epoch ${whole.format(progress.epochs_done)} of ${whole.format(progress.epochs_total)}`;
  write(card.querySelector(".facts"), sentence([`${run.arena} · ${run.method}`, run.label, covered, ...(progress ? pace(progress) : [])]));
  const error = card.querySelector(".error");
  write(error, run.error ?? "");
  error.hidden = !run.error;
  card.querySelector(".open").setAttribute("aria-label", `Coverage of ${name}`);
  const kept = !["failed", "cancelled"].includes(run.state);
  card.querySelectorAll(".files a").forEach((link, place) => {
    const file = FILES[place];
    link.hidden = (file.needs_findings && !kept) || (file.needs_result && run.state !== "done")
      || (file.needs_objects && !run.result?.objects?.length);
  });
  if (!kept) card.querySelector("img").removeAttribute("src");
  card.querySelector(".files button").hidden = !["queued", "running", "paused"].includes(run.state);
  card.dataset.id = run.id;
  card.dataset.stamp = `${run.state} ${progress?.robot_steps_done ?? 0}`;
  card.dataset.pictured = String(progress !== null);
}

// Fetches a picture that is on screen and has changed; the old one stays until the new one is there.
async function refreshPicture(card) {
  const { id, stamp, pictured } = card.dataset;
  const box = card.getBoundingClientRect();
  const seen = box.bottom > -200 && box.top < innerHeight + 200;
  if (!seen || pictured !== "true" || card.dataset.shown === stamp) return;
  const response = await ask(`/v1/runs/${id}/coverage.png`).catch((error) => {
    if (error.status === 409) return null;
    throw error;
  });
  card.dataset.shown = stamp;
  if (!response) return;
  const image = card.querySelector("img");
  const before = image.src;
  image.src = URL.createObjectURL(await response.blob());
  await image.decode().catch(() => {});
  const dialogImage = $("picture").querySelector("img");
  if (before && dialogImage.src === before) dialogImage.src = image.src;
  if (before) URL.revokeObjectURL(before);
}

// ---- what can be pressed

async function act(action) {
  try {
    await action();
    state.wake();
  } catch (error) {
    complain(error);
  }
}

const post = (what) => act(() => ask(`/v1/jobs/${state.job}/${what}`, { method: "POST" }));
$("pause").addEventListener("click", () => post("pause"));
$("resume").addEventListener("click", () => post("resume"));
$("cancel").addEventListener("click", () => post("cancel"));
$("delete").addEventListener("click", () => {
  if (!confirm("Delete this job, and the results that no other job has?")) return;
  act(async () => {
    await ask(`/v1/jobs/${state.job}`, { method: "DELETE" });
    choose(null);
    history.replaceState(null, "", location.pathname);
  });
});
$("older").addEventListener("click", () => { state.limit += 50; state.wake(); });
$("next").addEventListener("click", () => { if (state.next) { state.from.push(state.next); state.wake(); } });
$("previous").addEventListener("click", () => { if (state.from.length > 1) { state.from.pop(); state.wake(); } });

const curl = `curl --json '${JSON.stringify(FIRST_JOB)}' ${location.origin}/v1/jobs`;
$("curl").textContent = curl;
$("copy").addEventListener("click", () => act(() => navigator.clipboard.writeText(curl)));

$("new").addEventListener("click", () => {
  $("editor-text").value ||= JSON.stringify(FIRST_JOB, null, 2);
  $("editor-errors").replaceChildren();
  $("editor").showModal();
});
$("post").addEventListener("click", async () => {
  $("editor-errors").replaceChildren();
  try {
    const headers = { "content-type": "application/json" };
    const job = await json("/v1/jobs", { method: "POST", headers, body: $("editor-text").value });
    $("editor").close();
    location.hash = `job=${job.id}`;
    state.wake();
  } catch (error) {
    const told = (error.errors ?? []).map((e) => `${e.pointer || "(document)"}: ${e.message} (allowed: ${e.allowed})`);
    $("editor-errors").append(...(told.length ? told : [error.message]).map((textContent) => make("li", { textContent })));
  }
});

function followHash() {
  const id = /^#job=(\d+)$/.exec(location.hash)?.[1];
  if (id) choose(id);
  state.wake();
}
addEventListener("hashchange", followHash);
document.addEventListener("visibilitychange", () => state.wake());

// ---- the loop

async function refresh() {
  try {
    await showJobs();
    await showJob();
    $("alert").hidden = true;
  } catch (error) {
    if (error.status === 404) choose(null);
    complain(error);
  }
}

followHash();
for (;;) {
  let woken = false;
  const pause = new Promise((resolve) => {
    state.wake = () => { woken = true; resolve(); };
  });
  if (!document.hidden) await refresh();
  if (!woken) await Promise.race([pause, new Promise((resolve) => setTimeout(resolve, POLL_MS))]);
}
