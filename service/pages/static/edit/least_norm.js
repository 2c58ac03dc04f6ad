/** The shortest vector that solves a small linear system as well as can be, by the eigenvectors of A A^T. */

/** Singular values below this share of the largest are dropped: equations that follow from others. */
const LEAST_SINGULAR = 1e-3;
/** Most sweeps of Jacobi rotations; matrices of 30 rows need 6 to 8. */
const SWEEPS = 30;

/**
 * Return the shortest x with A x = b in the sense of least squares.
 *
 * @param {number[][]} rows   A, shape [n, m]
 * @param {number[]} b   shape [n]
 */
export function leastNorm(rows, b) {
  const gram = rows.map((one) => rows.map((two) => one.reduce((sum, value, k) => sum + value * two[k], 0)));
  const { values, vectors } = eigen(gram);
  const limit = LEAST_SINGULAR ** 2 * Math.max(...values);
  const weights = new Array(b.length).fill(0);
  values.forEach((value, k) => {
    if (!(value > limit)) return;
    const part = vectors.reduce((sum, row, i) => sum + row[k] * b[i], 0) / value;
    vectors.forEach((row, i) => {
      weights[i] += part * row[k];
    });
  });
  return (rows[0] ?? []).map((_, k) => rows.reduce((sum, row, i) => sum + row[k] * weights[i], 0));
}

/** Return eigenvalues and, as columns, eigenvectors of a symmetric matrix (cyclic Jacobi). */
function eigen(matrix) {
  const a = matrix.map((row) => [...row]),
    n = a.length;
  const vectors = a.map((_, i) => a.map((__, j) => (i === j ? 1 : 0)));
  for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
    let off = 0,
      all = 0;
    a.forEach((row, i) =>
      row.forEach((value, j) => {
        all += value * value;
        if (i !== j) off += value * value;
      }),
    );
    if (off <= 1e-28 * all) break;
    for (let p = 0; p < n; p += 1) {
      for (let q = p + 1; q < n; q += 1) {
        if (a[p][q] === 0) continue;
        const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
        const c = 1 / Math.sqrt(t * t + 1),
          s = t * c;
        for (let k = 0; k < n; k += 1) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
        for (let k = 0; k < n; k += 1) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
        for (const row of vectors) [row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]];
      }
    }
  }
  return { values: a.map((row, i) => row[i]), vectors };
}
