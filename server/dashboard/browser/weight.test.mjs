// The page stays light: below 250 kB compressed, everything together.

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

test("all files of the page together are below 250 kB compressed", () => {
  const dist = fileURLToPath(new URL("../dist", import.meta.url));
  const sizes = readdirSync(dist).map((name) => gzipSync(readFileSync(join(dist, name))).length);
  const sum = sizes.reduce((one, other) => one + other, 0);
  assert.ok(sum < 250_000, `${sum} bytes`);
});
