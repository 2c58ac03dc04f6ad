// The scan with its labels: `segmented.ply`, and which points are beside each other.

const SIZES = { char: 1, uchar: 1, short: 2, ushort: 2, int: 4, uint: 4, float: 4, double: 8 };
const READ = { char: 'getInt8', uchar: 'getUint8', short: 'getInt16', ushort: 'getUint16', int: 'getInt32', uint: 'getUint32',
  float: 'getFloat32', double: 'getFloat64' };

/**
 * @typedef {{count: number, positions: Float32Array, faces: Uint32Array, label: Uint8Array, confidence: Float32Array|null}} Scan
 */

/** @param {ArrayBuffer} content @returns {Scan} */
export function readScan(content) {
  const head = new TextDecoder('latin1').decode(new Uint8Array(content, 0, Math.min(content.byteLength, 4000)));
  const end = head.indexOf('end_header\n');
  if (!head.startsWith('ply\nformat binary_little_endian') || end < 0) throw new Error('segmented.ply cannot be read.');
  const [points, triangles = ''] = head.slice(0, end).split('element face');
  const count = Number(/element vertex (\d+)/.exec(points)[1]), faceCount = Number(/^ (\d+)/.exec(triangles)?.[1] ?? 0);
  const places = {};
  let width = 0;
  for (const [, kind, name] of points.matchAll(/property (\w+) (\w+)/g)) {
    places[name] = { at: width, read: READ[kind] };
    width += SIZES[kind];
  }
  const view = new DataView(content, end + 'end_header\n'.length);
  const column = (name, into) => {
    const { at, read } = places[name];
    for (let n = 0; n < count; n += 1) into[n] = view[read](n * width + at, true);
    return into;
  };
  const positions = new Float32Array(3 * count);
  ['x', 'y', 'z'].forEach((name, axis) => column(name, new Float32Array(count)).forEach((value, n) => { positions[3 * n + axis] = value; }));
  const faces = new Uint32Array(3 * faceCount);
  for (let n = 0, at = count * width; n < faceCount; n += 1, at += 13) {
    for (let k = 0; k < 3; k += 1) faces[3 * n + k] = view.getUint32(at + 1 + 4 * k, true);
  }
  return { count, positions, faces, label: column('label', new Uint8Array(count)),
    confidence: places.confidence ? column('confidence', new Float32Array(count)) : null };
}

/** Points in cubes, to find those near a place. */
export class Cubes {
  /** @param {Float32Array} positions @param {number} side of a cube [m] */
  constructor(positions, side) {
    this.positions = positions;
    this.side = side;
    /** @type {Map<string, number[]>} */
    this.cubes = new Map();
    for (let n = 0; n < positions.length / 3; n += 1) {
      const key = [0, 1, 2].map((k) => Math.floor(positions[3 * n + k] / side)).join();
      const known = this.cubes.get(key);
      if (known) known.push(n);
      else this.cubes.set(key, [n]);
    }
  }

  /** @param {ArrayLike<number>} at @param {number} radius [m] @returns {number[]} the points within it */
  find(at, radius) {
    const low = [0, 1, 2].map((k) => Math.floor((at[k] - radius) / this.side));
    const high = [0, 1, 2].map((k) => Math.floor((at[k] + radius) / this.side));
    const found = [], { positions } = this;
    for (let i = low[0]; i <= high[0]; i += 1) {
      for (let j = low[1]; j <= high[1]; j += 1) {
        for (let k = low[2]; k <= high[2]; k += 1) {
          for (const n of this.cubes.get(`${i},${j},${k}`) ?? []) {
            if (distance(positions, n, at) <= radius) found.push(n);
          }
        }
      }
    }
    return found;
  }
}

/** @param {Float32Array} positions @param {number} n @param {ArrayLike<number>} at @returns {number} [m] */
export const distance = (positions, n, at) => Math.hypot(positions[3 * n] - at[0], positions[3 * n + 1] - at[1], positions[3 * n + 2] - at[2]);

/** How many neighbours a point of a cloud has, and how many points tell their spacing. */
const NEIGHBOURS = 8, TRIED = 300;

/**
 * Find which points are beside each other: along a mesh's edges; of a cloud the nearest.
 * @param {Scan} scan @param {Cubes} cubes
 * @returns {{start: Uint32Array, other: Uint32Array}} the neighbours of n are other[start[n]] to other[start[n + 1] - 1]
 */
export function findNeighbours(scan, cubes) {
  const pairs = scan.faces.length ? edgesOf(scan.faces) : linksOf(scan, cubes);
  const start = new Uint32Array(scan.count + 1);
  for (const n of pairs) start[n + 1] += 1;
  for (let n = 0; n < scan.count; n += 1) start[n + 1] += start[n];
  const other = new Uint32Array(pairs.length), next = start.slice();
  for (let n = 0; n < pairs.length; n += 2) {
    other[next[pairs[n]]++] = pairs[n + 1];
    other[next[pairs[n + 1]]++] = pairs[n];
  }
  return { start, other };
}

/** @param {Uint32Array} faces @returns {Uint32Array} two ends of each side of each face; an inner edge comes twice */
function edgesOf(faces) {
  const pairs = new Uint32Array(2 * faces.length);
  for (let n = 0; n < faces.length; n += 1) {
    pairs[2 * n] = faces[n];
    pairs[2 * n + 1] = faces[n % 3 === 2 ? n - 2 : n + 1];
  }
  return pairs;
}

/** @param {Scan} scan @param {Cubes} cubes @returns {number[]} */
function linksOf({ positions, count }, cubes) {
  const nearest = [];
  for (let n = 0; n < count; n += Math.max(1, Math.floor(count / TRIED))) {
    const at = positions.subarray(3 * n, 3 * n + 3);
    for (let radius = cubes.side / 4; radius < 1; radius *= 2) {
      const apart = cubes.find(at, radius).filter((m) => m !== n).map((m) => distance(positions, m, at));
      if (apart.length) { nearest.push(Math.min(...apart)); break; }
    }
  }
  const reach = 2.5 * nearest.sort((a, b) => a - b)[Math.floor(nearest.length / 2)], pairs = [];
  for (let n = 0; n < count; n += 1) {
    const at = positions.subarray(3 * n, 3 * n + 3);
    let radius = reach, found = cubes.find(at, radius);
    while (found.length <= NEIGHBOURS && radius < cubes.side) found = cubes.find(at, radius *= 2); // where points are sparse
    const near = found.filter((m) => m !== n).sort((a, b) => distance(positions, a, at) - distance(positions, b, at));
    for (const m of near.slice(0, NEIGHBOURS)) pairs.push(n, m);
  }
  return pairs;
}

/** @param {Scan} scan @returns {Float32Array|null} unit normals of the points of a mesh; null of a cloud */
export function findNormals({ positions, faces, count }) {
  if (!faces.length) return null;
  const normals = new Float32Array(3 * count);
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
    const u = [0, 1, 2].map((k) => positions[b + k] - positions[a + k]), v = [0, 1, 2].map((k) => positions[c + k] - positions[a + k]);
    const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [a, b, c]) for (let k = 0; k < 3; k += 1) normals[corner + k] += cross[k];
  }
  for (let n = 0; n < 3 * count; n += 3) {
    const length = Math.hypot(normals[n], normals[n + 1], normals[n + 2]) || 1;
    for (let k = 0; k < 3; k += 1) normals[n + k] /= length;
  }
  return normals;
}
