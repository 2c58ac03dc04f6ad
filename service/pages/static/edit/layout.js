/**
 * Where panels lie on the board: a translation and a turn each, which is layout only and no geometry.
 *
 * The board is in mm with y down, as SVG is; panels are in metres with y up.
 *
 * @typedef {import("./pattern_model.js").Place} Place
 */

import { panelOutline } from './pattern_model.js';

/** Free space between panels [m]. */
const GAP = 0.04;

/** How many widths of the board are tried. */
const WIDTHS = 24;

/**
 * Return a place for each panel, so that the board of this aspect (width over height) shows them as large as it can.
 *
 * @param {import("./pattern_model.js").Pattern} pattern
 * @param {number} aspect
 * @param {{panel: string, x: number, y: number, turn: number}[][]} pieces   panels that are cut as one, placed in it
 */
export function layOut(pattern, aspect = 1.5, pieces = []) {
  const boxes = unitsOf(pattern, pieces);
  const least = Math.max(...boxes.map((box) => box.width)),
    most = boxes.reduce((sum, box) => sum + box.width, 0);
  let best = null;
  for (let k = 0; k <= WIDTHS; k += 1) {
    const tried = pack(boxes, least + ((most - least) * k) / WIDTHS);
    const size = Math.max(tried.width, tried.height * aspect);
    if (best === null || size < best.size - 1e-9) best = { size, ...tried };
  }
  const places = {};
  for (const { box, x, y } of best.spots)
    for (const { panel, place } of box.members)
      places[panel] = { x: place.x + x - box.low[0], y: place.y - y - box.high[1], turn: place.turn };
  return places;
}

/** Return what is laid as one: each piece that is cut from several panels, each other panel; with its box [m]. */
function unitsOf(pattern, pieces) {
  const names = new Set(pattern.panels.map(({ name }) => name));
  const whole = pieces.filter((piece) => piece.every(({ panel }) => names.has(panel)));
  const joined = new Set(whole.flatMap((piece) => piece.map(({ panel }) => panel)));
  const alone = pattern.panels.filter(({ name }) => !joined.has(name)).map(({ name }) => [{ panel: name, x: 0, y: 0, turn: 0 }]);
  return [...whole, ...alone].map((piece) => {
    const members = piece.map(({ panel, ...place }) => ({ panel, place }));
    const { low, high } = boxOf(pattern, members);
    return { members, low, high, width: high[0] - low[0] + GAP, height: high[1] - low[1] + GAP };
  });
}

function boxOf(pattern, members) {
  const all = members.flatMap(({ panel, place }) =>
    panelOutline(pattern.panels.find(({ name }) => name === panel)).map((point) => toBoard(place, point)),
  );
  const [low, high] = [Math.min, Math.max].map((pick) => [0, 1].map((k) => pick(...all.map((point) => point[k])) / 1e3));
  return { low: [low[0], -high[1]], high: [high[0], -low[1]] };
}

/** Put boxes, tallest first, where the next lies highest and then leftmost; y down [m]. */
function pack(boxes, room) {
  const spots = [];
  let width = 0,
    height = 0;
  for (const box of [...boxes].sort((a, b) => b.height - a.height || b.width - a.width)) {
    const lefts = [0, ...spots.map((spot) => spot.x + spot.box.width)].filter((x) => x + box.width <= room + 1e-9);
    let found = null;
    for (const x of lefts) {
      const under = spots.filter((spot) => spot.x < x + box.width - 1e-9 && spot.x + spot.box.width > x + 1e-9);
      const tops = [0, ...under.map((spot) => spot.y + spot.box.height)].sort((a, b) => a - b);
      const y = tops.find((top) => under.every((spot) => spot.y >= top + box.height - 1e-9 || spot.y + spot.box.height <= top + 1e-9));
      if (found === null || y < found.y - 1e-9 || (y < found.y + 1e-9 && x < found.x)) found = { box, x, y };
    }
    spots.push(found);
    width = Math.max(width, found.x + box.width);
    height = Math.max(height, found.y + box.height);
  }
  return { spots, width, height };
}

/** Return whether two panels that are not parts of one piece overlap on the board, by their boxes. */
export function overlaps(pattern, placeOf, pieces = []) {
  const boxes = pattern.panels.map(({ name }) => ({
    piece: pieces.findIndex((piece) => piece.some(({ panel }) => panel === name)),
    ...boxOf(pattern, [{ panel: name, place: placeOf(name) }]),
  }));
  return boxes.some((a, k) =>
    boxes.slice(k + 1).some((b) => {
      if (a.piece >= 0 && a.piece === b.piece) return false;
      return [0, 1].every((axis) => a.low[axis] < b.high[axis] - 1e-4 && b.low[axis] < a.high[axis] - 1e-4);
    }),
  );
}

/** Return where a panel's point [m] lies on the board [mm]. */
export function toBoard(place, [x, y]) {
  const [c, s] = [Math.cos(place.turn), Math.sin(place.turn)];
  return [1e3 * (place.x + c * x - s * y), -1e3 * (place.y + s * x + c * y)];
}

/** Return which point of a panel [m] lies at a place of the board [mm]. */
export function fromBoard(place, [u, v]) {
  const [c, s] = [Math.cos(place.turn), Math.sin(place.turn)];
  const [x, y] = [u / 1e3 - place.x, -v / 1e3 - place.y];
  return [c * x + s * y, -s * x + c * y];
}

/** Return a movement on the board [mm, y up] in a panel's own axes [m]. */
export function turnBack(place, [u, v]) {
  const [c, s] = [Math.cos(place.turn), Math.sin(place.turn)];
  return [(c * u + s * v) / 1e3, (-s * u + c * v) / 1e3];
}

/** Return a movement in a panel's own axes [m] on the board [mm, y up]. */
export function turnOut(place, [x, y]) {
  const [c, s] = [Math.cos(place.turn), Math.sin(place.turn)];
  return [1e3 * (c * x - s * y), 1e3 * (s * x + c * y)];
}

/** Return a pattern whose layout alone differs: a panel moved [m] and turned [rad] about the middle of its points. */
export function movePlace(pattern, panel, old, { x = 0, y = 0, turn = 0 }) {
  const middle = [0, 1].map((k) => panel.points.reduce((sum, point) => sum + point[k], 0) / panel.points.length);
  const before = toBoard(old, middle),
    after = toBoard({ ...old, turn: old.turn + turn }, middle);
  const place = {
    x: old.x + x + (before[0] - after[0]) / 1e3,
    y: old.y + y - (before[1] - after[1]) / 1e3,
    turn: old.turn + turn,
  };
  return { ...pattern, layout: { ...pattern.layout, [panel.name]: place }, text: null };
}
