// OpenMetrics text of `/metrics`, as far as the page shows it: gauges with at most one label.

export type Metrics = Map<string, [label: string, value: number][]>;

export function parseMetrics(text: string): Metrics {
  const found: Metrics = new Map();
  for (const line of text.split("\n")) {
    const [, name, label, value] = /^(\w+)(?:\{\w+="([^"]*)"\})? (\S+)$/.exec(line) ?? [];
    if (name === undefined || value === undefined) continue;
    const list = found.get(name) ?? [];
    list.push([label ?? "", Number(value)]);
    found.set(name, list);
  }
  return found;
}

export const only = (metrics: Metrics, name: string): number | null => metrics.get(`evswarm_${name}`)?.[0]?.[1] ?? null;
