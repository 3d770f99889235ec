// The dashboard in a real browser, against the real server.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { barriers, openPage, picture, startBrowser, startServer } from "./setup.mjs";

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

async function done(job) {
  for (let look = 0; look < 600; look++) {
    const { state } = await server.read(`/v1/jobs/${job.id}`);
    if (["done", "failed", "cancelled"].includes(state)) return state;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error("the job does not end");
}

test("a first visit teaches, and one button starts the first job", async () => {
  const { page, wrong } = await openPage(browser, server);
  await page.goto(server.url);
  await page.getByRole("heading", { name: "No jobs yet" }).waitFor();
  assert.deepEqual(await barriers(page), []);
  await picture(page, "first-visit");
  await page.getByRole("button", { name: "Start a first job" }).click();
  await page.waitForURL(/#\/jobs\/1$/);
  await page.locator(".head .badge", { hasText: "done" }).waitFor({ timeout: 60_000 });
  assert.deepEqual(wrong, []);
  await page.close();
});

test("the winner on the page is the winner of the summary, also where a page of runs shows another", async () => {
  // Ordered so that one group's seeds lie on several pages of runs.
  const job = await server.post("/v1/jobs", {
    name: "three methods",
    base: { ...SMALL, controller: { babbling_epochs: 1 }, epochs: 60 },
    matrix: { "controller.method": ["brownian", "im", "ev-iter-c"] },
    seeds: { first: 1, count: 10 },
  });
  assert.equal(await done(job), "done");
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/jobs/${job.id}`);
  await page.locator(".legend li").nth(2).waitFor();
  const { groups } = await server.read(`/v1/jobs/${job.id}/summary`);
  const means = groups.map((group) => ({
    label: group.label,
    mean: group.measures.find((one) => one.name === "p1").mean,
  }));
  const shown = await page.locator(".legend li").allTextContents();
  assert.equal(shown.length, 3);
  for (const { label, mean } of means) {
    const line = shown.find((text) => text.startsWith(label));
    assert.ok(line, `${label} in ${shown}`);
    assert.ok(line.includes("n 10"), line);
    const value = Number(line.slice(label.length).trim().split(" ")[0].replaceAll(",", ""));
    assert.ok(Math.abs(value - mean) <= 1, `${label}: ${value} shown, ${mean} pooled`);
  }
  const comparison = await server.read(`/v1/jobs/${job.id}/comparison?measure=p1`);
  assert.equal(await page.locator(".verdict").textContent(), comparison.verdict);
  assert.notEqual(comparison.verdict, "");
  assert.deepEqual(await barriers(page), []);
  await picture(page, "job");
  await page.getByLabel("Measure").selectOption("p10");
  await page.waitForFunction(() => location.hash.includes("measure=p10"));
  await page.reload();
  await page.locator(".legend li").nth(2).waitFor();
  assert.equal(await page.getByLabel("Measure").inputValue(), "p10");
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a wrong field is told beside the text, and a right one starts", async () => {
  const { page, wrong } = await openPage(browser, server, { expected: ["422"] });
  await page.goto(`${server.url}/#/new`);
  const text = page.getByLabel("The job as JSON");
  await text.fill(JSON.stringify({ base: { ...SMALL, epochs: 0 } }));
  await page.getByRole("button", { name: "Start" }).click();
  await page.locator("#errors code", { hasText: "/base/epochs" }).waitFor();
  assert.deepEqual(await barriers(page), []);
  await picture(page, "new-job-refused");
  await text.fill(JSON.stringify({ name: "from the page", base: SMALL }));
  await page.getByRole("button", { name: "Start" }).click();
  await page.waitForURL(/#\/jobs\/\d+$/);
  await page.getByRole("heading", { name: "from the page" }).waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a run is watched while it goes on; its job is paused, resumed and cancelled", async () => {
  const job = await server.post("/v1/jobs", {
    name: "long",
    base: { ...SMALL, seed: 9, epochs: 100_000, steps_per_epoch: 2_000 },
  });
  const { page, wrong } = await openPage(browser, server);
  page.on("dialog", (dialog) => dialog.accept());
  const [run] = (await server.read(`/v1/jobs/${job.id}/runs`)).items;
  await page.goto(`${server.url}/#/runs/${run.id}`);
  await page.locator("dt", { hasText: "p1" }).first().waitFor();
  const covered = () => page.locator(".scene canvas[role=img]").getAttribute("aria-label");
  await page.waitForFunction(() => /with [1-9]/.test(document.querySelector(".scene canvas")?.getAttribute("aria-label") ?? ""));
  assert.match(await covered(), /squares entered/);
  assert.deepEqual(await barriers(page), []);
  await picture(page, "run");
  await page.getByRole("link", { name: "Its job" }).click();
  await page.getByRole("button", { name: "Pause" }).click();
  await page.locator(".head .badge", { hasText: "paused" }).waitFor();
  await page.getByRole("button", { name: "Resume" }).click();
  await page.locator(".head .badge", { hasText: "running" }).first().waitFor();
  await page.getByRole("button", { name: "Cancel" }).click();
  await page.locator(".head .badge", { hasText: "cancelled" }).first().waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a restart of the server is told, and survived", async () => {
  const { page } = await openPage(browser, server);
  await page.goto(server.url);
  await page.locator(".jobs .card").first().waitFor();
  await server.end();
  await page.getByRole("alert").filter({ hasText: "cannot be reached" }).waitFor();
  server = await server.again();
  await page.getByRole("alert").filter({ hasText: "cannot be reached" }).waitFor({ state: "hidden", timeout: 20_000 });
  await page.close();
});

test("a server with a token asks for it", async () => {
  const token = "a secret of the test";
  const other = await startServer({ token });
  try {
    const { page, wrong } = await openPage(browser, other, { expected: ["401"] });
    await page.goto(other.url);
    await page.locator("#token").fill(token);
    await page.getByRole("button", { name: "Continue" }).click();
    await page.getByRole("heading", { name: "No jobs yet" }).waitFor();
    assert.deepEqual(wrong, []);
    await page.close();
  } finally {
    await other.stop();
  }
});

for (const [name, options] of [
  ["dark", { colorScheme: "dark" }],
  ["phone", { viewport: { width: 390, height: 844 } }],
  ["reduced-motion", { reducedMotion: "reduce" }],
]) {
  test(`every screen works ${name}`, async () => {
    const { page, wrong } = await openPage(browser, server, options);
    const jobs = (await server.read("/v1/jobs")).items;
    const job = jobs.find((one) => one.name === "three methods");
    const [run] = (await server.read(`/v1/jobs/${job.id}/runs`)).items;
    for (const [screen, path, there] of [
      ["overview", "#/", "#overview-title"],
      ["job", `#/jobs/${job.id}`, ".legend li"],
      ["run", `#/runs/${run.id}`, ".files li"],
      ["new", "#/new", "tbody tr"],
    ]) {
      await page.goto(`${server.url}/${path}`);
      await page.locator(there).first().waitFor({ state: "attached" });
      assert.deepEqual(await barriers(page), [], screen);
      const { scroll, width } = await page.evaluate(() => ({
        scroll: document.documentElement.scrollWidth,
        width: document.documentElement.clientWidth,
      }));
      assert.ok(scroll <= width, `${screen} is ${scroll} wide on ${width}`);
      await picture(page, `${screen}-${name}`);
    }
    assert.deepEqual(wrong, []);
    await page.close();
  });
}
