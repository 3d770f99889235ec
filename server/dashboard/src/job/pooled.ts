// What the server pools over all runs of a job: curves by group, and the comparison of groups.

export interface Curves {
  measure: string;
  /** `epoch` or `steps`. */
  x: string;
  /** Level of the intervals, such as 0.95. */
  level: number;
  groups: {
    label: string;
    n: number;
    points: { x: number; n: number; mean: number | null; interval: [number, number] | null }[];
  }[];
}

export interface Comparison {
  measure: string;
  verdict: string;
  pairs: {
    a: string;
    b: string;
    n: number;
    difference: number | null;
    interval: [number, number] | null;
    probability: number | null;
    p: number | null;
    p_holm: number | null;
    sentence: string;
  }[];
}
