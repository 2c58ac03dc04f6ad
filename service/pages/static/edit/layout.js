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

/** Return a place for each panel: on shelves, tallest first, about as wide as high. */
export function layOut(pattern) {
  const boxes = pattern.panels.map((panel) => {
    const outline = panelOutline(panel);
    const [low, high] = [Math.min, Math.max].map((pick) =>
      [0, 1].map((k) => pick(...outline.map((point) => point[k]))),
    );
    return { name: panel.name, low, width: high[0] - low[0] + GAP, height: high[1] - low[1] + GAP };
  });
  const room = Math.max(
    ...boxes.map((box) => box.width),
    1.5 * Math.sqrt(boxes.reduce((sum, box) => sum + box.width * box.height, 0)),
  );
  const places = {};
  let x = 0,
    y = 0,
    shelf = 0;
  for (const box of [...boxes].sort((a, b) => b.height - a.height)) {
    if (x > 0 && x + box.width > room) [x, y, shelf] = [0, y - shelf, 0];
    shelf = Math.max(shelf, box.height);
    places[box.name] = { x: x - box.low[0], y: y - box.height + GAP - box.low[1], turn: 0 };
    x += box.width;
  }
  return places;
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
