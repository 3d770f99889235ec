// The address holds the whole view: `#/jobs/7?measure=p2&scale=log`. A link reproduces it.

export interface Route {
  view: "overview" | "job" | "run" | "new";
  id: string;
  options: URLSearchParams;
}

export function parse(hash: string): Route {
  const [path = "", query = ""] = hash.replace(/^#\/?/, "").split("?", 2);
  const options = new URLSearchParams(query);
  const [kind, id = ""] = path.split("/").map(decodeURIComponent);
  if (kind === "jobs" && id) return { view: "job", id, options };
  if (kind === "runs" && id) return { view: "run", id, options };
  if (kind === "new") return { view: "new", id: "", options };
  return { view: "overview", id: "", options };
}

export function link(view: Route["view"], id = "", options?: Record<string, string>): string {
  const query = new URLSearchParams(options).toString();
  const path = { overview: "", job: `jobs/${id}`, run: `runs/${id}`, new: "new" }[view];
  return `#/${path}${query ? `?${query}` : ""}`;
}

/** Changes one option of the present view, without a new entry in the history. */
export function choose(name: string, value: string | null): void {
  const { view, id, options } = parse(location.hash);
  if (value === null) options.delete(name);
  else options.set(name, value);
  history.replaceState(null, "", link(view, id, Object.fromEntries(options)));
}
