// The e-puck's body: where its eight proximity sensors sit and how far they see.

/** x forward, y left, angle counter-clockwise from the heading; ps0 to ps7. */
export const MOUNTS: readonly { x_m: number; y_m: number; heading_rad: number }[] = [
  { x_m: 0.03, y_m: -0.01, heading_rad: -0.3008 },
  { x_m: 0.022, y_m: -0.025, heading_rad: -0.8008 },
  { x_m: 0, y_m: -0.031, heading_rad: -1.5708 },
  { x_m: -0.03, y_m: -0.015, heading_rad: -2.644 },
  { x_m: -0.03, y_m: 0.015, heading_rad: 2.6392 },
  { x_m: 0, y_m: 0.031, heading_rad: 1.5708 },
  { x_m: 0.022, y_m: 0.025, heading_rad: 0.7992 },
  { x_m: 0.03, y_m: 0.01, heading_rad: 0.2992 },
];

/** Distance at which a sensor reads next to nothing. */
export const RANGE_M = 0.07;
/** Largest raw value. */
export const MOST = 4095;
