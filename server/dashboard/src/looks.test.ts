import { expect, it } from "vitest";
import { LOOKS, heat, look } from "./looks";

it("gives every group a look of its own for as long as there are any", () => {
  const looks = Array.from({ length: LOOKS }, (_, place) => JSON.stringify(look(place)));
  expect(new Set(looks).size).toBe(LOOKS);
  expect(look(LOOKS)).toEqual(look(0));
});

it("rises in lightness", () => {
  const light = (share: number): number => {
    const [r, g, b] = heat(share);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  for (let share = 0; share < 1; share += 0.01) {
    expect(light(share + 0.01)).toBeGreaterThanOrEqual(light(share) - 0.5);
  }
  expect(heat(-1)).toEqual(heat(0));
  expect(heat(2)).toEqual(heat(1));
});
