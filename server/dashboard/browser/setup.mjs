// A real server and a real browser for the tests: both on this machine alone, ended with them.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import axe from "axe-core";
import { chromium } from "playwright-core";

const repository = join(dirname(fileURLToPath(import.meta.url)), "../../..");
const program = join(process.env.CARGO_TARGET_DIR ?? join(repository, "target"), "release/evswarm");

/** Starts `evswarm serve`, with a token that changes and another that only reads; `stop` ends it, `again` starts it anew on the same data and port. */
export async function startServer({ token, reader, args = [], data = mkdtempSync(join(tmpdir(), "dashboard-")), port = 0 } = {}) {
  if (!existsSync(program)) throw new Error(`${program} is missing: run \`make build\` before`);
  const environment = { ...process.env, XDG_RUNTIME_DIR: data, RUST_LOG: "error" };
  delete environment.EVSWARM_TOKEN;
  if (token) environment.EVSWARM_TOKEN = token;
  const child = spawn(
    program,
    ["serve", "--listen", `127.0.0.1:${port}`, "--data", join(data, "data"), "--threads", "2", ...(reader ? ["--tokens", readers(data, reader)] : []), ...args],
    { env: environment, stdio: ["ignore", "pipe", "inherit"] },
  );
  const line = await new Promise((resolve, reject) => {
    createInterface({ input: child.stdout }).once("line", resolve);
    child.once("exit", (code) => reject(new Error(`the server ended with ${code}`)));
  });
  const url = line.replace(/.*(http:\S+?)\/?$/, "$1");
  const end = () =>
    new Promise((resolve) => {
      if (child.exitCode !== null) return resolve();
      child.once("exit", resolve);
      child.kill("SIGTERM");
    });
  return {
    url,
    end,
    stop: async () => {
      await end();
      rmSync(data, { recursive: true, force: true });
    },
    again: async () => {
      await end();
      return startServer({ token, reader, args, data, port: Number(new URL(url).port) });
    },
    post: async (path, body) => {
      const headers = { "content-type": "application/json", ...(token && { authorization: `Bearer ${token}` }) };
      const answer = await fetch(url + path, { method: "POST", headers, body: JSON.stringify(body) });
      if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
      return answer.json();
    },
    read: async (path) => (await fetch(url + path)).json(),
    /** Waits until a job has ended; returns its state. */
    ended: async (job) => {
      for (;;) {
        const { state } = await (await fetch(`${url}/v1/jobs/${job.id}`)).json();
        if (["done", "failed", "cancelled"].includes(state)) return state;
        await new Promise((resolve) => setTimeout(resolve, 100));
      }
    },
    /** The first run of a job. */
    firstRun: async (job) => (await (await fetch(`${url}/v1/jobs/${job.id}/runs?limit=1`)).json()).items[0],
  };
}

/** The file of a token that only reads. */
function readers(folder, token) {
  const file = join(folder, "tokens");
  writeFileSync(file, `reader read sha256:${createHash("sha256").update(token).digest("hex")}\n`, { mode: 0o600 });
  return file;
}

export async function startBrowser() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: [
      "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync",
    ],
  });
}

/**
 * A page that notes what must not happen: errors of scripts, messages on the console, and requests
 * that leave the server.
 */
export async function openPage(browser, server, { expected = [], ...options } = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  // Builds may use the machine beside the tests.
  page.setDefaultTimeout(90_000);
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(`error: ${error.message}`));
  page.on("console", (message) => {
    const text = `${message.text()} ${message.location().url ?? ""}`;
    if (["error", "warning"].includes(message.type()) && !expected.some((one) => text.includes(one))) {
      wrong.push(`console: ${text}`);
    }
  });
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(server.url) && !/^(data|blob):/.test(url)) wrong.push(`leaves: ${url}`);
  });
  // The built files of a folder (`dist` where it says 1) instead of those inside the binary, to work
  // on the page without building it, or to measure two of them beside each other.
  if (process.env.FRESH) await fresh(page, server);
  return { page, wrong };
}

/** Findings of axe that are serious or worse, in words. */
export async function barriers(page) {
  await page.evaluate(axe.source);
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  return found.violations
    .filter((one) => ["serious", "critical"].includes(one.impact))
    .map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(", ")}`);
}

/** Screenshots go to this folder when it is named. */
export async function picture(page, name, shown) {
  if (!process.env.PICTURES) return;
  if (shown) await shown.scrollIntoViewIfNeeded();
  else await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({ path: join(process.env.PICTURES, `dashboard-${name}.png`) });
}

/** That a screen has no barrier and nothing that stands out of the window. */
export async function assertWell(page, name) {
  assert.deepEqual(await barriers(page), [], name);
  const { scroll, width } = await page.evaluate(() => ({
    scroll: document.documentElement.scrollWidth,
    width: document.documentElement.clientWidth,
  }));
  assert.ok(scroll <= width, `${name} is ${scroll} wide on ${width}`);
}

async function fresh(page, server) {
  const folder = process.env.FRESH === "1" ? join(repository, "server/dashboard/dist") : process.env.FRESH;
  for (const [path, file] of [["/", "index.html"], ["/dashboard.js", "dashboard.js"], ["/dashboard.css", "dashboard.css"]]) {
    await page.route(server.url + path, async (route) => {
      const body = readFileSync(join(folder, file), "utf8");
      await route.fulfill({ response: await route.fetch(), body });
    });
  }
}
