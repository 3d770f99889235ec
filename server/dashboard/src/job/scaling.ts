// How coverage times change with the number of robots: log-log, with the fitted slope.

import { h, show, svg, write } from "../dom";
import { look } from "../looks";
import { savers } from "../charts/save";
import type { Scaling } from "../types";
import { figure, whole } from "../words";
import { plain } from "./groups";

const WIDTH = 480;
const HEIGHT = 300;
const TIMES = ["t50_steps", "t90_steps", "t99_steps"];

export function scalingPlots() {
  const plots = h("div", { class: "strips wide" });
  const element = h("section", { hidden: true }, h("h3", {}, "Scaling over robots"), plots);
  return {
    element,
    draw: (all: Scaling[]): void => {
      const some = all.filter((one) => one.points.length > 1);
      show(element, some.length > 0);
      plots.replaceChildren(...some.slice(0, 12).map(plot));
    },
  };
}

function plot(scaling: Scaling): HTMLElement {
  const title = Object.entries(scaling.values).map(([path, value]) => `${path.split(".").at(-1)} ${plain(value)}`).join(", ") || "all runs";
  const points = TIMES.flatMap((name, place) =>
    scaling.points.flatMap((point) => {
      const time = point.times.find((one) => one.name === name);
      return time?.mean_steps ? [{ name, place, robots: point.robots, steps: time.mean_steps, n: time.n }] : [];
    }),
  );
  const text = h("figcaption", { class: "facts" });
  const figureElement = h("figure", {});
  if (points.length === 0) {
    figureElement.append(h("p", { class: "quiet" }, `${title}: no run got to half of the squares.`));
    return figureElement;
  }
  const span = (list: number[]): [number, number] => [Math.min(...list), Math.max(...list)];
  const [x0, x1] = span(points.map((point) => point.robots));
  // A line is drawn as far as there are runs that got there.
  const lines = TIMES.flatMap((name, place) => {
    const fit = scaling.fits.find((one) => one.name === name);
    const own = points.filter((point) => point.name === name);
    if (!fit || own.length === 0) return [];
    const ends = span(own.map((point) => point.robots)).map((robots) => ({ robots, steps: fit.a * robots ** -fit.b }));
    return [{ name, place, fit, ends }];
  });
  const [low, high] = span([...points, ...lines.flatMap((line) => line.ends)].map((point) => point.steps));
  const [y0, y1] = [low / 1.2, high * 1.2];
  const onto = (value: number, from: number, to: number): number => (Math.log(value) - Math.log(from)) / (Math.log(to) - Math.log(from) || 1);
  const x = (robots: number): number => 70 + onto(robots, x0, x1) * (WIDTH - 100);
  const y = (steps: number): number => HEIGHT - 40 - onto(steps, y0, y1) * (HEIGHT - 70);
  const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
  drawing.append(svg("text", { x: 0, y: 14, class: "name" }, title));
  for (const robots of new Set(points.map((point) => point.robots))) {
    drawing.append(
      svg("line", { x1: x(robots), x2: x(robots), y1: 26, y2: HEIGHT - 40, class: "rail" }),
      svg("text", { x: x(robots), y: HEIGHT - 22, "text-anchor": "middle", class: "tick" }, whole(robots)),
    );
  }
  for (const share of [0, 0.5, 1]) {
    const steps = y0 * (y1 / y0) ** share;
    drawing.append(svg("text", { x: 62, y: y(steps) + 4, "text-anchor": "end", class: "tick" }, whole(Number(steps.toPrecision(2)))));
  }
  drawing.append(svg("text", { x: WIDTH / 2, y: HEIGHT - 4, "text-anchor": "middle", class: "tick" }, "robots (log)"));
  for (const { name, place, robots, steps, n } of points) {
    drawing.append(svg("circle", { cx: x(robots), cy: y(steps), r: 4, fill: look(place).colour },
      svg("title", {}, `${name}, ${robots} robots: ${whole(steps)} steps, n ${n}`)));
  }
  const said = lines.map(({ name, place, fit, ends }) => {
    const { colour, dash } = look(place);
    const [from, to] = ends as [typeof ends[0], typeof ends[0]];
    const short = name.replace("_steps", "");
    const line = svg("line", { x1: x(from!.robots), x2: x(to!.robots), y1: y(from!.steps), y2: y(to!.steps), stroke: colour, "stroke-width": 2 });
    if (dash.length) line.setAttribute("stroke-dasharray", dash.join(" "));
    drawing.append(line, svg("text", { x: x(to!.robots) + 8, y: y(to!.steps) + 4, class: "tick halo" }, short));
    const interval = fit.b_interval ? ` [${figure(fit.b_interval.low)}, ${figure(fit.b_interval.high)}]` : "";
    return `${short} ~ N^-${figure(fit.b)}${interval}, n = ${fit.n}${fit.missed ? `, ${fit.missed} never got there` : ""}`;
  });
  write(text, `${said.join("; ")}. With exponent 1 twice the robots take half the time; intervals of 95 %.`);
  drawing.setAttribute("aria-label", `${title}: ${text.textContent}`);
  const csv = (): string => ["time,robots,mean_steps,n", ...points.map((point) => [point.name, point.robots, point.steps, point.n].join(","))].join("\n");
  figureElement.append(drawing, text, savers("scaling", { svg: () => drawing, csv }));
  return figureElement;
}
