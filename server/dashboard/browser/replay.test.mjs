// Recordings on a run's screen: asked for, played, scrubbed, set beside another run; and why a run
// did what it did, with the moment in the recording.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { assertWell, openPage, picture, startBrowser, startServer } from "./setup.mjs";

let browser;
let server;
let job;
let runs;
before(async () => {
  [browser, server] = await Promise.all([startBrowser(), startServer()]);
  job = await server.post("/v1/jobs", {
    name: "replayed",
    base: {
      arena: "easy", robots: 2, placement: "grid", epochs: 12, steps_per_epoch: 400,
      controller: { method: "ev-iter-c", train: { arena: "easy", epochs: 8 } },
    },
    seeds: { first: 1, count: 2 },
  });
  assert.equal(await server.ended(job), "done");
  runs = (await server.read(`/v1/jobs/${job.id}/runs`)).items;
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

const where = (page) => page.locator(".where");
/** Epoch and step that the timeline tells. */
const moment = async (page) => {
  const [, epoch, step] = /epoch ([\d,]+) · step ([\d,]+)/.exec(await where(page).textContent()) ?? [];
  return [epoch, step].map((text) => Number(text?.replaceAll(",", "")));
};
const says = (page, text) => page.locator(".where", { hasText: text }).waitFor();

test("a run without a recording asks for one, shows how far it is, and is played to the end", async () => {
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/runs/${runs[0].id}`);
  await page.locator("summary", { hasText: "Record a stretch" }).click();
  await page.getByText("Nothing of this run is recorded yet").waitFor();
  await page.getByLabel("From epoch").fill("14");
  await page.getByLabel("epochs", { exact: true }).fill("5");
  await assertWell(page, "run without a recording");
  await page.getByRole("button", { name: "Record", exact: true }).click();
  await page.locator(".recorder [role=status]", { hasText: "Recording" }).waitFor();
  await says(page, "epoch 14 · step 0 of 400");
  assert.deepEqual([await page.getByLabel("Step of the recording").getAttribute("min"), await page.getByLabel("Step of the recording").getAttribute("max")], ["5600", "7600"]);

  // Scrubbed, stepped, an epoch chosen; what is shown is what was recorded.
  await page.getByLabel("Step of the recording").fill("6010");
  await says(page, "epoch 15 · step 10");
  assert.match(page.url(), /at=6010/);
  const slice = await server.read(`/v1/runs/${runs[0].id}/recordings/1.json?from_step=6010&steps=1&robots=0`);
  await page.locator(".senses ~ figcaption", { hasText: `ps0 to ps7: ${slice.robots[0].sensors[0].join(", ")} of` }).waitFor();
  await page.getByRole("button", { name: "One moment on" }).click();
  await says(page, "epoch 15 · step 11");
  await page.locator("h2").click();
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowLeft");
  await says(page, "epoch 15 · step 9");
  await page.getByLabel("Epoch", { exact: true }).fill("16");
  await page.getByLabel("Epoch", { exact: true }).press("Enter");
  await says(page, "epoch 16 · step 0");

  // Played at two speeds; the space bar stops and goes on.
  await page.getByLabel("Epoch", { exact: true }).fill("14");
  await page.getByLabel("Epoch", { exact: true }).press("Enter");
  await says(page, "epoch 14 · step 0 of");
  await page.getByLabel("Speed", { exact: true }).selectOption("1");
  await page.locator("h2").click();
  await page.keyboard.press(" ");
  await page.getByRole("button", { name: "Pause", exact: true }).waitFor();
  await page.waitForFunction(() => !document.querySelector(".where").textContent.includes("step 0 of"));
  await page.keyboard.press(" ");
  await page.getByRole("button", { name: "Play" }).waitFor();
  const [epoch, step] = await moment(page);
  assert.ok(epoch === 14 && step > 0 && step < 400, `epoch ${epoch}, step ${step}`);
  await page.getByLabel("Speed", { exact: true }).selectOption("128");
  await page.getByRole("button", { name: "Play" }).click();
  await says(page, "epoch 18 · step 400 of 400");
  await page.getByRole("button", { name: "Play" }).waitFor();
  await page.locator(".marks .phase", { hasText: "exploration" }).waitFor();
  assert.ok((await page.locator(".marks .epoch").count()) >= 2);
  await assertWell(page, "replay at its end");
  assert.deepEqual(wrong, []);
  await page.close();
});

test("two runs are compared side by side, in step, and a link has the whole view", async () => {
  // The test reads pixels back, which the browser remarks on.
  const { page, wrong } = await openPage(browser, server, { expected: ["willReadFrequently"] });
  await page.goto(`${server.url}/#/runs/${runs[0].id}?replay=1&at=6200&robot=1&speed=32&layer=first`);
  await says(page, "epoch 15 · step 200");
  await page.getByLabel("Beside it").selectOption(runs[1].id);
  await page.locator(".beside canvas[role=img]").waitFor();
  await page.waitForFunction(() => /2 robots/.test(document.querySelector(".beside canvas")?.getAttribute("aria-label") ?? ""));
  const colours = () => page.evaluate(() => [...document.querySelectorAll("canvas.swarm")].map((one) => {
    const { data } = one.getContext("2d").getImageData(0, 0, one.width, one.height);
    return new Uint32Array(data.buffer).reduce((sum, pixel) => (sum * 31 + pixel) >>> 0, 7);
  }));
  const before = await colours();
  await page.getByLabel("Step of the recording").fill("7130");
  await says(page, "epoch 17 · step 330");
  await page.waitForFunction(([first, second]) => {
    const [one, other] = [...document.querySelectorAll("canvas.swarm")].map((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return new Uint32Array(data.buffer).reduce((sum, pixel) => (sum * 31 + pixel) >>> 0, 7);
    });
    return one !== first && other !== second;
  }, before);
  await assertWell(page, "two runs side by side");
  await picture(page, "replay");
  const address = page.url();
  for (const part of ["replay=1", "at=7130", "robot=1", "speed=32", "layer=first", `beside=${runs[1].id}`]) {
    assert.ok(address.includes(part), `${part} in ${address}`);
  }
  const { page: other, wrong: otherWrong } = await openPage(browser, server);
  await other.goto(address);
  await says(other, "epoch 17 · step 330");
  await other.waitForFunction(() => /2 robots/.test(document.querySelector(".beside canvas")?.getAttribute("aria-label") ?? ""));
  assert.equal(await other.getByLabel("Speed", { exact: true }).inputValue(), "32");
  assert.equal(await other.getByLabel("Beside it").inputValue(), runs[1].id);
  assert.equal(await other.getByLabel("Robot", { exact: true }).inputValue(), "1");
  // Back to what is live: a run that is done has what it covered.
  await other.locator("#recording").selectOption("");
  await other.locator(".timeline").waitFor({ state: "hidden" });
  assert.doesNotMatch(other.url(), /replay|beside/);
  assert.deepEqual([...wrong, ...otherWrong], []);
  await page.close();
  await other.close();
});

/** What the server says of a run, once it has stepped it again. */
const explained = async (run) => {
  for (;;) {
    const told = await server.read(`/v1/runs/${run.id}/explain`);
    if (told.sentence !== undefined) return told;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
};

/** A run in which a robot stayed somewhere, among many. */
const stayer = async () => {
  const some = await server.post("/v1/jobs", {
    name: "one stays",
    base: { arena: "easy", robots: 2, placement: "grid", epochs: 12, steps_per_epoch: 400, controller: { train: { arena: "easy", epochs: 8 } } },
    matrix: { "controller.method": ["ev-iter-c", "ev-iter-d", "curiosity"] },
    seeds: { first: 1, count: 8 },
  });
  assert.equal(await server.ended(some), "done");
  for (const run of (await server.read(`/v1/jobs/${some.id}/runs`)).items) {
    const { standing, confined } = await explained(run);
    if (standing.length + confined.length > 0) return run;
  }
  throw new Error("no robot of 24 runs stayed anywhere");
};

test("what a run did is told in a sentence, with the moment in the recording", async () => {
  const run = await stayer();
  const { page, wrong } = await openPage(browser, server);
  await page.goto(`${server.url}/#/runs/${run.id}`);
  await page.getByRole("button", { name: "Explain" }).click();
  await page.locator(".explained .verdict:not(:empty)").waitFor();
  const known = await explained(run);
  assert.equal(await page.locator(".explained .verdict").textContent(), known.sentence);
  const longest = [...known.standing, ...known.confined].sort((a, b) => b.steps - a.steps)[0];
  await page.locator("summary", { hasText: "When and where" }).click();
  await assertWell(page, "explained run");
  // The stretch is recorded where it is not, and shown.
  await page.locator(".stayed button").first().click();
  await says(page, `epoch ${longest.epoch} · step ${longest.epoch_step} of`);
  assert.equal(await page.getByLabel("Robot", { exact: true }).inputValue(), String(longest.robot));
  await page.locator(".marks .stretch").first().waitFor();
  await assertWell(page, "explained moment");
  await picture(page, "explained");
  // A link has the sentence, the moment and the robot.
  await page.reload();
  await page.locator(".explained .verdict", { hasText: known.sentence }).waitFor();
  await says(page, `epoch ${longest.epoch} · step ${longest.epoch_step} of`);
  assert.deepEqual(wrong, []);
  await page.close();
});

test("a stretch that cannot be recorded is refused at its place, and nothing else breaks", async () => {
  const { page, wrong } = await openPage(browser, server, { expected: ["422"] });
  await page.goto(`${server.url}/#/runs/${runs[0].id}`);
  await page.locator("summary", { hasText: "Record a stretch" }).click();
  await page.getByLabel("From epoch").fill("100000");
  await page.getByRole("button", { name: "Record", exact: true }).click();
  await page.locator("#alert", { hasText: /epoch/ }).waitFor();
  await assertWell(page, "refused recording");
  assert.deepEqual(wrong, []);
  await page.close();
});
