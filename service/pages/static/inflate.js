// Unpacking small pieces of DEFLATE data (RFC 1951) at once, without a stream.

const LENGTHS = [3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258];
const LENGTH_BITS = [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0];
const DISTANCES = [1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577];
const DISTANCE_BITS = DISTANCES.map((_, n) => Math.max(0, (n >> 1) - 1));
const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/** @param {number[]} lengths of each symbol's code, 0: it has none @returns {Map<number, number>} symbols by code, below a leading 1 */
function makeCodes(lengths) {
  const codes = new Map();
  let next = 0;
  for (let length = 1; length <= 15; length += 1) {
    lengths.forEach((own, symbol) => {
      if (own === length) codes.set((1 << length) | next++, symbol);
    });
    next <<= 1;
  }
  return codes;
}

const FIXED = makeCodes(Array.from({ length: 288 }, (_, n) => (n < 144 ? 8 : n < 256 ? 9 : n < 280 ? 7 : 8)));
const FIXED_DISTANCES = makeCodes(Array(30).fill(5));

/**
 * Unpack DEFLATE data.
 * @param {Uint8Array} packed @param {number} size of what comes out [bytes] @returns {Uint8Array}
 */
export function inflate(packed, size) {
  const out = new Uint8Array(size);
  let at = 0, held = 0, count = 0, end = 0;
  const take = (bits) => {
    for (; count < bits; count += 8) {
      if (at >= packed.length) throw new Error('the data is cut off');
      held |= packed[at++] << count;
    }
    const value = held & ((1 << bits) - 1);
    held >>>= bits;
    count -= bits;
    return value;
  };
  const read = (codes) => {
    for (let code = 1; code < 65536;) {
      code = (code << 1) | take(1);
      const symbol = codes.get(code);
      if (symbol !== undefined) return symbol;
    }
    throw new Error('the data is damaged');
  };
  const readCodes = () => {
    const literals = take(5) + 257, distances = take(5) + 1, lengths = Array(19).fill(0), found = [];
    for (let n = take(4) + 4, k = 0; k < n; k += 1) lengths[ORDER[k]] = take(3);
    const codes = makeCodes(lengths);
    while (found.length < literals + distances) {
      const symbol = read(codes);
      if (symbol < 16) found.push(symbol);
      else if (symbol === 16) found.push(...Array(3 + take(2)).fill(found.at(-1)));
      else found.push(...Array(symbol === 17 ? 3 + take(3) : 11 + take(7)).fill(0));
    }
    return [makeCodes(found.slice(0, literals)), makeCodes(found.slice(literals))];
  };
  for (let isLast = 0; !isLast;) {
    isLast = take(1);
    const kind = take(2);
    if (kind === 0) {
      held = 0;
      count = 0;
      const length = packed[at] | (packed[at + 1] << 8);
      out.set(packed.subarray(at + 4, at + 4 + length), end);
      at += 4 + length;
      end += length;
      continue;
    }
    const [literals, distances] = kind === 1 ? [FIXED, FIXED_DISTANCES] : readCodes();
    for (let symbol = read(literals); symbol !== 256; symbol = read(literals)) {
      if (symbol < 256) {
        out[end++] = symbol;
        continue;
      }
      const length = LENGTHS[symbol - 257] + take(LENGTH_BITS[symbol - 257]), code = read(distances);
      const back = DISTANCES[code] + take(DISTANCE_BITS[code]);
      for (let n = 0; n < length; n += 1, end += 1) out[end] = out[end - back];
    }
  }
  return out;
}
