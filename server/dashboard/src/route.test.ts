import { expect, it } from "vitest";
import { link, parse } from "./route";

it("reads the addresses that it makes", () => {
  const route = parse(link("job", "7", { measure: "p2", hide: "a b" }));
  expect([route.view, route.id, route.options.get("hide")]).toEqual(["job", "7", "a b"]);
  expect(parse(link("run", "ab12")).id).toBe("ab12");
  expect(parse(link("new")).view).toBe("new");
  for (const other of ["", "#", "#/", "#/nowhere/3", "#/jobs/"]) {
    expect(parse(other).view).toBe("overview");
  }
});
