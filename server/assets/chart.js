// Coverage curves as SVG: a thin line a run, a thick one for the median of each group.

// Widths follow the figure, so that text keeps its size on a phone.
const VIEW = { width: 760, height: 330, left: 62, right: 28, top: 12, bottom: 42 };
const [NARROWEST, WIDEST] = [300, 1000];
const COLOURS = 6;

const NS = "http://www.w3.org/2000/svg";
const whole = new Intl.NumberFormat("en");

function make(tag, attributes, text) {
  const element = document.createElementNS(NS, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

// 1, 2 or 5 times a power of ten, at most `count` steps up to `top`.
function step(top, count) {
  const power = 10 ** Math.floor(Math.log10(top / count || 1));
  return Math.max(1, [1, 2, 5, 10].map((n) => n * power).find((n) => top / n <= count) ?? 1);
}

// Value of a curve at an epoch: that of the last row not after it; `undefined` outside the curve.
function at(rows, epoch) {
  if (rows.length === 0 || epoch < rows[0].epoch || epoch > rows.at(-1).epoch) return undefined;
  let [low, high] = [0, rows.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (rows[middle].epoch <= epoch) low = middle;
    else high = middle - 1;
  }
  return rows[low].p1;
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}

// The median as far as all curves of the group go.
function medianRows(curves) {
  const started = curves.filter((rows) => rows.length > 0);
  if (started.length < 2) return [];
  const longest = started.reduce((a, b) => (b.length > a.length ? b : a));
  return longest.flatMap(({ epoch }) => {
    const values = started.map((rows) => at(rows, epoch));
    return values.includes(undefined) ? [] : [{ epoch, p1: median(values) }];
  });
}

function grouped(runs) {
  const groups = new Map();
  for (const run of runs) {
    const group = groups.get(run.group) ?? { name: run.group, curves: [] };
    group.curves.push(run.rows);
    groups.set(run.group, group);
  }
  return [...groups.values()].map((group, place) => ({
    ...group, colour: `c${place % COLOURS}`, median: medianRows(group.curves),
  }));
}

// Draws runs, each `{group, epochs, rows}`, into a figure with an svg, a legend and a text.
export function drawChart(figure, runs) {
  const svg = figure.querySelector("svg");
  const groups = grouped(runs);
  const width = Math.round(Math.min(WIDEST, Math.max(NARROWEST, figure.clientWidth)));
  const drawn = JSON.stringify([width, runs.map((run) => [run.group, run.epochs, run.rows.at(-1), run.rows.length])]);
  if (svg.dataset.drawn === drawn) return;
  svg.dataset.drawn = drawn;
  VIEW.width = width;
  svg.setAttribute("viewBox", `0 0 ${VIEW.width} ${VIEW.height}`);
  const rows = runs.flatMap((run) => run.rows);
  const last = Math.max(2, ...runs.map((run) => Math.max(run.epochs, run.rows.at(-1)?.epoch ?? 0)));
  const most = Math.max(10, ...rows.map((row) => row.p1)) * 1.04;
  const x = (epoch) => VIEW.left + ((epoch - 1) / (last - 1)) * (VIEW.width - VIEW.left - VIEW.right);
  const y = (p1) => VIEW.height - VIEW.bottom - (p1 / most) * (VIEW.height - VIEW.top - VIEW.bottom);
  const path = (curve) => curve.map((row) => `${x(row.epoch).toFixed(1)},${y(row.p1).toFixed(1)}`).join(" ");

  const parts = axes(x, y, last, most);
  for (const { curves, colour } of groups) {
    for (const curve of curves) parts.push(make("polyline", { class: `run ${colour}`, points: path(curve) }));
  }
  for (const { curves, colour, median } of groups) {
    const thick = curves.length === 1 ? curves[0] : median;
    parts.push(make("polyline", { class: `median ${colour}`, points: path(thick) }));
  }
  const cursor = make("line", { class: "cursor", y1: VIEW.top, y2: VIEW.height - VIEW.bottom, visibility: "hidden" });
  svg.replaceChildren(...parts, cursor);
  legend(figure, groups, undefined);
  const text = figure.querySelector("#chart-text");
  text.textContent = rows.length
    ? `Squares entered at least once (p1), ${runs.length} ${runs.length === 1 ? "run" : "runs"}; thick lines are medians.`
    : "No counted epoch is complete yet.";
  follow(svg, (epoch) => {
    cursor.setAttribute("visibility", epoch === undefined ? "hidden" : "visible");
    if (epoch !== undefined) for (const end of ["x1", "x2"]) cursor.setAttribute(end, x(epoch));
    legend(figure, groups, epoch);
  }, (px) => Math.round(1 + ((px - VIEW.left) / (VIEW.width - VIEW.left - VIEW.right)) * (last - 1)), last);
}

function axes(x, y, last, most) {
  const [left, right] = [VIEW.left, VIEW.width - VIEW.right];
  const bottom = VIEW.height - VIEW.bottom;
  const parts = [];
  for (let p1 = 0; p1 <= most; p1 += step(most, 5)) {
    parts.push(make("line", { class: "gridline", x1: left, x2: right, y1: y(p1), y2: y(p1) }));
    parts.push(make("text", { x: left - 8, y: y(p1) + 4, "text-anchor": "end" }, whole.format(p1)));
  }
  const every = step(last, VIEW.width < 500 ? 4 : 8);
  for (let epoch = every === 1 ? 1 : every; epoch <= last; epoch += every) {
    parts.push(make("line", { class: "axis", x1: x(epoch), x2: x(epoch), y1: bottom, y2: bottom + 5 }));
    parts.push(make("text", { x: x(epoch), y: bottom + 19, "text-anchor": "middle" }, whole.format(epoch)));
  }
  parts.push(make("line", { class: "axis", x1: left, x2: right, y1: bottom, y2: bottom }));
  parts.push(make("text", { x: (left + right) / 2, y: VIEW.height - 6, "text-anchor": "middle" }, "epoch"));
  parts.push(make("text", { transform: `translate(14 ${(VIEW.top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, "p1 (squares)"));
  return parts;
}

function legend(figure, groups, epoch) {
  figure.querySelector("#legend").replaceChildren(...groups.map(({ name, colour, curves, median: middle }) => {
    const item = document.createElement("li");
    const line = document.createElement("i");
    line.className = colour;
    const rows = curves.length === 1 ? curves[0] : middle;
    const value = epoch === undefined ? rows.at(-1)?.p1 : at(rows, epoch);
    const where = epoch === undefined ? "" : ` at epoch ${whole.format(epoch)}`;
    const text = document.createElement("span");
    text.textContent = value === undefined ? name : `${name}: ${whole.format(value)}${where}`;
    item.append(line, text);
    return item;
  }));
}

// Tells which epoch the pointer is over, and when it leaves.
function follow(svg, tell, epochAt, last) {
  svg.onpointermove = (event) => {
    const box = svg.getBoundingClientRect();
    const epoch = epochAt(((event.clientX - box.left) / box.width) * VIEW.width);
    tell(epoch >= 1 && epoch <= last ? epoch : undefined);
  };
  svg.onpointerleave = () => tell(undefined);
}
