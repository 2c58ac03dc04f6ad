// The frames of an animation.

/** @param {ArrayBuffer} content a PC2 point cache @returns {Float32Array[]} the positions of each frame [m] */
export function readFrames(content) {
  const view = new DataView(content);
  const points = view.getInt32(16, true), frames = view.getInt32(28, true);
  return Array.from({ length: frames }, (_, frame) => new Float32Array(content.slice(32 + 12 * points * frame, 32 + 12 * points * (frame + 1))));
}
