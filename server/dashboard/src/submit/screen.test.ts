import { expect, it, vi } from "vitest";

vi.mock("../main", () => ({ trouble: () => undefined, calm: () => undefined }));
const { runCount } = await import("./screen");

it("counts the runs of a document", () => {
  const job = { matrix: { a: [1, 2], "b+c": [[1, 2]] }, seeds: { first: 1, count: 5 } };
  expect(runCount(JSON.stringify(job))).toBe(10);
  expect(runCount('{"seeds": [3, 4]}')).toBe(2);
  expect(runCount("{}")).toBe(1);
  expect(runCount("{")).toBe(null);
  expect(runCount('{"template": "chapter-5"}')).toBe(null);
});
