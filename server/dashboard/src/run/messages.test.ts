import { expect, it } from "vitest";
import { Cutter, choiceOf, FLOATS, parseFrame, SENSORS, WORDS, type Frame } from "./messages";

/** A message with a frame of two robots and an object. */
function message(step: number): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(8 + 56 + 2 * 40 + 12);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, bytes.length - 4, true);
  view.setUint32(4, 1, true);
  view.setFloat64(8, step, true);
  view.setUint32(8 + 48, 2, true);
  view.setUint32(8 + 52, 1, true);
  for (let robot = 0; robot < 2; robot++) {
    const at = 64 + robot * 40;
    for (let n = 0; n < 5; n++) view.setFloat32(at + 4 * n, robot + n / 4, true);
    for (let n = 0; n < 8; n++) view.setUint16(at + 20 + 2 * n, 100 * robot + n, true);
    view.setUint16(at + 36, robot ? 0xffff : 3, true);
    view.setUint16(at + 38, robot ? 0xffff : 5, true);
  }
  for (let n = 0; n < 3; n++) view.setFloat32(64 + 80 + 4 * n, n / 2, true);
  return bytes;
}

it("reads the same frames however the stream is cut, aligned or not", () => {
  const stream = new Uint8Array([...message(1), ...message(2), ...message(3)]);
  for (let size = 1; size <= stream.length; size++) {
    const frames: Frame[] = [];
    const cutter = new Cutter((kind, body) => {
      expect(kind).toBe(1);
      frames.push(parseFrame(body));
    });
    // Parts that begin at odd places of a buffer.
    for (let at = 0; at < stream.length; at += size) {
      const held = new Uint8Array(size + 3);
      const part = stream.subarray(at, at + size);
      held.set(part, 3);
      cutter.push(held.subarray(3, 3 + part.length));
    }
    expect(frames.map((frame) => frame.step)).toEqual([1, 2, 3]);
    for (const frame of frames) {
      expect([...frame.floats.subarray(FLOATS, FLOATS + 5)]).toEqual([1, 1.25, 1.5, 1.75, 2]);
      expect([...frame.words.subarray(WORDS + SENSORS, WORDS + SENSORS + 8)]).toEqual([100, 101, 102, 103, 104, 105, 106, 107]);
      expect([choiceOf(frame, 0), choiceOf(frame, 1)]).toEqual([[3, 5], null]);
      expect([...frame.objects]).toEqual([0, 0.5, 1]);
    }
  }
});
