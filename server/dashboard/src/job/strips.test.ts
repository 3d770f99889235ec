import { expect, it } from "vitest";
import { parse } from "./strips";

it("reads CSV with quotes and empty fields", () => {
  expect(parse('run,label,p1\na,"alpha 0.5, eta 1",3\nb,,\nc,"say ""hi""",4\n')).toEqual([
    { run: "a", label: "alpha 0.5, eta 1", p1: "3" },
    { run: "b", label: "", p1: "" },
    { run: "c", label: 'say "hi"', p1: "4" },
  ]);
});
