// A run watched: the stream of its frames, taken up again when it breaks off.

import { stream, type Stream } from "../stream";
import { Cutter, parseFrame, parseSquares, type Frame, type Squares } from "./messages";

export interface Seen {
  frame(frame: Frame): void;
  squares(squares: Squares): void;
  /** Nobody steps the run at present. */
  waiting(): void;
  /** Whether the run has ended: the stream ends too when the server stops, and is then taken up again. */
  isOver(): boolean;
}

/** Watches a run until it ends. */
export function watchFrames(run: string, see: Seen): Stream {
  return stream({
    path: () => `/v1/runs/${run}/frames`,
    begin: () => {
      const cutter = new Cutter((kind, body) => {
        if (kind === 1) see.frame(parseFrame(body));
        else if (kind === 2) see.squares(parseSquares(body));
        else if (kind === 3) see.waiting();
      });
      return (part) => cutter.push(part);
    },
    isOver: () => see.isOver(),
  });
}
