// The results as files: the CSV and JSON of `garmentq match`, and only the pairs for its `--pairs`.

const HEADS = ['first', 'second', 'paired by', 'turning rad', 'area %', 'outline mm'];

/** How a text begins that a spreadsheet would run; the last four are the full-width forms. */
const FORMULA = /^[=+\-@|\t\r\uff1d\uff0b\uff0d\uff20]/;

/** @param {string|number} value @returns {string} a cell (RFC 4180) */
function cell(value) {
  const text = typeof value === 'string' && FORMULA.test(value) ? `'${value}` : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** @param {import('./pairing.js').Pairing} pairing @returns {string} */
export function asCsv(pairing) {
  const rows = pairing.pairs.map((pair) => [pair.first, pair.second, pair.paired_by, pair.turning, pair.area_percent,
    pair.outline_mm]);
  return [HEADS, ...rows].map((row) => row.map(cell).join(',') + '\r\n').join('');
}

/** @param {import('./pairing.js').Pairing} pairing @returns {string} */
export function asJson(pairing) {
  return JSON.stringify({ pairs: pairing.pairs, only_first: pairing.alone(0), only_second: pairing.alone(1) }, null, 1);
}

/** @param {import('./pairing.js').Pairing} pairing @returns {string} */
export function asPairs(pairing) {
  return JSON.stringify(Object.fromEntries(pairing.pairs.map((pair) => [pair.first, pair.second])), null, 1);
}

/** Hand a text to the browser as a file. @param {string} name @param {string} text @param {string} type */
export function save(name, text, type) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
