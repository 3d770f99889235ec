// How fluid a thousand robots are: pictures a second, what each takes, and how busy the page's main
// thread is. For a quiet machine and a server built for speed: `npm run rate`, SECONDS=20 by default.

import { openPage, startBrowser, startServer } from "./setup.mjs";

const SECONDS = Number(process.env.SECONDS ?? 20);
const [browser, server] = await Promise.all([startBrowser(), startServer()]);
try {
  const cold = await openPage(browser, server);
  const begun = performance.now();
  await cold.page.goto(server.url);
  await cold.page.getByRole("heading", { name: "No jobs yet" }).waitFor();
  const paint = await cold.page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime);
  console.log(`first paint: ${Math.round(paint)} ms; first screen complete: ${Math.round(performance.now() - begun)} ms`);
  await cold.page.close();
  const job = await server.post("/v1/jobs", {
    name: "a thousand robots",
    base: {
      arena: { from: "easy", tile: [10, 10] }, robots: 1_000, placement: "grid",
      epochs: 100_000, steps_per_epoch: 2_000, controller: { method: "brownian" },
    },
  });
  const run = await server.firstRun(job);
  for (const show of ["robots trails", "robots rays trails"]) {
    const { page, wrong } = await openPage(browser, server);
    await page.addInitScript(() => {
      window.long = [];
      new PerformanceObserver((list) => window.long.push(...list.getEntries().map((entry) => entry.duration))).observe({ entryTypes: ["longtask"] });
    });
    await page.goto(`${server.url}/#/runs/${run.id}?${new URLSearchParams({ show })}`);
    await page.locator(".moment", { hasText: "pictures/s" }).waitFor();
    const session = await page.context().newCDPSession(page);
    // Processor time, which hardly depends on who else uses the machine.
    await session.send("Performance.enable", { timeDomain: "threadTicks" });
    const processes = await browser.newBrowserCDPSession();
    const look = async () => ({
      ...(await page.evaluate(() => ({ ...document.querySelector("article.run").drawn, at: performance.now(), long: window.long.splice(0) }))),
      all_s: (await processes.send("SystemInfo.getProcessInfo")).processInfo.reduce((sum, one) => sum + one.cpuTime, 0),
      busy_s: (await session.send("Performance.getMetrics")).metrics.find((one) => one.name === "TaskDuration").value,
    });
    const first = await look();
    await page.waitForTimeout(SECONDS * 1_000);
    const last = await look();
    const seconds = (last.at - first.at) / 1_000;
    const pictures = last.pictures - first.pictures;
    console.log(
      `${show}: ${(pictures / seconds).toFixed(1)} pictures/s, ${((last.ms - first.ms) / pictures).toFixed(1)} ms drawing each, ` +
        `processor time a picture: main thread ${((1e3 * (last.busy_s - first.busy_s)) / pictures).toFixed(1)} ms, ` +
        `whole browser ${((1e3 * (last.all_s - first.all_s)) / pictures).toFixed(1)} ms; ${last.long.length} tasks above 50 ms` +
        `${last.long.length ? `, the longest ${Math.round(Math.max(...last.long))} ms` : ""}`,
    );
    if (wrong.length) console.log(wrong.join("\n"));
    await page.close();
  }
} finally {
  await browser.close();
  await server.stop();
}
