// What the chosen robot senses, as bars round its body, and what it does with its wheels.

import { h, svg, write } from "../dom";
import { MOST, MOUNTS } from "./body";
import { COMMANDS, FLOATS, SENSORS, WORDS, type Frame } from "./messages";

export interface Senses {
  element: HTMLElement;
  draw(frame: Frame, robot: number): void;
}

const SIZE = 180;
const BODY = 44;
const LONGEST = 40;

export function senses(): Senses {
  const bars: SVGLineElement[] = [];
  const drawing = svg("svg", { viewBox: `0 0 ${SIZE} ${SIZE}`, role: "img", class: "senses", "aria-label": "What a robot senses" });
  const centre = SIZE / 2;
  // The heading points up.
  const at = (angle: number, r: number): [number, number] => [
    centre - r * Math.sin(angle), centre - r * Math.cos(angle),
  ];
  drawing.append(svg("circle", { cx: centre, cy: centre, r: BODY, class: "body" }));
  drawing.append(svg("line", { x1: centre, y1: centre - BODY + 14, x2: centre, y2: centre - BODY, class: "nose" }));
  MOUNTS.forEach((mount, n) => {
    const angle = mount.heading_rad;
    const [x1, y1] = at(angle, BODY + 3);
    const [tx, ty] = at(angle, BODY - 11);
    const bar = svg("line", { x1, y1, x2: x1, y2: y1, class: "bar" });
    bars.push(bar);
    drawing.append(
      svg("line", { x1, y1, x2: at(angle, BODY + 3 + LONGEST)[0], y2: at(angle, BODY + 3 + LONGEST)[1], class: "rail" }),
      bar,
      svg("text", { x: tx, y: ty + 4, "text-anchor": "middle", class: "tick" }, String(n)),
    );
  });
  const wheels = [-1, 1].map((side) => {
    const x = centre + side * 18;
    drawing.append(svg("line", { x1: x, x2: x, y1: centre - 16, y2: centre + 16, class: "rail" }));
    const wheel = svg("line", { x1: x, x2: x, y1: centre, y2: centre, class: "wheel" });
    drawing.append(wheel);
    return wheel;
  });
  const text = h("figcaption", { class: "facts" });
  const element = h("figure", { hidden: true }, h("h3", {}, "What it senses and does"), drawing, text);
  return {
    element,
    draw: (frame, robot) => {
      element.hidden = robot >= frame.robots;
      if (robot >= frame.robots) return;
      const values = Array.from(frame.words.subarray(robot * WORDS + SENSORS, robot * WORDS + SENSORS + 8));
      values.forEach((value, n) => {
        const [x, y] = at(MOUNTS[n]!.heading_rad, BODY + 3 + (LONGEST * value) / MOST);
        bars[n]!.setAttribute("x2", x.toFixed(1));
        bars[n]!.setAttribute("y2", y.toFixed(1));
      });
      const commands = Array.from(frame.floats.subarray(robot * FLOATS + COMMANDS, robot * FLOATS + COMMANDS + 2));
      commands.forEach((command, n) => wheels[n]!.setAttribute("y2", (centre - command * 16).toFixed(1)));
      write(text, `ps0 to ps7: ${values.join(", ")} of 4095; wheels ${commands.map((c) => c.toFixed(2)).join(", ")} of top speed`);
      drawing.setAttribute("aria-label", text.textContent ?? "");
    },
  };
}
