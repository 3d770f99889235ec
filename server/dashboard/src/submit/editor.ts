// The arena editor: walls, starts and objects are drawn; the server says while one draws what robots
// can reach and which gates are about as wide as they are.

import { h, show, svg, write } from "../dom";
import { post, Problem } from "../server";
import type { Arena, ArenaCheck, ArenaObject, Pose } from "../types";
import { whole } from "../words";

type Tool = "wall" | "start" | "box" | "disc" | "erase";
const TOOLS: [Tool, string][] = [["wall", "Wall"], ["start", "Start"], ["box", "Box"], ["disc", "Disc"], ["erase", "Erase"]];
const CHECK_AFTER_MS = 350;
const RADIUS_M = 0.037;
const UNDO = 100;
const SVG_WIDTH = 640;

export interface ArenaEditor {
  element: HTMLElement;
  show(arena: Arena | null, editable: boolean): void;
  stop(): void;
}

export function arenaEditor(onChange: (arena: Arena) => void, onCopy: () => void): ArenaEditor {
  let arena: Arena | null = null;
  let editable = false;
  let tool: Tool = "wall";
  let check: ArenaCheck | null = null;
  let from: { x: number; y: number } | null = null;
  let to: { x: number; y: number } | null = null;
  const undone: string[] = [];
  const drawing = svg("svg", { class: "editor", role: "img", tabindex: 0 });
  const said = h("p", { class: "facts", role: "status" });
  const wrong = h("p", { class: "bad", hidden: true });
  const copy = h("button", { type: "button" }, "Draw on a copy");
  copy.addEventListener("click", onCopy);
  const tools = h("fieldset", { class: "tools" }, h("legend", {}, "Draw"), ...TOOLS.map(([name, title]) => {
    const radio = h("input", { type: "radio", name: "tool", value: name, checked: name === tool });
    radio.addEventListener("change", () => { tool = name; });
    return h("label", {}, radio, ` ${title}`);
  }));
  const grid = h("select", { id: "snap" }, ...["0.01", "0.05", "0.1"].map((step) => h("option", { value: step, selected: step === "0.05" }, `${step} m`)));
  const width = h("input", { id: "arena-width", inputmode: "decimal", size: 5 });
  const height = h("input", { id: "arena-height", inputmode: "decimal", size: 5 });
  const undo = h("button", { type: "button", disabled: true }, "Undo");
  const parts = h("ul", { class: "plain parts" });
  const sizes = h("p", { class: "tools" },
    h("label", { for: "arena-width" }, "Width, m"), width, h("label", { for: "arena-height" }, "Height, m"), height,
    h("label", { for: "snap" }, "Snap to"), grid, undo);
  const listed = h("details", {}, h("summary", {}, "Parts, to remove by keyboard"), parts);
  const element = h("section", { "aria-labelledby": "editor-title" },
    h("h3", { id: "editor-title" }, "Arena"), tools, sizes, copy,
    h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Drawing of the arena" }, drawing), said, wrong, listed);

  const change = (next: Arena): void => {
    undone.push(JSON.stringify(arena));
    if (undone.length > UNDO) undone.shift();
    undo.disabled = false;
    arena = next;
    draw();
    ask();
    onChange(next);
  };
  undo.addEventListener("click", () => {
    const before = undone.pop();
    undo.disabled = undone.length === 0;
    if (!before) return;
    arena = JSON.parse(before) as Arena;
    draw();
    ask();
    onChange(arena);
  });
  const resize = (): void => {
    const [w, t] = [Number(width.value), Number(height.value)];
    if (arena && w > 0 && t > 0 && (w !== arena.width_m || t !== arena.height_m)) change({ ...arena, width_m: w, height_m: t });
  };
  width.addEventListener("change", resize);
  height.addEventListener("change", resize);

  const snapped = (event: PointerEvent): { x: number; y: number } => {
    const box = drawing.getBoundingClientRect();
    const a = arena!;
    const step = Number(grid.value);
    const round = (value: number, most: number): number => Math.min(Math.max(0, Number((Math.round(value / step) * step).toFixed(4))), most);
    return {
      x: round(((event.clientX - box.left) / box.width) * a.width_m, a.width_m),
      y: round((1 - (event.clientY - box.top) / box.height) * a.height_m, a.height_m),
    };
  };
  drawing.addEventListener("pointerdown", (event) => {
    if (!arena || !editable) return;
    event.preventDefault();
    drawing.setPointerCapture(event.pointerId);
    from = to = snapped(event);
    draw();
  });
  drawing.addEventListener("pointermove", (event) => {
    if (!from) return;
    to = snapped(event);
    draw();
  });
  drawing.addEventListener("pointerup", (event) => {
    if (!arena || !from) return;
    const [a, b] = [from, snapped(event)];
    from = to = null;
    const heading_rad = Number(Math.atan2(b.y - a.y, b.x - a.x).toFixed(4));
    if (tool === "wall") {
      if (a.x !== b.x || a.y !== b.y) change({ ...arena, walls_m: [...(arena.walls_m ?? []), [a.x, a.y, b.x, b.y]] });
    } else if (tool === "start") {
      change({ ...arena, starts: [...arena.starts, { x_m: a.x, y_m: a.y, heading_rad }] });
    } else if (tool === "erase") {
      erase(a);
    } else {
      const object: ArenaObject = tool === "box"
        ? { kind: "box", x_m: a.x, y_m: a.y, heading_rad, width_m: 0.06, height_m: 0.06 }
        : { kind: "disc", x_m: a.x, y_m: a.y, radius_m: 0.03 };
      change({ ...arena, objects: [...(arena.objects ?? []), object] });
    }
    draw();
  });
  const erase = (at: { x: number; y: number }): void => {
    const a = arena!;
    const within = Math.max(a.width_m, a.height_m) / 30;
    const candidates: [number, () => Arena][] = [
      ...(a.walls_m ?? []).map((wall, n): [number, () => Arena] => [distance(at, wall), () => ({ ...a, walls_m: a.walls_m!.filter((_, m) => m !== n) })]),
      ...a.starts.map((start, n): [number, () => Arena] => [Math.hypot(start.x_m - at.x, start.y_m - at.y), () => ({ ...a, starts: a.starts.filter((_, m) => m !== n) })]),
      ...(a.objects ?? []).map((object, n): [number, () => Arena] => [Math.hypot(object.x_m - at.x, object.y_m - at.y), () => ({ ...a, objects: a.objects!.filter((_, m) => m !== n) })]),
    ];
    const nearest = candidates.sort(([one], [other]) => one - other)[0];
    if (nearest && nearest[0] <= within) change(nearest[1]());
  };

  let timer = 0;
  let asked = 0;
  const ask = (): void => {
    clearTimeout(timer);
    const number = ++asked;
    timer = window.setTimeout(() => {
      if (!arena) return;
      post<ArenaCheck>("/v1/checks/arena", JSON.stringify({ name: "drawn", ...arena })).then(
        (found) => {
          if (number !== asked) return;
          check = found;
          tell();
          draw();
        },
        (error) => {
          if (number !== asked) return;
          check = null;
          const problem = error instanceof Problem ? error.errors.map((one) => `${one.pointer} ${one.message}`).join("; ") || error.message : String(error);
          write(wrong, problem);
          show(wrong, true);
          write(said, "");
          draw();
        },
      );
    }, CHECK_AFTER_MS);
  };
  const tell = (): void => {
    show(wrong, false);
    if (!check) return;
    const rows = check.reachable_rows;
    const all = rows.length * (rows[0]?.length ?? 0);
    const closed = check.gates.filter((gate) => !gate.is_open);
    const narrow = check.gates.length - closed.length;
    write(
      said,
      `A robot can reach ${whole(check.arena.reachable)} of ${whole(all)} squares` +
        (closed.length ? `; ${whole(closed.length)} gates are too narrow, the widest ${Math.round(Math.max(...closed.map((gate) => gate.width_m)) * 1000)} mm of ${RADIUS_M * 2000} mm` : "") +
        (narrow ? `; ${whole(narrow)} gates are just passed` : "") + ".",
    );
  };

  const draw = (): void => {
    drawing.replaceChildren();
    show(listed, editable && arena !== null);
    if (!arena) return;
    const { width_m, height_m } = arena;
    const k = SVG_WIDTH / Math.max(width_m, height_m);
    const [w, t] = [width_m * k, height_m * k];
    drawing.setAttribute("viewBox", `-4 -4 ${w + 8} ${t + 8}`);
    drawing.setAttribute("width", String(w + 8));
    const x = (value: number): number => value * k;
    const y = (value: number): number => t - value * k;
    const add = (...nodes: SVGElement[]): void => drawing.append(...nodes);
    const hatch = svg("pattern", { id: "hatch", width: 6, height: 6, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" }, svg("line", { x1: 0, y1: 0, x2: 0, y2: 6, class: "hatch" }));
    add(svg("defs", {}, hatch), svg("rect", { x: 0, y: 0, width: w, height: t, class: "floor" }));
    if (check) {
      // Stretches of squares out of reach, a rectangle each.
      const rows = check.reachable_rows;
      rows.forEach((row, r) => {
        for (const match of row.matchAll(/0+/g)) {
          add(svg("rect", {
            x: ((match.index ?? 0) / row.length) * w, y: t - ((r + 1) / rows.length) * t,
            width: (match[0].length / row.length) * w, height: t / rows.length, fill: "url(#hatch)",
          }));
        }
      });
    }
    add(svg("rect", { x: 0, y: 0, width: w, height: t, class: "outline" }));
    for (const [x1, y1, x2, y2] of arena.walls_m ?? check?.walls_m ?? []) add(svg("line", { x1: x(x1!), y1: y(y1!), x2: x(x2!), y2: y(y2!), class: "wall" }));
    for (const start of arena.starts.slice(0, 500)) add(startMark(start, x, y, RADIUS_M * k));
    for (const object of arena.objects ?? []) add(objectMark(object, x, y, k));
    for (const gate of check?.gates ?? []) {
      add(svg("circle", { cx: x(gate.x_m), cy: y(gate.y_m), r: 9, class: gate.is_open ? "gate open" : "gate closed" },
        svg("title", {}, `${(gate.width_m * 1000).toFixed(1)} mm wide: ${gate.is_open ? "a robot just passes" : "too narrow"}`)));
    }
    if (from && to) add(svg("line", { x1: x(from.x), y1: y(from.y), x2: x(to.x), y2: y(to.y), class: "wall drawn" }));
    drawing.setAttribute("aria-label", `Arena of ${width_m} m by ${height_m} m with ${(arena.walls_m ?? check?.walls_m ?? []).length} walls, ${arena.starts.length} starts, ${(arena.objects ?? []).length} objects`);
    listParts();
  };
  const listParts = (): void => {
    if (!listed.open || !arena || !editable) return;
    const a = arena;
    const item = (text: string, removed: () => Arena): HTMLElement => {
      const button = h("button", { type: "button", "aria-label": `Remove ${text}` }, "Remove");
      button.addEventListener("click", () => change(removed()));
      return h("li", {}, `${text} `, button);
    };
    parts.replaceChildren(
      ...(a.walls_m ?? []).slice(0, 200).map((wall, n) => item(`wall ${wall.join(", ")}`, () => ({ ...a, walls_m: a.walls_m!.filter((_, m) => m !== n) }))),
      ...a.starts.slice(0, 200).map((start, n) => item(`start ${start.x_m}, ${start.y_m}`, () => ({ ...a, starts: a.starts.filter((_, m) => m !== n) }))),
      ...(a.objects ?? []).map((object, n) => item(`${object.kind} ${object.x_m}, ${object.y_m}`, () => ({ ...a, objects: a.objects!.filter((_, m) => m !== n) }))),
    );
  };
  listed.addEventListener("toggle", listParts);
  return {
    element,
    show: (next, canEdit) => {
      if (from) return;
      const isOther = JSON.stringify(next) !== JSON.stringify(arena);
      editable = canEdit;
      show(tools, canEdit);
      show(sizes, canEdit);
      show(copy, !canEdit && next !== null);
      show(element, next !== null);
      if (!isOther) return draw();
      arena = next;
      check = null;
      write(said, "");
      show(wrong, false);
      if (arena) {
        if (document.activeElement !== width) width.value = String(arena.width_m);
        if (document.activeElement !== height) height.value = String(arena.height_m);
        ask();
      }
      draw();
    },
    stop: () => clearTimeout(timer),
  };
}

function startMark(start: Pose, x: (v: number) => number, y: (v: number) => number, r: number): SVGElement {
  const [cx, cy] = [x(start.x_m), y(start.y_m)];
  return svg("g", { class: "start" },
    svg("circle", { cx, cy, r }),
    svg("line", { x1: cx, y1: cy, x2: cx + r * Math.cos(start.heading_rad), y2: cy - r * Math.sin(start.heading_rad) }));
}

function objectMark(object: ArenaObject, x: (v: number) => number, y: (v: number) => number, k: number): SVGElement {
  const [cx, cy] = [x(object.x_m), y(object.y_m)];
  const size = (name: string): number => Number(object[name] ?? 0) * k;
  if (object.kind === "disc") return svg("circle", { cx, cy, r: size("radius_m"), class: "object" });
  const [w, t] = [size("width_m"), size("height_m")];
  return svg("rect", { x: cx - w / 2, y: cy - t / 2, width: w, height: t, class: "object", transform: `rotate(${(-Number(object.heading_rad ?? 0) * 180) / Math.PI} ${cx} ${cy})` });
}

/** From a point to a wall, metres. */
export function distance(point: { x: number; y: number }, [x1, y1, x2, y2]: readonly [number, number, number, number]): number {
  const [dx, dy] = [x2 - x1, y2 - y1];
  const length = dx * dx + dy * dy;
  const t = length === 0 ? 0 : Math.min(1, Math.max(0, ((point.x - x1) * dx + (point.y - y1) * dy) / length));
  return Math.hypot(point.x - x1 - t * dx, point.y - y1 - t * dy);
}
