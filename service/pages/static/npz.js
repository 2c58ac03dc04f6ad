// NumPy's archives (.npz): only the arrays that are asked for are unpacked.
import { inflate } from './inflate.js';

/** @typedef {{shape: number[], values: any}} NumpyArray */

const KINDS = { '<f8': Float64Array, '<f4': Float32Array, '<i8': BigInt64Array, '<i4': Int32Array, '|u1': Uint8Array, '|b1': Uint8Array };

/**
 * Read the directory of an archive.
 * @param {ArrayBuffer} content
 * @returns {Map<string, {method: number, start: number, size: number, whole: number}>} where each array lies, by its name
 */
export function readDirectory(content) {
  const view = new DataView(content), bytes = new Uint8Array(content), text = new TextDecoder();
  let end = content.byteLength - 22;
  while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) end -= 1;
  if (end < 0) throw new Error('the archive is cut off');
  const found = new Map();
  let at = view.getUint32(end + 16, true);
  for (let left = view.getUint16(end + 10, true); left > 0; left -= 1) {
    const nameLength = view.getUint16(at + 28, true);
    const name = text.decode(bytes.subarray(at + 46, at + 46 + nameLength)).replace(/\.npy$/, '');
    const local = view.getUint32(at + 42, true);
    const start = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
    found.set(name, { method: view.getUint16(at + 10, true), start, size: view.getUint32(at + 20, true), whole: view.getUint32(at + 24, true) });
    at += 46 + nameLength + view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
  }
  return found;
}

/**
 * Read some arrays of an archive; 64-bit integers come as Int32Array.
 * @param {ArrayBuffer} content @param {(name: string) => boolean} wanted
 * @returns {Promise<Map<string, NumpyArray>>}
 */
export async function readArrays(content, wanted) {
  const chosen = [...readDirectory(content)].filter(([name]) => wanted(name));
  const read = await Promise.all(chosen.map(async ([name, entry]) => [name, readArray(await unpack(content, entry))]));
  return new Map(read);
}

/** Arrays up to this are unpacked at once [bytes]: a stream for each of some hundred takes longer than the work. */
const SMALL = 4096;

async function unpack(content, { method, start, size, whole }) {
  if (method !== 0 && whole <= SMALL) return inflate(new Uint8Array(content, start, size), whole).buffer;
  const part = content.slice(start, start + size);
  if (method === 0) return part;
  const stream = new Blob([part]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Response(stream).arrayBuffer();
}

/** @param {ArrayBuffer} content of an .npy file @returns {NumpyArray} */
function readArray(content) {
  const view = new DataView(content);
  const isLong = view.getUint8(6) >= 2;
  const length = isLong ? view.getUint32(8, true) : view.getUint16(8, true);
  const start = (isLong ? 12 : 10) + length;
  const head = new TextDecoder().decode(new Uint8Array(content, start - length, length));
  const kind = /'descr': '([^']+)'/.exec(head)?.[1] ?? '';
  if (!KINDS[kind] || /'fortran_order': True/.test(head)) throw new Error(`cannot read an array of ${kind}`);
  const shape = /'shape': \(([^)]*)\)/.exec(head)[1].split(',').filter((part) => part.trim()).map(Number);
  const values = new KINDS[kind](content.slice(start));
  return { shape, values: values instanceof BigInt64Array ? Int32Array.from(values, Number) : values };
}

/** @param {NumpyArray|undefined} array of bytes @returns {string} the text that it holds */
export const asText = (array) => (array ? new TextDecoder().decode(array.values) : '');
