/** Rotations in space as 3 x 3 matrices, and as Euler angles in degrees about the fixed axes x, y, z in this order. */

const RADIANS = Math.PI / 180;

/** Return the product of two 3 x 3 matrices. */
export function multiply(a, b) {
  return a.map((row) => [0, 1, 2].map((k) => row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k]));
}

/** Return the rotation of angles [degrees] about the fixed axes x, then y, then z. */
export function fromEulerDegrees([x, y, z]) {
  const [a, b, c] = [x * RADIANS, y * RADIANS, z * RADIANS];
  const aboutX = [
    [1, 0, 0],
    [0, Math.cos(a), -Math.sin(a)],
    [0, Math.sin(a), Math.cos(a)],
  ];
  const aboutY = [
    [Math.cos(b), 0, Math.sin(b)],
    [0, 1, 0],
    [-Math.sin(b), 0, Math.cos(b)],
  ];
  const aboutZ = [
    [Math.cos(c), -Math.sin(c), 0],
    [Math.sin(c), Math.cos(c), 0],
    [0, 0, 1],
  ];
  return multiply(aboutZ, multiply(aboutY, aboutX));
}

/** Return angles [degrees] that make a rotation; at 90 degrees about y the angle about z is taken as 0. */
export function eulerDegrees(m) {
  const flat = Math.hypot(m[0][0], m[1][0]);
  const y = Math.atan2(-m[2][0], flat);
  const angles =
    flat > 1e-9
      ? [Math.atan2(m[2][1], m[2][2]), y, Math.atan2(m[1][0], m[0][0])]
      : [Math.atan2(-m[1][2], m[1][1]), y, 0];
  return angles.map((angle) => angle / RADIANS);
}

/** Put a flat point [m] where its panel stands in space [m]. */
export function placePoint(panel, [x, y]) {
  return [0, 1, 2].map((k) => panel.rotation[k][0] * x + panel.rotation[k][1] * y + panel.translation[k]);
}
