import { describe, expect, it } from "vitest";
import { bytes, duration, figure, pace } from "./words";

describe("words", () => {
  it("gives numbers the digits that they need", () => {
    expect([516, 516.4, 51.64, 0.05164, null, Number.NaN].map(figure)).toEqual([
      "516", "516", "51.6", "0.0516", "–", "–",
    ]);
  });
  it("says times and sizes", () => {
    expect([3, 200, 9000, 400000].map(duration)).toEqual(["3 s", "3 min", "2.5 h", "4.6 days"]);
    expect([500, 20480, 3e7].map(bytes)).toEqual(["500 B", "20.0 KiB", "28.6 MiB"]);
    expect(pace({ robot_steps_per_s: 8_130_000, eta_s: 12 })).toBe("8.13M robot-steps/s · 12 s left");
    expect(pace({ robot_steps_per_s: null, eta_s: null })).toBe("");
  });
});
