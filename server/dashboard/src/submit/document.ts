// A job's document as the form sees it: fields by dotted path, of which one that has several values
// stands in the matrix. What the form does not know stays as it is.

export type Json = Record<string, unknown>;

const isObject = (value: unknown): value is Json => typeof value === "object" && value !== null && !Array.isArray(value);

/** The values of a run spec's field in a job: those of the matrix, else that of the base. */
export function valuesAt(job: Json, path: string): unknown[] {
  const matrix = job["matrix"];
  if (isObject(matrix) && Array.isArray(matrix[path])) return matrix[path] as unknown[];
  const value = at(job["base"], path);
  return value === undefined ? [] : [value];
}

/** The same job with other values of a field: none leaves it to its default, several are varied. */
export function withValues(job: Json, path: string, values: unknown[]): Json {
  const next = structuredClone(job);
  const matrix = isObject(next["matrix"]) ? next["matrix"] : {};
  delete matrix[path];
  if (values.length > 1) matrix[path] = values;
  if (Object.keys(matrix).length > 0) next["matrix"] = matrix;
  else delete next["matrix"];
  const base = isObject(next["base"]) ? next["base"] : {};
  put(base, path.split("."), values.length === 1 ? values[0] : undefined);
  next["base"] = base;
  return next;
}

/** The field of a pointer into a job, as a dotted path: of the base or of the matrix. */
export function pathOf(pointer: string): string {
  const [root, ...rest] = pointer.split("/").slice(1).map((part) => part.replaceAll("~1", "/").replaceAll("~0", "~"));
  if (root === "matrix") return rest[0] ?? "";
  if (root === "base") return rest.join(".");
  return [root, ...rest].join(".");
}

/** The path of this list that a dotted path lies in: the longest that it begins with. */
export function fieldOf(path: string, fields: readonly string[]): string | null {
  const holding = fields.filter((field) => path === field || path.startsWith(`${field}.`));
  return holding.sort((a, b) => b.length - a.length)[0] ?? null;
}

/** A text of a form as values: numbers where they are, words else, separated by commas. */
export function parseValues(text: string): unknown[] {
  return text.split(",").map((part) => part.trim()).filter(Boolean).map((part) => {
    const number = Number(part);
    if (Number.isFinite(number)) return number;
    return { true: true, false: false, null: null }[part] ?? (part === "null" ? null : part);
  });
}

function at(value: unknown, path: string): unknown {
  let here = value;
  for (const name of path.split(".")) {
    if (!isObject(here)) return undefined;
    here = here[name];
  }
  return here;
}

function put(object: Json, path: string[], value: unknown): void {
  const [name, ...rest] = path;
  if (name === undefined) return;
  if (rest.length === 0) {
    if (value === undefined) delete object[name];
    else object[name] = value;
    return;
  }
  const inner = isObject(object[name]) ? object[name] : {};
  put(inner, rest, value);
  if (Object.keys(inner).length > 0) object[name] = inner;
  else delete object[name];
}
