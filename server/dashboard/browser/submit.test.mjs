// A new job: by form, by JSON, by drawing; wrong fields; what it would take.

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
const json = async (page) => JSON.parse(await page.getByLabel("The job as JSON").inputValue());

test("a job is written by form and started", async () => {
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/new`);
  await page.locator(".estimate", { hasText: "30 runs" }).waitFor();
  await page.getByLabel("Name", { exact: true }).fill("by form");
  await page.getByLabel("Methods").selectOption(["brownian", "levy"]);
  await page.getByLabel("Epochs", { exact: true }).fill("3, 5");
  await page.getByLabel("Steps an epoch").fill("100");
  await page.getByLabel("Seeds", { exact: true }).fill("2");
  await page.locator(".estimate", { hasText: "8 runs · 4 groups" }).waitFor();
  assert.deepEqual(await json(page), {
    name: "by form",
    base: { arena: "easy", steps_per_epoch: 100 },
    matrix: { "controller.method": ["brownian", "levy"], epochs: [3, 5] },
    seeds: { first: 1, count: 2 },
  });
  await assertWell(page, "form");
  await picture(page, "new");
  await page.getByRole("button", { name: "Start" }).click();
  await page.waitForURL(/#\/jobs\/\d+$/);
  await page.getByRole("heading", { name: "by form" }).waitFor();
  await page.locator("article .facts", { hasText: "of 8 runs" }).waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a wrong field is told at its place and beside the text, and a right one starts", async () => {
  const { page, wrong } = await openPage(browser, server, { expected: ["422"] });
  await page.goto(`${server.url}/#/new`);
  await page.locator(".estimate", { hasText: "30 runs" }).waitFor();
  await page.getByLabel("Epochs", { exact: true }).fill("0");
  await page.locator("#errors code", { hasText: "/base/epochs" }).waitFor();
  const field = page.getByLabel("Epochs", { exact: true });
  assert.equal(await field.getAttribute("aria-invalid"), "true");
  const described = (await field.getAttribute("aria-describedby")).split(" ")[0];
  assert.match(await page.locator(`#${described}`).textContent(), /allowed/);
  await assertWell(page, "wrong field");
  await picture(page, "new-refused");
  const text = page.getByLabel("The job as JSON");
  await text.fill("{ no");
  await page.locator("#errors", { hasText: "not JSON yet" }).waitFor();
  await text.fill(JSON.stringify({ base: { ...SMALL, epochs: 0 } }));
  await page.getByRole("button", { name: "Start" }).click();
  await page.locator("#errors code", { hasText: "/base/epochs" }).waitFor();
  await text.fill(JSON.stringify({ name: "from the page", base: SMALL }));
  await page.locator(".estimate", { hasText: "1 run" }).waitFor();
  await page.getByRole("button", { name: "Start" }).click();
  await page.waitForURL(/#\/jobs\/\d+$/);
  await page.getByRole("heading", { name: "from the page" }).waitFor();
  assert.deepEqual(wrong, []);
  await page.close();
});

test("parameters have defaults, ranges and units, and templates are starting points", async () => {
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/new`);
  await page.locator(".estimate", { hasText: "30 runs" }).waitFor();
  await page.getByLabel("Methods").selectOption(["im"]);
  await page.getByLabel("Add").selectOption("controller.alpha");
  const alpha = page.getByLabel("alpha", { exact: true });
  await alpha.fill("0.2, 0.8");
  await page.locator(".estimate", { hasText: "2 groups" }).waitFor();
  assert.deepEqual((await json(page)).matrix, { "controller.alpha": [0.2, 0.8] });
  assert.match(await page.locator(".field", { has: alpha }).textContent(), /default/);
  await page.getByLabel("Leave alpha at its default").click();
  assert.equal((await json(page)).matrix, undefined);
  await page.getByLabel("Start from").selectOption("first-job");
  await page.waitForFunction(() => document.querySelector("#document").value.includes('"first-job"'));
  assert.deepEqual(wrong, []);
  await page.close();
});

test("an arena is drawn, and the server says what can be reached in it", async () => {
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/new`);
  await page.locator("section .facts", { hasText: "A robot can reach" }).waitFor();
  await page.getByRole("button", { name: "Draw on a copy" }).click();
  await page.getByLabel("Wall", { exact: true }).waitFor();
  const before = (await json(page)).base.arena;
  await page.locator("section .facts", { hasText: "A robot can reach" }).waitFor();
  const said = await page.locator("section .facts", { hasText: "A robot can reach" }).textContent();
  const editor = page.locator("svg.editor");
  await editor.scrollIntoViewIfNeeded();
  const box = await editor.boundingBox();
  const at = (x, y) => [box.x + box.width * x, box.y + box.height * (1 - y)];
  await page.mouse.move(...at(0, 0.2));
  await page.mouse.down();
  await page.mouse.move(...at(1, 0.2), { steps: 4 });
  await page.mouse.up();
  const drawn = (await json(page)).base.arena;
  assert.equal(drawn.walls_m.length, before.walls_m.length + 1);
  await page.waitForFunction((said) => {
    const now = [...document.querySelectorAll("section .facts")].find((one) => one.textContent.includes("A robot can reach"))?.textContent;
    return now && now !== said;
  }, said);
  assert.ok((await page.locator('svg.editor rect[fill="url(#hatch)"]').count()) > 0);
  // Objects that are pushed need rigid bodies.
  await page.getByLabel("Engine").selectOption("rapier");
  await page.getByLabel("Disc", { exact: true }).check();
  await page.mouse.click(...at(0.5, 0.1));
  assert.equal((await json(page)).base.arena.objects.length, 1);
  await assertWell(page, "editor");
  await picture(page, "editor", editor);
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByRole("button", { name: "Undo" }).click();
  assert.deepEqual((await json(page)).base.arena.walls_m, before.walls_m);
  assert.deepEqual(wrong, []);
  await page.close();
});
