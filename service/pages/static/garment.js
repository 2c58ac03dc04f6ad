// A garment: its flat mesh, how that is sewn, and geometry between the two. All in metres.

/**
 * @typedef {Uint8Array|Uint16Array|Uint32Array} Indices
 * @typedef {{panel: string, index: number, label: string, contour: string, uv: Indices}} Edge an edge's uv vertices in order
 * @typedef {{name: string, edges: Edge[]}} Panel
 * @typedef {{uv: Float32Array, uvFaces: Indices, uvNode: Indices, panelOfUv: Indices, panels: Panel[],
 *   seams: [Edge, Edge][]}} Garment
 */

/**
 * Find where a point of a panel lies on its flat mesh.
 * @param {Garment} garment @param {number} panel @param {number} x @param {number} y
 * @returns {{face: number, weights: number[]}|null} the face and the weights of its corners; null outside the panel
 */
export function locate(garment, panel, x, y) {
  const { uv, uvFaces, panelOfUv } = garment;
  for (let face = 0; face < uvFaces.length / 3; face += 1) {
    const a = uvFaces[3 * face];
    if (panelOfUv[a] !== panel) continue;
    const b = uvFaces[3 * face + 1], c = uvFaces[3 * face + 2];
    const ax = uv[2 * a] - x, ay = uv[2 * a + 1] - y, bx = uv[2 * b] - x, by = uv[2 * b + 1] - y, cx = uv[2 * c] - x, cy = uv[2 * c + 1] - y;
    const wa = bx * cy - by * cx, wb = cx * ay - cy * ax, wc = ax * by - ay * bx, whole = wa + wb + wc;
    const least = -1e-9 * Math.abs(whole);
    if (whole !== 0 && wa / whole >= least && wb / whole >= least && wc / whole >= least) return { face, weights: [wa / whole, wb / whole, wc / whole] };
  }
  return null;
}

/**
 * Find the place in space of a point of the flat mesh.
 * @param {Garment} garment @param {ArrayLike<number>} nodes @param {{face: number, weights: number[]}} place
 * @returns {number[]} [m]
 */
export function lift(garment, nodes, { face, weights }) {
  const point = [0, 0, 0];
  weights.forEach((weight, corner) => {
    const node = garment.uvNode[garment.uvFaces[3 * face + corner]];
    for (let axis = 0; axis < 3; axis += 1) point[axis] += weight * nodes[3 * node + axis];
  });
  return point;
}

/** @returns {number[]} the point of its panel where a place of the flat mesh lies [m] */
export function flatten(garment, { face, weights }) {
  const point = [0, 0];
  weights.forEach((weight, corner) => {
    const vertex = garment.uvFaces[3 * face + corner];
    point[0] += weight * garment.uv[2 * vertex];
    point[1] += weight * garment.uv[2 * vertex + 1];
  });
  return point;
}

/**
 * Measure a part of an edge in the flat pattern and on a mesh.
 * @param {Garment} garment @param {Edge} edge @param {number} from @param {number} to places in `edge.uv` @param {ArrayLike<number>} nodes
 * @returns {{flat: number, worn: number}} lengths [m]
 */
export function measureEdge(garment, edge, from, to, nodes) {
  let flat = 0, worn = 0;
  const [first, last] = from < to ? [from, to] : [to, from];
  for (let n = first; n < last; n += 1) {
    const a = edge.uv[n], b = edge.uv[n + 1];
    flat += Math.hypot(garment.uv[2 * a] - garment.uv[2 * b], garment.uv[2 * a + 1] - garment.uv[2 * b + 1]);
    const p = 3 * garment.uvNode[a], q = 3 * garment.uvNode[b];
    worn += Math.hypot(nodes[p] - nodes[q], nodes[p + 1] - nodes[q + 1], nodes[p + 2] - nodes[q + 2]);
  }
  return { flat, worn };
}

/**
 * Compute how much each face is stretched: the larger of its two principal stretches, less one.
 * @param {Garment} garment @param {ArrayLike<number>} nodes @returns {Float32Array} of each face
 */
export function computeStrain(garment, nodes) {
  const { uv, uvFaces, uvNode } = garment, strain = new Float32Array(uvFaces.length / 3);
  for (let face = 0; face < strain.length; face += 1) {
    const [a, b, c] = [uvFaces[3 * face], uvFaces[3 * face + 1], uvFaces[3 * face + 2]];
    const ux = uv[2 * b] - uv[2 * a], uy = uv[2 * b + 1] - uv[2 * a + 1], vx = uv[2 * c] - uv[2 * a], vy = uv[2 * c + 1] - uv[2 * a + 1];
    const area = ux * vy - uy * vx;
    const [p, q, r] = [3 * uvNode[a], 3 * uvNode[b], 3 * uvNode[c]];
    let xx = 0, xy = 0, yy = 0;
    for (let axis = 0; axis < 3; axis += 1) {
      const s = nodes[q + axis] - nodes[p + axis], t = nodes[r + axis] - nodes[p + axis];
      const alongX = (s * vy - t * uy) / area, alongY = (t * ux - s * vx) / area;
      xx += alongX * alongX;
      xy += alongX * alongY;
      yy += alongY * alongY;
    }
    const middle = (xx + yy) / 2;
    strain[face] = Math.sqrt(middle + Math.hypot((xx - yy) / 2, xy)) - 1;
  }
  return strain;
}

/** @param {Garment} garment @param {Float32Array} ofFaces @param {number} nodeCount @returns {Float32Array} means over the faces around each node */
export function spreadToNodes(garment, ofFaces, nodeCount) {
  const sums = new Float32Array(nodeCount), counts = new Float32Array(nodeCount);
  ofFaces.forEach((value, face) => {
    for (let corner = 0; corner < 3; corner += 1) {
      const node = garment.uvNode[garment.uvFaces[3 * face + corner]];
      sums[node] += value;
      counts[node] += 1;
    }
  });
  return sums.map((sum, node) => sum / Math.max(counts[node], 1));
}
