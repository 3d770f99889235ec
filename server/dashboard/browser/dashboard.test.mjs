// The page as a whole: first visit, restart of the server, a token, themes and sizes.

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

test("a first visit teaches, and one button starts the first job", async () => {
  const { page, wrong } = await openPage(browser, server);
  const start = Date.now();
  await page.goto(server.url);
  await page.getByRole("heading", { name: "No jobs yet" }).waitFor();
  const paint = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime);
  console.log(`first paint after ${Math.round(paint)} ms, complete after ${Date.now() - start} ms`);
  await assertWell(page, "first visit");
  await picture(page, "first-visit");
  await page.getByRole("button", { name: "Start a first job" }).click();
  await page.waitForURL(/#\/jobs\/1$/);
  await page.getByRole("button", { name: "Cancel" }).waitFor();
  page.on("dialog", (dialog) => dialog.accept());
  await page.getByRole("button", { name: "Cancel" }).click();
  await page.locator("article .badge", { hasText: "cancelled" }).first().waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a restart of the server is told, and survived", async () => {
  // What cannot be reached is a message of the browser; nothing else may be.
  const { page, wrong } = await openPage(browser, server, { expected: ["net::ERR_"] });
  const job = await server.post("/v1/jobs", { name: "goes on", base: { ...SMALL, epochs: 1_000_000, seed: 77 } });
  const run = await server.firstRun(job);
  await page.goto(`${server.url}/#/runs/${run.id}`);
  await page.locator(".moment", { hasText: "step" }).waitFor();
  const begun = Date.now();
  await server.end();
  // Open streams do not hold the server up.
  assert.ok(Date.now() - begun < 8_000, `the server took ${Date.now() - begun} ms to end`);
  await page.getByRole("alert").filter({ hasText: "cannot be reached" }).waitFor();
  await page.getByRole("alert").filter({ hasText: /shown is [1-9]\d* s old/ }).waitFor();
  server = await server.again();
  await page.getByRole("alert").filter({ hasText: "cannot be reached" }).waitFor({ state: "hidden" });
  const step = async () => Number(/step ([\d,]+)/.exec(await page.locator(".moment").textContent())?.[1].replaceAll(",", ""));
  const before = await step();
  await page.waitForFunction((seen) => Number(/step ([\d,]+)/.exec(document.querySelector(".moment").textContent)?.[1].replaceAll(",", "")) > seen, before);
  await server.post(`/v1/jobs/${job.id}/cancel`, {});
  await page.locator("article .head .badge", { hasText: "cancelled" }).waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("the list follows events and asks for nothing meanwhile; it asks where there are none", async () => {
  for (const isHeard of [true, false]) {
    const { page, wrong } = await openPage(browser, server, { expected: ["503"] });
    let looks = 0;
    const isEvents = (url) => url.pathname === "/v1/events";
    page.on("request", (request) => { if (/\/v1\/jobs\?/.test(request.url())) looks += 1; });
    // As where all places of listeners are taken.
    if (!isHeard) {
      await page.route(isEvents, (route) => route.fulfill({
        status: 503, contentType: "application/problem+json", body: JSON.stringify({ title: "no", status: 503, code: "too-many-listeners", detail: "512 listen" }),
      }));
    }
    await page.goto(`${server.url}/#/`);
    await page.locator("#server-title").waitFor();
    await page.locator("nav .card").first().waitFor();
    const job = await server.post("/v1/jobs", { name: `comes ${isHeard}`, base: { ...SMALL, epochs: 1_000_000, seed: 500 + Number(isHeard) } });
    const card = page.locator("nav .card", { hasText: `comes ${isHeard}` });
    await card.locator(".badge", { hasText: "running" }).waitFor();
    await page.locator("#overview-title ~ ol a", { hasText: `comes ${isHeard}` }).first().waitFor();
    const share = () => card.locator("progress").getAttribute("value");
    const before = await share();
    await page.waitForFunction(([name, before]) => {
      const card = [...document.querySelectorAll("nav .card")].find((one) => one.textContent.includes(name));
      return card.querySelector("progress").getAttribute("value") !== before;
    }, [`comes ${isHeard}`, before]);
    await server.post(`/v1/jobs/${job.id}/cancel`, {});
    await card.locator(".badge", { hasText: "cancelled" }).waitFor();
    const deleted = await fetch(`${server.url}/v1/jobs/${job.id}`, { method: "DELETE" });
    assert.equal(deleted.status, 204);
    await card.waitFor({ state: "detached" });
    if (isHeard) assert.equal(looks, 1, "asked again and again");
    else assert.ok(looks > 2, `${looks} looks`);
    assert.equal(await page.getByRole("alert").isVisible(), false);
    assert.deepEqual(wrong, []);
    await page.close();
  }
});

test("a server with a token asks for it, and a wrong one is asked for again", async () => {
  const token = "a secret of the test";
  const other = await startServer({ token });
  try {
    const { page, wrong } = await openPage(browser, other, { expected: ["401"] });
    await page.goto(other.url);
    await page.locator("#token").fill("not this one, by far");
    await page.getByRole("button", { name: "Continue" }).click();
    await page.locator("dialog .bad", { hasText: "not a token of this server" }).waitFor();
    await page.locator("#token").fill(token);
    await assertWell(page, "token");
    await page.getByRole("button", { name: "Continue" }).click();
    await page.getByRole("heading", { name: "No jobs yet" }).waitFor();
    const job = await other.post("/v1/jobs", { name: "behind a token", base: { ...SMALL, epochs: 1_000_000 } });
    await page.goto(`${other.url}/#/jobs/${job.id}`);
    await page.locator("article .badge", { hasText: "running" }).first().waitFor();
    assert.deepEqual(wrong, []);
    await page.close();
  } finally {
    await other.stop();
  }
});

test("a token that only reads sees everything and is told what it may not do", async () => {
  const [token, reader] = ["a token that changes things", "a token that only reads"];
  const other = await startServer({ token, reader });
  try {
    const job = await other.post("/v1/jobs", { name: "to be read", base: { ...SMALL, epochs: 1_000_000 } });
    const { page, wrong } = await openPage(browser, other, { expected: ["401", "403"] });
    await page.goto(`${other.url}/#/jobs/${job.id}`);
    await page.locator("#token").fill(reader);
    await page.getByRole("button", { name: "Continue" }).click();
    await page.locator("article .badge", { hasText: "running" }).first().waitFor();
    assert.equal(await page.getByRole("alert").isVisible(), false);
    page.on("dialog", (dialog) => dialog.accept());
    await page.locator("article").getByRole("button", { name: "Cancel" }).click();
    await page.locator("#alert", { hasText: "allows to read, not to change" }).waitFor();
    await page.getByText("read only").waitFor();
    // What would be refused is not offered any more; the job goes on.
    assert.equal(await page.locator("article").getByRole("button", { name: "Cancel" }).isVisible(), false);
    await assertWell(page, "read only");
    await page.getByRole("link", { name: "New job" }).click();
    // Documents may be checked: that changes nothing.
    await page.locator(".estimate", { hasText: "30 runs" }).waitFor();
    assert.equal(await page.getByRole("button", { name: "Start", exact: true }).isVisible(), false);
    await page.goto(`${other.url}/#/`);
    await page.locator("#server-title").waitFor();
    await page.locator("dd", { hasText: "1 of 2 step a run" }).waitFor();
    await assertWell(page, "overview, read only");
    await picture(page, "read-only");
    assert.deepEqual(wrong, []);
    await page.close();
  } finally {
    await other.stop();
  }
});

test("the overview tells how the server is, and which runs need a look", async () => {
  const other = await startServer({ args: ["--run-memory-bytes", "4000000"] });
  try {
    await overviewOf(other);
  } finally {
    await other.stop();
  }
});

async function overviewOf(server) {
  const large = await server.post("/v1/jobs", {
    name: "too large",
    base: { ...SMALL, epochs: 1, arena: { name: "large", width_m: 3, height_m: 3, squares: 900, walls_m: [], starts: [{ x_m: 0.5, y_m: 0.5, heading_rad: 0 }] } },
  });
  assert.equal(await server.ended(large), "failed");
  const busy = await server.post("/v1/jobs", { name: "keeps a thread busy", base: { ...SMALL, epochs: 1_000_000, seed: 78 } });
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/`);
  await page.locator("#server-title").waitFor();
  await page.locator("section .facts", { hasText: "It is ready." }).waitFor();
  const row = (name) => page.locator(".figures > div", { has: page.locator("dt", { hasText: name }) }).locator("dd");
  await page.locator("dd", { hasText: /[1-2] of 2 step a run/ }).waitFor();
  assert.match(await row("memory").textContent(), /MiB|GiB/);
  assert.match(await row("disk left").textContent(), /GiB|MiB/);
  await page.locator("dd", { hasText: "robot-steps/s" }).waitFor();
  const run = await server.firstRun(busy);
  await page.locator("#server-title ~ ol a", { hasText: run.id.slice(0, 8) }).waitFor();
  await page.locator("#troubled-title ~ ol li", { hasText: /new: failed.*may hold/ }).waitFor();
  await assertWell(page, "overview");
  await picture(page, "overview");
  // From anywhere a slash goes to the search, j and k go through jobs.
  await page.locator("#overview-title").click();
  await page.keyboard.press("j");
  const first = await page.evaluate(() => document.activeElement?.getAttribute("href"));
  await page.keyboard.press("j");
  const second = await page.evaluate(() => document.activeElement?.getAttribute("href"));
  assert.ok(first?.startsWith("#/jobs/") && second?.startsWith("#/jobs/") && first !== second, `${first}, ${second}`);
  await page.keyboard.press("k");
  assert.equal(await page.evaluate(() => document.activeElement?.getAttribute("href")), first);
  await page.keyboard.press("/");
  await page.keyboard.type("keeps a thread");
  await page.locator("nav .card").nth(1).waitFor({ state: "detached" });
  assert.equal(await page.locator("nav .card").count(), 1);
  await server.post(`/v1/jobs/${busy.id}/cancel`, {});
  assert.deepEqual(wrong, []);
  await page.close();
}

for (const [name, options] of [
  ["dark", { colorScheme: "dark" }],
  ["phone", { viewport: { width: 390, height: 844 } }],
  ["reduced-motion", { reducedMotion: "reduce" }],
  ["projector", { viewport: { width: 1920, height: 1080 } }],
]) {
  test(`every screen works ${name}`, async () => {
    const { page, wrong } = await openPage(browser, server, options);
    let job = (await server.read("/v1/jobs")).items.find((one) => one.name === "two methods");
    job ??= await server.post("/v1/jobs", {
      name: "two methods",
      base: { ...SMALL, controller: { babbling_epochs: 1 } },
      matrix: { "controller.method": ["brownian", "im"] },
      seeds: { first: 1, count: 4 },
    });
    assert.equal(await server.ended(job), "done");
    const run = await server.firstRun(job);
    // Asked for again it is the one that there is.
    const made = await server.post(`/v1/runs/${run.id}/recordings`, { from_epoch: 2, epochs: 3 });
    for (const [screen, path, there] of [
      ["overview", "#/", "#overview-title"],
      ["job", `#/jobs/${job.id}?maps=1`, ".maps figure"],
      ["run", `#/runs/${run.id}`, ".files li"],
      ["replay", `#/runs/${run.id}?replay=${made.name}&at=500&explain=1`, ".where:not(:empty)"],
      ["new", "#/new", ".estimate:not(:empty)"],
    ]) {
      await page.goto(`${server.url}/${path}`);
      await page.locator(there).first().waitFor({ state: "attached" });
      await assertWell(page, `${screen} ${name}`);
      await picture(page, `${screen}-${name}`);
    }
    assert.deepEqual(wrong, []);
    await page.close();
  });
}
