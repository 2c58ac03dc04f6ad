// Write an array as NumPy's `.npy`, version 1.0.

/** @param {Uint8Array} values @returns {Uint8Array} the bytes of the file */
export function writeNpy(values) {
  const magic = [0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0];
  const told = `{'descr': '|u1', 'fortran_order': False, 'shape': (${values.length},), }`;
  const size = 64 * Math.ceil((magic.length + 2 + told.length + 1) / 64), length = size - magic.length - 2;
  const file = new Uint8Array(size + values.length);
  file.set([...magic, length & 255, length >> 8, ...new TextEncoder().encode(told.padEnd(length - 1) + '\n')]);
  file.set(values, size);
  return file;
}
