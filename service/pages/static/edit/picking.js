/** What lies under the pointer, and where a dragged point snaps to. */

import { controlPolygon, nearestOnEdge, norm, placeOnChord, subtract } from './edge_geometry.js';
import { chordOf, handlePoints, panelOutline } from './pattern_model.js';
import { contains } from './panel_operations.js';
import { possiblePoints } from './point_operations.js';
import { fromBoard, toBoard } from './layout.js';

/** How near counts as on it [px]: mouse, and finger. */
const REACH = { mouse: 10, pen: 12, touch: 22 };

/**
 * Find what is at a place of the board [mm]: a handle that is shown, a control point, a possible one, an edge, a panel.
 *
 * @param {import("./session.js").Session} session
 * @param {[number, number]} at
 * @param {number} scale   mm of a pixel
 * @returns {{item: object|null, possible?: object, place?: [number, number]}} place: in the panel [m]
 */
export function pick(session, at, scale, pointer = 'mouse') {
  const reach = ((REACH[pointer] ?? REACH.mouse) * scale) / 1e3;
  const { pattern, options } = session;
  const spots = pattern.panels.map((panel) => ({ panel, place: fromBoard(session.placeOf(panel.name), at) })).reverse();
  const nearest = (found) => found.filter(({ far }) => far <= reach).sort((a, b) => a.far - b.far)[0];
  const handle =
    options.handles &&
    nearest(
      spots.flatMap(({ panel, place }) =>
        shownHandles(session, panel).map((shown) => ({ ...shown, place, far: norm(subtract(shown.at, place)) })),
      ),
    );
  const point = nearest(
    spots.flatMap(({ panel, place }) =>
      panel.points.map((here, k) => ({
        item: { panel: panel.name, point: k },
        place,
        far: norm(subtract(here, place)),
      })),
    ),
  );
  if (point && !(handle && handle.far < point.far)) return point;
  if (handle) return handle;
  if (options.possible) {
    const found = nearest(
      spots.flatMap(({ panel, place }) =>
        possiblePoints({ ...pattern, panels: [panel] }).map((spot) => ({
          item: null,
          possible: spot,
          place,
          far: norm(subtract(spot.place, place)),
        })),
      ),
    );
    if (found) return found;
  }
  const edge = nearest(
    spots.flatMap(({ panel, place }) =>
      panel.edges.flatMap((one, k) => {
        const ends = chordOf(panel, k);
        if (
          !nearHull(
            placeOnChord(controlPolygon(one), ...ends),
            place,
            one.kind === 'arc' ? 2 * norm(subtract(...ends)) : reach,
          )
        )
          return [];
        const hit = nearestOnEdge(one, ...ends, place);
        return [{ item: { panel: panel.name, edge: k }, fraction: hit.fraction, place, far: hit.distance }];
      }),
    ),
  );
  if (edge) return edge;
  const inside = spots.find(({ panel, place }) => contains(panelOutline(panel), place));
  return inside ? { item: { panel: inside.panel.name }, place: inside.place } : { item: null };
}

function nearHull(polygon, [x, y], reach) {
  return [0, 1].every((k) => {
    const values = polygon.map((point) => point[k]),
      at = k ? y : x;
    return at >= Math.min(...values) - reach && at <= Math.max(...values) + reach;
  });
}

function shownHandles(session, panel) {
  const count = panel.points.length;
  return panel.edges.flatMap((edge, k) => {
    const near = session.selection.some(
      (item) => item.panel === panel.name && (item.edge === k || item.point === k || item.point === (k + 1) % count),
    );
    return near
      ? handlePoints(panel, k).map((at, handle) => ({ item: { panel: panel.name, edge: k, handle }, at }))
      : [];
  });
}

/** Return the control points, and the handles that are shown, inside a box of the board [mm]. */
export function pickBox(session, from, to) {
  const inside = (place, at) => {
    const spot = toBoard(place, at);
    return [0, 1].every((k) => spot[k] >= Math.min(from[k], to[k]) && spot[k] <= Math.max(from[k], to[k]));
  };
  return session.pattern.panels.flatMap((panel) => {
    const place = session.placeOf(panel.name);
    const points = panel.points.flatMap((at, point) => (inside(place, at) ? [{ panel: panel.name, point }] : []));
    return [
      ...points,
      ...shownHandles(session, panel)
        .filter(({ at }) => inside(place, at))
        .map(({ item }) => item),
    ];
  });
}

/**
 * Return where a dragged point comes to lie [m]: in line with another point of its panel, else on the grid.
 *
 * @param {number} reach   how near it must come to another point's line [m]
 */
export function snap(session, panel, place, except, reach) {
  const { grid, align } = session.options;
  const others = panel.points.filter((_, k) => !except.includes(k));
  return [0, 1].map((k) => {
    const near = align ? others.map((point) => point[k]).filter((value) => Math.abs(value - place[k]) < reach) : [];
    if (near.length) return near.sort((a, b) => Math.abs(a - place[k]) - Math.abs(b - place[k]))[0];
    return grid > 0 ? (Math.round((place[k] * 1e3) / grid) * grid) / 1e3 : place[k];
  });
}
