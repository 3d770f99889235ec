// What the server pools over all runs of a job: curves by group, and the comparison of groups.

export interface Interval {
  low: number;
  high: number;
  level: number;
  method: string;
}

export interface Curves {
  measure: string;
  /** `epoch`. */
  x: string;
  /** How often a band holds the mean, such as 0.95. */
  level: number;
  /** Abscissae of every list below. */
  at: number[];
  groups: {
    label: string;
    runs_done: number;
    n: number[];
    mean: (number | null)[];
    low: (number | null)[];
    high: (number | null)[];
    median: (number | null)[];
  }[];
}

export interface Pair {
  first: number;
  second: number;
  n: number;
  difference: number | null;
  interval: Interval | null;
  improvement: number | null;
  p: number | null;
  p_holm: number | null;
  differs: boolean;
  sentence: string;
}

export interface Comparison {
  measure: string;
  verdict: string;
  groups: { label: string; n: number }[];
  pairs: Pair[];
}
