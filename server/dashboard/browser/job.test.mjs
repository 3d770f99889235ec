// A job's screen: the winner is the summary's, a view is a link, jobs are controlled, many runs.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { assertWell, openPage, picture, startBrowser, startServer } from "./setup.mjs";

let browser;
let server;
before(async () => {
  [browser, server] = await Promise.all([startBrowser(), startServer()]);
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

const SMALL = { arena: "easy", epochs: 20, steps_per_epoch: 200, controller: { method: "brownian" } };
/** So few squares that half of them are entered soon. */
const OPEN = { name: "open", width_m: 0.6, height_m: 0.6, squares: 10, walls_m: [], starts: [{ x_m: 0.3, y_m: 0.3, heading_rad: 0 }] };
let three;

test("the winner on the page is the winner of the summary, whatever page of runs is open", async () => {
  // Ordered by the server so that each group's seeds lie together; the table of runs is sorted and
  // filtered here, which must not change what is pooled.
  three = await server.post("/v1/jobs", {
    name: "three methods",
    base: { ...SMALL, controller: { babbling_epochs: 1 }, epochs: 60 },
    matrix: { "controller.method": ["brownian", "im", "ev-iter-c"] },
    seeds: { first: 1, count: 10 },
  });
  assert.equal(await server.ended(three), "done");
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/jobs/${three.id}`);
  await page.locator(".legend li").nth(2).waitFor();
  const { groups } = await server.read(`/v1/jobs/${three.id}/summary`);
  const means = groups.map((group) => ({
    label: group.label,
    mean: group.measures.find((one) => one.name === "p1").mean,
  }));
  const check = async () => {
    const shown = await page.locator(".legend li").allTextContents();
    assert.equal(shown.length, 3);
    for (const { label, mean } of means) {
      const line = shown.find((text) => text.startsWith(label));
      assert.ok(line, `${label} in ${shown}`);
      assert.ok(line.includes("n 10"), line);
      const value = Number(line.slice(label.length).trim().split(" ")[0].replaceAll(",", ""));
      assert.ok(Math.abs(value - mean) <= 1, `${label}: ${value} shown, ${mean} pooled`);
    }
  };
  await check();
  // Every run has a dot, also of what it cost.
  const dots = page.getByRole("img", { name: "CPU time of a robot-step, ns of every run by group, n = 30" }).locator("circle");
  assert.equal(await dots.count(), 30);
  const runs = (await server.read(`/v1/jobs/${three.id}/runs?limit=200`)).items;
  const costs = groups.map((group) => group.measures.find((one) => one.name === "cpu_ns_per_robot_step").mean);
  groups.forEach((group, n) => {
    const own = runs.filter((run) => run.label === group.label).map((run) => run.cpu_ns_per_robot_step);
    assert.ok(Math.abs(own.reduce((sum, one) => sum + one, 0) / own.length - costs[n]) < 1e-6 * costs[n], group.label);
  });
  const comparison = await server.read(`/v1/jobs/${three.id}/comparison?measure=p1`);
  assert.equal(await page.locator(".verdict").textContent(), comparison.verdict);
  assert.notEqual(comparison.verdict, "");
  assert.equal(await page.locator("table.runs tbody tr").count(), 30);
  // One group's seeds lie on three pages of the table.
  await page.getByLabel("a page").selectOption("10");
  await page.getByRole("button", { name: "seed", exact: true }).click();
  for (const [number, said] of ["1 to 10", "11 to 20", "21 to 30"].entries()) {
    await page.locator(".pages", { hasText: `${said} of 30 runs` }).waitFor();
    const rows = await page.locator("table.runs tbody tr").allTextContents();
    assert.equal(rows.length, 10);
    for (const { label } of means) assert.ok(rows.some((row) => row.includes(label)), `${label} on page ${number + 1}`);
    await check();
    assert.equal(await page.locator(".verdict").textContent(), comparison.verdict);
    if (number < 2) await page.getByRole("button", { name: "Next runs" }).click();
  }
  assert.match(page.url(), /page=3/);
  await page.reload();
  await page.locator(".pages", { hasText: "21 to 30 of 30 runs" }).waitFor();
  await check();
  await page.getByLabel("Filter runs").fill("brownian 1");
  await check();
  await page.getByLabel("Filter runs").fill("");
  await page.getByLabel("a page").selectOption("50");
  await page.getByRole("button", { name: "what stands out" }).click();
  await assertWell(page, "job");
  await picture(page, "job");
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a link reproduces the view, and charts are taken along", async () => {
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/jobs/${three.id}`);
  await page.locator(".legend li").nth(2).waitFor();
  await page.getByLabel("Measure").selectOption("p10");
  await page.getByLabel("Scale").selectOption("log");
  await page.getByLabel("single runs").check();
  await page.locator(".legend input").first().uncheck();
  await page.locator("summary", { hasText: "Coverage maps" }).click();
  await page.locator(".maps figure").nth(2).waitFor();
  await page.getByRole("button", { name: "seed", exact: true }).click();
  const address = page.url();
  for (const part of ["measure=p10", "scale=log", "runs=1", "hide=", "maps=1", "sort=seed"]) {
    assert.ok(address.includes(part), `${part} in ${address}`);
  }
  const { page: other, wrong: otherWrong } = await openPage(browser, server);
  await other.goto(address);
  await other.locator(".maps figure").nth(2).waitFor();
  assert.equal(await other.getByLabel("Measure").inputValue(), "p10");
  assert.equal(await other.getByLabel("Scale").inputValue(), "log");
  assert.ok(await other.getByLabel("single runs").isChecked());
  assert.equal(await other.locator(".legend input").first().isChecked(), false);
  assert.equal(await other.locator("th[aria-sort]").textContent(), "seed");
  const verdict = (await server.read(`/v1/jobs/${three.id}/comparison?measure=p10`)).verdict;
  await other.locator(".verdict", { hasText: verdict }).waitFor();
  await assertWell(other, "job by a link");
  for (const [name, kind, begins] of [
    ["curves", "SVG", "<svg"], ["curves", "CSV", "group,epoch,n,mean"], ["differences", "SVG", "<svg"],
    ["differences", "CSV", "pair,n"], ["p1", "SVG", "<svg"], ["p1", "CSV", "group,seed,run,p1"],
  ]) {
    const [download] = await Promise.all([
      other.waitForEvent("download"),
      other.getByRole("button", { name: `${name} as ${kind}`, exact: true }).click(),
    ]);
    const stream = await download.createReadStream();
    const parts = [];
    for await (const part of stream) parts.push(part);
    const text = Buffer.concat(parts).toString();
    assert.ok(text.startsWith(begins), `${name} as ${kind}: ${text.slice(0, 60)}`);
  }
  for (const name of ["curves", "differences", "map"]) {
    const [download] = await Promise.all([
      other.waitForEvent("download"),
      other.getByRole("button", { name: `${name} as PNG`, exact: true }).first().click(),
    ]);
    const [first] = await (await download.createReadStream()).take(1).toArray();
    assert.equal(first.subarray(1, 4).toString(), "PNG", name);
  }
  assert.deepEqual([...wrong, ...otherWrong], []);
  await page.close();
  await other.close();
});

test("curves are in squares or shares, and a sweep of fields is a map and lines", async () => {
  const job = await server.post("/v1/jobs", {
    name: "a sweep",
    base: SMALL,
    matrix: { robots: [1, 2], epochs: [5, 10, 20], placement: ["grid", "random"] },
    seeds: { first: 1, count: 3 },
  });
  assert.equal(await server.ended(job), "done");
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/jobs/${job.id}?measure=p1_fraction`);
  await page.locator(".legend li", { hasText: /[\d.]+%/ }).first().waitFor();
  const { groups } = await server.read(`/v1/jobs/${job.id}/curves?measure=p1_fraction`);
  const squares = (await server.read(`/v1/jobs/${job.id}/curves?measure=p1`)).groups;
  const { reachable } = (await server.firstRun(job)).result;
  assert.ok(Math.abs(groups[0].mean.at(-1) - squares[0].mean.at(-1) / reachable) < 1e-9);
  await page.getByRole("heading", { name: "Two fields at once" }).waitFor();
  await page.getByRole("heading", { name: "All fields at once" }).waitFor();
  assert.equal(await page.locator('[aria-label="Parallel coordinates"] polyline').count(), 12);
  await page.getByLabel("Rows").selectOption("epochs");
  await page.getByLabel("Columns").selectOption("placement");
  await page.waitForURL(/rows=epochs&columns=placement/);
  await page.reload();
  await page.waitForFunction(() => document.querySelector("#sweep-rows")?.value === "epochs" && document.querySelector("#sweep-columns")?.value === "placement");
  assert.equal(await page.locator('[aria-label="Sweep"] rect').count(), 6);
  await assertWell(page, "sweep");
  await picture(page, "sweep", page.locator('[aria-label="Parallel coordinates"]'));
  assert.deepEqual(wrong, []);
  await page.close();
});

test("times over robots are drawn log-log, with the fitted slope and its interval", async () => {
  const job = await server.post("/v1/jobs", {
    name: "more robots",
    base: { ...SMALL, arena: OPEN, placement: "grid", episodes: "continue", epochs: 100, steps_per_epoch: 500 },
    matrix: { robots: [1, 2, 4, 8] }, seeds: { first: 1, count: 4 },
  });
  assert.equal(await server.ended(job), "done");
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  const plot = page.locator("section", { has: page.getByRole("heading", { name: "Scaling over robots" }) }).locator("figure");
  await plot.locator("svg").waitFor();
  const [scaling] = (await server.read(`/v1/jobs/${job.id}/summary`)).scaling;
  const fit = scaling.fits.find((one) => one.name === "t50_steps");
  assert.equal(fit.n, 16);
  const said = await plot.locator("figcaption").textContent();
  const told = (value) => (Math.abs(value) >= 1 ? value.toFixed(1) : value.toPrecision(3));
  assert.ok(said.includes(`t50 ~ N^-${told(fit.b)} [${told(fit.b_interval.low)}, ${told(fit.b_interval.high)}], n = 16`), said);
  const drawn = await plot.locator("svg").evaluate((svg) => ({
    rails: [...svg.querySelectorAll(".rail")].map((line) => Number(line.getAttribute("x1"))),
    dots: [...svg.querySelectorAll("circle")].filter((dot) => dot.textContent.startsWith("t50")).map((dot) => ["cx", "cy"].map((name) => Number(dot.getAttribute(name)))),
    line: ["x1", "x2", "y1", "y2"].map((name) => Number(svg.querySelector("line[stroke]").getAttribute(name))),
  }));
  // Twice the robots are always as far apart.
  const steps = drawn.rails.slice(1).map((x, n) => x - drawn.rails[n]);
  assert.equal(steps.length, 3);
  assert.ok(steps.every((step) => Math.abs(step - steps[0]) < 0.1), `${steps}`);
  // Pixels of a factor of e, up as across, from two dots; the line falls by b of them.
  const means = scaling.points.map((point) => point.times.find((one) => one.name === "t50_steps").mean_steps);
  const [[x1, y1], , , [x8, y8]] = drawn.dots;
  const [across, up] = [(x8 - x1) / Math.log(8), (y8 - y1) / Math.log(means[0] / means[3])];
  const slope = (drawn.line[3] - drawn.line[2]) / up / ((drawn.line[1] - drawn.line[0]) / across);
  assert.ok(Math.abs(slope - fit.b) < 0.01, `drawn with ${slope}, fitted ${fit.b}`);
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "scaling as CSV", exact: true }).click()]);
  const [csv] = await (await download.createReadStream()).toArray();
  assert.ok(csv.toString().startsWith("time,robots,mean_steps,n\nt50_steps,1,"), csv.toString());
  await assertWell(page, "scaling");
  await picture(page, "scaling", plot);
  assert.deepEqual(wrong, []);
  await page.close();
});

test("the experiments of chapter 5 have a report, which is there once they have ended", async () => {
  const { items } = await server.read("/v1/templates");
  const methods = items.find((one) => one.name === "chapter-5").job.parts[0].matrix["controller.method"];
  const job = await server.post("/v1/jobs", {
    name: "chapter 5, small",
    base: { arena: "easy", epochs: 4, steps_per_epoch: 50 }, matrix: { "controller.method": methods }, seeds: { first: 1, count: 2 },
  });
  const { page, wrong } = await openPage(browser, server);
  assert.equal(await server.ended(job), "done");
  await page.goto(`${server.url}/#/jobs/${three.id}`);
  await page.locator(".legend li").nth(2).waitFor();
  const link = page.getByRole("link", { name: "report on chapter 5" });
  assert.equal(await link.isVisible(), false, "three methods have no report");
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  await link.waitFor();
  await link.click();
  await page.waitForURL(/report\.html$/);
  await page.locator("h1").first().waitFor();
  const claims = (await server.read(`/v1/jobs/${job.id}/report`)).claims;
  assert.equal(claims.length, 10);
  const text = await page.locator("body").textContent();
  for (const method of methods) assert.ok(text.includes(method), method);
  assert.ok((await page.locator("svg, img").count()) > 0, "it has pictures");
  await assertWell(page, "report");
  await picture(page, "report");
  assert.deepEqual(wrong, []);
  await page.close();
});

test("what stands out comes first, as the summary has it, with why", async () => {
  // Some seed among many stands out.
  let job;
  let odd = [];
  for (let first = 1; odd.length < 2 && first < 2_000; first += 200) {
    job = await server.post("/v1/jobs", {
      name: "one stands out", base: { ...SMALL, epochs: 4, steps_per_epoch: 100 }, seeds: { first, count: 80 },
    });
    assert.equal(await server.ended(job), "done");
    odd = (await server.read(`/v1/jobs/${job.id}/summary`)).odd_runs;
  }
  assert.ok(odd.length >= 2, `${odd.length} runs of 800 stand out`);
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  await page.waitForFunction((count) => document.querySelectorAll("table.runs tr.odd").length === count, odd.length);
  const shown = await page.locator("table.runs tbody tr").evaluateAll((rows, count) => rows.slice(0, count).map((row) => row.querySelector("a").hash.slice("#/runs/".length)), odd.length);
  assert.deepEqual(shown, odd.map((one) => one.run_id));
  const whole = (value) => Math.round(value).toLocaleString("en");
  const row = page.locator("table.runs tbody tr").first();
  assert.ok((await row.textContent()).includes(`p1 ${whole(odd[0].p1)}, the median of its group is `), await row.textContent());
  await assertWell(page, "what stands out");
  await picture(page, "odd", page.locator("#runs-filter"));
  await row.getByRole("link", { name: "Why?" }).click();
  await page.waitForURL(new RegExp(`runs/${odd[0].run_id}\\?explain=1`));
  await page.locator(".explained .verdict:not(:empty)").waitFor();
  const told = await page.locator(".explained .verdict").textContent();
  // Once it was asked for, the explanation stands in the table.
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  await page.locator("table.runs tr.odd", { hasText: told }).first().waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a job is paused, resumed, cancelled, tried again, extended and cloned", async () => {
  const { page, wrong } = await openPage(browser, server);
  const job = await server.post("/v1/jobs", { name: "controlled", base: { ...SMALL, epochs: 1_000_000, seed: 9 } });
  page.on("dialog", (dialog) => dialog.accept(dialog.type() === "prompt" ? "2" : undefined));
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  const is = (state) => page.locator("article .head .badge", { hasText: state }).first().waitFor();
  await is("running");
  await page.getByRole("button", { name: "Pause" }).click();
  await is("paused");
  await page.getByRole("button", { name: "Resume" }).click();
  await is("running");
  await page.getByRole("button", { name: "Cancel" }).click();
  await is("cancelled");
  await assertWell(page, "cancelled job");
  await page.getByRole("button", { name: "Try again" }).click();
  await is("running");
  await page.getByRole("button", { name: "More seeds" }).click();
  await page.locator("article .facts", { hasText: "of 3 runs" }).waitFor();
  await page.getByRole("button", { name: "Cancel" }).click();
  await is("cancelled");
  await page.getByRole("link", { name: "Clone" }).click();
  await page.waitForFunction(() => document.querySelector("#document")?.value.includes("controlled"));
  assert.equal(await page.getByLabel("Epochs", { exact: true }).inputValue(), "1000000");
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a thousand runs in a hundred groups stay fluid", async () => {
  const ten = Array.from({ length: 10 }, (_, n) => n + 1);
  const job = await server.post("/v1/jobs", {
    name: "a thousand runs",
    base: { ...SMALL },
    matrix: { epochs: ten, steps_per_epoch: ten.map((n) => 10 * n) },
    seeds: { first: 1, count: 10 },
  });
  assert.equal(await server.ended(job), "done");
  const { page, wrong } = await openPage(browser, server);
  await page.addInitScript(() => {
    window.longest = 0;
    new PerformanceObserver((list) => {
      for (const entry of list.getEntries()) window.longest = Math.max(window.longest, entry.duration);
    }).observe({ entryTypes: ["longtask"] });
  });
  const start = Date.now();
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  await page.locator(".legend li").nth(99).waitFor();
  await page.locator(".pages", { hasText: "of 1,000 runs" }).waitFor();
  const shown = Date.now() - start;
  const loading = await page.evaluate(() => window.longest);
  await page.evaluate(() => { window.longest = 0; });
  await page.getByRole("button", { name: "p1", exact: true }).click();
  await page.getByLabel("Filter runs").pressSequentially("steps_per_epoch 10", { delay: 20 });
  await page.getByLabel("Groups", { exact: true }).selectOption("epochs");
  await page.locator(".legend li").nth(10).waitFor({ state: "detached" });
  const using = await page.evaluate(() => window.longest);
  console.log(`1,000 runs in 100 groups: shown after ${shown} ms; longest task ${Math.round(loading)} ms loading, ${Math.round(using)} ms using`);
  assert.ok(loading < 3_000 && using < 3_000, `${loading} ms, ${using} ms`);
  await assertWell(page, "a thousand runs");
  await picture(page, "thousand-runs");
  assert.deepEqual(wrong, []);
  await page.close();
});
