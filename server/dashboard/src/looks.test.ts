/// <reference types="vite/client" />
import { expect, it } from "vitest";
import { LOOKS, heat, look } from "./looks";
import style from "./style.css?raw";

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

it("stands out from the floor of either theme, whatever the share", () => {
  const linear = (value: number): number => (value <= 10.31475 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  const luminance = ([r, g, b]: readonly [number, number, number]): number => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const floors = /--floor: light-dark\(#(\w{6}), #(\w{6})\)/.exec(style)!.slice(1)
    .map((hex) => luminance([0, 2, 4].map((at) => Number.parseInt(hex.slice(at, at + 2), 16)) as [number, number, number]));
  for (const isDark of [false, true]) {
    const floor = floors[Number(isDark)]!;
    for (let share = 0; share <= 1; share += 1 / 255) {
      const [low, high] = [floor, luminance(heat(share, isDark))].sort((a, b) => a - b);
      expect((high! + 0.05) / (low! + 0.05), `${share} ${isDark}`).toBeGreaterThan(1.5);
    }
  }
});
