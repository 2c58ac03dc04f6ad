// The binary PLY that our writers write: double properties of each vertex, perhaps colours, triangles.

/** @typedef {{positions: Float32Array, faces: Uint32Array, values: Record<string, Float32Array>}} Mesh */

/** @param {ArrayBuffer} content @returns {Mesh} positions [m], triangles, and further numbers of each vertex by name */
export function readPly(content) {
  const head = new TextDecoder('latin1').decode(new Uint8Array(content, 0, Math.min(content.byteLength, 2000)));
  const end = head.indexOf('end_header\n') + 'end_header\n'.length;
  const vertices = Number(/element vertex (\d+)/.exec(head)?.[1]);
  const count = Number(/element face (\d+)/.exec(head)?.[1]);
  const own = head.slice(0, head.indexOf('element face'));
  const names = [...own.matchAll(/property double (\w+)/g)].map((match) => match[1]);
  const row = 8 * names.length + [...own.matchAll(/property uchar/g)].length;
  if (!head.startsWith('ply\nformat binary_little_endian') || names.length < 3) throw new Error('not a PLY file of garmentq');
  const view = new DataView(content), positions = new Float32Array(3 * vertices), values = {};
  for (const name of names.slice(3)) values[name] = new Float32Array(vertices);
  for (let vertex = 0, at = end; vertex < vertices; vertex += 1, at += row) {
    for (let axis = 0; axis < 3; axis += 1) positions[3 * vertex + axis] = view.getFloat64(at + 8 * axis, true);
    for (let extra = 3; extra < names.length; extra += 1) values[names[extra]][vertex] = view.getFloat64(at + 8 * extra, true);
  }
  const faces = new Uint32Array(3 * count);
  for (let face = 0, at = end + row * vertices; face < count; face += 1, at += 13) {
    for (let corner = 0; corner < 3; corner += 1) faces[3 * face + corner] = view.getUint32(at + 1 + 4 * corner, true);
  }
  return { positions, faces, values };
}

/** @param {ArrayBuffer} content a PC2 point cache @returns {Float32Array[]} the positions of each frame [m] */
export function readFrames(content) {
  const view = new DataView(content);
  const points = view.getInt32(16, true), frames = view.getInt32(28, true);
  return Array.from({ length: frames }, (_, frame) => new Float32Array(content.slice(32 + 12 * points * frame, 32 + 12 * points * (frame + 1))));
}
