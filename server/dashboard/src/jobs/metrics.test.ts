import { expect, it } from "vitest";
import { parseMetrics } from "./metrics";

it("reads OpenMetrics by name and labels", () => {
  const found = parseMetrics([
    "# HELP evswarm_runs Runs by state.", "# TYPE evswarm_runs gauge",
    'evswarm_runs{state="done"} 12', 'evswarm_runs{state="failed"} 3',
    "evswarm_store_room_bytes 1.5e9", 'evswarm_http_request_seconds_bucket{le="+Inf",route="/x y"} 4', "# EOF",
  ].join("\n"));
  expect(found.get("evswarm_runs")).toEqual([["done", 12], ["failed", 3]]);
  expect(found.get("evswarm_store_room_bytes")).toEqual([["", 1.5e9]]);
  expect(found.get("evswarm_nothing")).toBeUndefined();
});
