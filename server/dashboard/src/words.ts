// Numbers and times as people read them.

const WHOLE = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });
const COMPACT = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 3 });
const PERCENT = new Intl.NumberFormat("en", { style: "percent", maximumFractionDigits: 1 });

export const whole = (value: number): string => WHOLE.format(value);
export const compact = (value: number): string => COMPACT.format(value);
export const percent = (value: number): string => PERCENT.format(value);

/** A number with as many digits as its size needs. */
export function figure(value: number | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size >= 100 || Number.isInteger(value)) return whole(value);
  if (size >= 1) return value.toFixed(1);
  return value.toPrecision(3);
}

/** Seconds in words. */
export function duration(seconds: number): string {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  if (seconds < 172800) return `${(seconds / 3600).toFixed(1)} h`;
  return `${(seconds / 86400).toFixed(1)} days`;
}

/** Bytes in words. */
export function bytes(count: number): string {
  if (count < 10_000) return `${whole(count)} B`;
  if (count < 10_000_000) return `${(count / 1024).toFixed(1)} KiB`;
  if (count < 10_000_000_000) return `${(count / 1024 ** 2).toFixed(1)} MiB`;
  return `${(count / 1024 ** 3).toFixed(1)} GiB`;
}

/** The parts that say something, joined. */
export const sentence = (...parts: (string | null | undefined | false)[]): string =>
  parts.filter(Boolean).join(" · ");

/** Steps a second and time left, where they are known. */
export const pace = (what: {
  robot_steps_per_s?: number | null;
  eta_s?: number | null;
}): string =>
  sentence(
    what.robot_steps_per_s ? `${compact(what.robot_steps_per_s)} robot-steps/s` : null,
    what.eta_s === null || what.eta_s === undefined ? null : `${duration(what.eta_s)} left`,
  );
