// Buttons that take a chart along: as SVG, as PNG, and the figures behind it as CSV.

import { h } from "../dom";

export interface Sources {
  svg?: () => string | SVGSVGElement | null;
  png?: () => HTMLCanvasElement | null;
  csv?: () => string;
  /** What it says, for a paper. */
  sentence?: () => string;
}

export function savers(name: string, sources: Sources): HTMLElement {
  const button = (kind: string, save: () => void): HTMLElement => {
    const element = h("button", { type: "button", "aria-label": `${name} as ${kind}` }, kind);
    element.addEventListener("click", save);
    return element;
  };
  const text = (kind: string, content: string): string => `data:${kind};charset=utf-8,${encodeURIComponent(content)}`;
  const { svg, png, csv, sentence } = sources;
  return h(
    "p",
    { class: "savers" },
    svg ? button("SVG", () => {
      const drawing = svg();
      if (drawing) download(`${name}.svg`, text("image/svg+xml", typeof drawing === "string" ? drawing : standalone(drawing)));
    }) : null,
    png ? button("PNG", () => {
      const canvas = png();
      if (canvas) download(`${name}.png`, canvas.toDataURL("image/png"));
    }) : svg ? button("PNG", () => {
      const drawing = svg();
      if (drawing) rasterize(`${name}.png`, typeof drawing === "string" ? drawing : standalone(drawing));
    }) : null,
    csv ? button("CSV", () => download(`${name}.csv`, text("text/csv", csv()))) : null,
    sentence ? button("sentence", () => void navigator.clipboard.writeText(sentence())) : null,
  );
}

export function download(name: string, href: string): void {
  h("a", { download: name, href }).click();
}

/** A drawing of the page with the styles that it has there, on its own. */
export function standalone(drawing: SVGSVGElement): string {
  const copy = drawing.cloneNode(true) as SVGSVGElement;
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  const [from, to] = [drawing, copy].map((root) => [root, ...root.querySelectorAll<SVGElement>("*")]);
  from!.forEach((element, n) => {
    const style = getComputedStyle(element);
    for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "font-size", "font-family", "font-weight", "fill-opacity"]) {
      to![n]!.setAttribute(name, style.getPropertyValue(name));
    }
  });
  return new XMLSerializer().serializeToString(copy);
}

function rasterize(name: string, drawing: string): void {
  const image = new Image();
  image.addEventListener("load", () => {
    const canvas = document.createElement("canvas");
    canvas.width = image.width * 2 || 1440;
    canvas.height = image.height * 2 || 840;
    canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
    download(name, canvas.toDataURL("image/png"));
  });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(drawing)}`;
}
