// A lasso: the visible points in an outline on the screen.

/** How far behind the nearest surface of its pixel a point may lie and still be seen, of a mesh and of a cloud [m]: less than two layers of
 * clothes are apart at an arm, more than a steep surface changes within a pixel. */
const BEHIND = 0.01, BEHIND_CLOUD = 0.02;

/**
 * @typedef {{width: number, height: number, matrix: ArrayLike<number>, size: number}} Screen
 *   its size [px], the matrix from metres to clip space by columns, and the width of a cloud's points at 1 m [px]
 */

/**
 * Find the points that are seen in an outline.
 * @param {[number, number][]} outline corners [px]; closed from the last to the first
 * @param {import('./scan.js').Scan} scan @param {Screen} screen @returns {number[]}
 */
export function findEnclosed(outline, scan, screen) {
  if (outline.length < 3) return [];
  const { at, near } = project(scan.positions, screen), box = boundsOf(outline, screen);
  const inside = [];
  for (let n = 0; n < scan.count; n += 1) {
    const [x, y] = [at[2 * n], at[2 * n + 1]];
    if (near[n] > 0 && x >= box.left && x < box.right && y >= box.top && y < box.bottom && isEnclosed(x, y, outline)) inside.push(n);
  }
  const front = scan.faces.length ? drawFaces(scan.faces, at, near, box) : drawPoints(at, near, box, screen.size);
  const behind = scan.faces.length ? BEHIND : BEHIND_CLOUD;
  return inside.filter((n) => {
    const first = front[(Math.floor(at[2 * n + 1]) - box.top) * box.width + Math.floor(at[2 * n]) - box.left];
    return !first || 1 / near[n] <= 1 / first + behind;
  });
}

/** @returns {{at: Float32Array, near: Float32Array}} where points are on the screen [px], and one over their distance [1/m]; 0: behind the camera */
function project(positions, { matrix: m, width, height }) {
  const count = positions.length / 3, at = new Float32Array(2 * count), near = new Float32Array(count);
  for (let n = 0; n < count; n += 1) {
    const x = positions[3 * n], y = positions[3 * n + 1], z = positions[3 * n + 2], w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 1e-6) continue;
    near[n] = 1 / w;
    at[2 * n] = (0.5 + (m[0] * x + m[4] * y + m[8] * z + m[12]) / (2 * w)) * width;
    at[2 * n + 1] = (0.5 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / (2 * w)) * height;
  }
  return { at, near };
}

/** @returns {{left: number, top: number, right: number, bottom: number, width: number}} the whole pixels around an outline, on the screen */
function boundsOf(outline, { width, height }) {
  const xs = outline.map(([x]) => x), ys = outline.map(([, y]) => y);
  const left = Math.max(0, Math.floor(Math.min(...xs))), top = Math.max(0, Math.floor(Math.min(...ys)));
  const right = Math.max(left, Math.min(width, Math.ceil(Math.max(...xs)))), bottom = Math.max(top, Math.min(height, Math.ceil(Math.max(...ys))));
  return { left, top, right, bottom, width: right - left };
}

/** @returns {boolean} whether a place is in an outline, by the number of its sides to the right */
function isEnclosed(x, y, outline) {
  let isIn = false;
  for (let n = 0, before = outline.length - 1; n < outline.length; before = n, n += 1) {
    const [ax, ay] = outline[n], [bx, by] = outline[before];
    if (ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay)) isIn = !isIn;
  }
  return isIn;
}

/** @returns {Float32Array} one over the distance of the nearest face in each pixel of a box; 0: none */
function drawFaces(faces, at, near, box) {
  const front = new Float32Array(box.width * (box.bottom - box.top));
  for (let f = 0; f < faces.length; f += 3) {
    const a = faces[f], b = faces[f + 1], c = faces[f + 2];
    if (!near[a] || !near[b] || !near[c]) continue;
    const ax = at[2 * a], ay = at[2 * a + 1], bx = at[2 * b] - ax, by = at[2 * b + 1] - ay, cx = at[2 * c] - ax, cy = at[2 * c + 1] - ay;
    const area = bx * cy - by * cx;
    if (!area) continue;
    // pixels by their middles
    const left = Math.max(box.left, Math.ceil(ax + Math.min(0, bx, cx) - 0.5)), right = Math.min(box.right - 1, Math.floor(ax + Math.max(0, bx, cx) - 0.5));
    const top = Math.max(box.top, Math.ceil(ay + Math.min(0, by, cy) - 0.5)), bottom = Math.min(box.bottom - 1, Math.floor(ay + Math.max(0, by, cy) - 0.5));
    for (let y = top; y <= bottom; y += 1) {
      for (let x = left; x <= right; x += 1) {
        const px = x + 0.5 - ax, py = y + 0.5 - ay, v = (px * cy - py * cx) / area, w = (bx * py - by * px) / area;
        if (v < 0 || w < 0 || v + w > 1) continue;
        const own = near[a] + v * (near[b] - near[a]) + w * (near[c] - near[a]), k = (y - box.top) * box.width + x - box.left;
        if (own > front[k]) front[k] = own;
      }
    }
  }
  return front;
}

/** @returns {Float32Array} as `drawFaces`, of the squares as which a cloud's points are drawn */
function drawPoints(at, near, box, size) {
  const front = new Float32Array(box.width * (box.bottom - box.top));
  for (let n = 0; n < near.length; n += 1) {
    if (!near[n]) continue;
    const half = (size * near[n]) / 2, x = at[2 * n], y = at[2 * n + 1];
    for (let j = Math.max(box.top, Math.floor(y - half)); j <= Math.min(box.bottom - 1, Math.floor(y + half)); j += 1) {
      for (let i = Math.max(box.left, Math.floor(x - half)); i <= Math.min(box.right - 1, Math.floor(x + half)); i += 1) {
        const k = (j - box.top) * box.width + i - box.left;
        if (near[n] > front[k]) front[k] = near[n];
      }
    }
  }
  return front;
}
