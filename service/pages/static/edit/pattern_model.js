/**
 * The pattern that is edited: read from GarmentCode JSON as `core/garment/garmentcode.py` reads it, and written back.
 *
 * Metres inside; files have their own unit. A state never changes: an operation returns a new one, so undo keeps states.
 * Unknown fields of the format are kept; a panel that no operation changed is written as the file had it, and a
 * state as it was read is written as the very text that was read. One thing of core's reading is left out: panels that
 * other programs drew inside out stay as they are. Files that the service wrote have none.
 *
 * @typedef {import("./edge_geometry.js").Point} Point
 * @typedef {import("./edge_geometry.js").Edge} Edge
 * @typedef {{panel: string, edge: number}} EdgeRef
 * @typedef {{a: EdgeRef, b: EdgeRef, reversed: boolean, gathered: boolean}} Seam
 * @typedef {{name: string, points: Point[], edges: Edge[], rotation: number[][], translation: number[], grainline: number,
 *   label: string, mirrored: boolean, notches: [number, number][], rest: object, file: object|null}} Panel
 *   `rotation` is a matrix in metres' axes; `file` is the panel as the file had it, null once its geometry changed
 * @typedef {{x: number, y: number, turn: number}} Place   where a panel lies on the screen's table [m, rad]; not geometry
 * @typedef {{panels: Panel[], seams: Seam[], category: string, layout: Object<string, Place>, extra: object,
 *   text: string|null}} Pattern
 */

import {
  controlPolygon,
  isStraight,
  mirrorEdge,
  norm,
  placeOnChord,
  relativeToChord,
  reverseEdge,
  samplePoints,
  subtract,
  unitCircle,
  unitLength,
} from './edge_geometry.js';
import { eulerDegrees, fromEulerDegrees, multiply } from './rotation.js';

/** The key under `properties` that keeps what the format has no place for. */
const OWN = 'garmentq';
/** A seam whose length ratio lies outside 1 +- this is gathered where the file does not say. */
const GATHER_TOLERANCE = 0.03;
/** Half a turn about y: how a mirrored panel stands. */
const TURN = [
  [-1, 0, 0],
  [0, 1, 0],
  [0, 0, -1],
];

/** An error in a pattern, with the next step. */
export class PatternError extends Error {}

/**
 * Read a pattern from its JSON text.
 *
 * @param {string} text
 * @returns {Pattern}
 */
export function readPattern(text) {
  const top = JSON.parse(text);
  const body = top.pattern ?? {},
    properties = top.properties ?? {};
  if (!body.panels || !(properties.units_in_meter > 0))
    throw new PatternError('this file is not a pattern: it has no panels or no units_in_meter.');
  const scale = 1 / properties.units_in_meter;
  const relative = properties.curvature_coords !== 'absolute';
  const own = properties[OWN] ?? {};
  const numbers = {};
  const panels = Object.entries(body.panels).map(([name, file]) => {
    const { panel, order } = readPanel(name, file, scale, relative);
    numbers[name] = new Map(order.map((old, at) => [old, at]));
    return withNotes(panel, own.panels?.[name] ?? {});
  });
  const { panels: _notes, gathered: said, category, layout, ...ownRest } = own;
  const extra = {
    top: { ...top, pattern: null },
    body: { ...body, panels: null, stitches: null },
    properties,
    own: ownRest,
  };
  const pattern = { panels, seams: [], category: category ?? '', layout: layout ?? {}, extra, text };
  const seams = (body.stitches ?? []).map((stitch, index) => {
    const [a, b] = stitch.slice(0, 2).map((side) => ({ panel: side.panel, edge: numbers[side.panel]?.get(side.edge) }));
    if (a?.edge === undefined || b?.edge === undefined)
      throw new PatternError(`stitch ${index} names an edge that does not exist.`);
    const ratio = edgeLength(pattern, a) / edgeLength(pattern, b);
    const gathered = Array.isArray(said) ? said.includes(index) : Math.abs(ratio - 1) > GATHER_TOLERANCE;
    return { a, b, reversed: !stitch.slice(2).includes('right_wrong'), gathered };
  });
  return { ...pattern, seams };
}

/** Return the text of a pattern's file; the text that was read, where nothing was changed. */
export function writePattern(pattern) {
  return pattern.text ?? JSON.stringify(patternFile(pattern), null, 1);
}

/** Return a pattern as a GarmentCode object. */
export function patternFile(pattern) {
  const { extra } = pattern,
    perMetre = extra.properties.units_in_meter;
  const notes = {},
    panels = {};
  for (const panel of pattern.panels) {
    panels[panel.name] = panel.file ?? writePanel(panel, perMetre);
    notes[panel.name] = {
      grainline: panel.grainline,
      notches: panel.notches,
      contours: panel.edges.map((edge) => edge.contour),
    };
  }
  const stitches = pattern.seams.map((seam) => [
    { ...seam.a },
    { ...seam.b },
    ...(seam.reversed ? [] : ['right_wrong']),
  ]);
  const gathered = pattern.seams.flatMap((seam, index) => (seam.gathered ? [index] : []));
  const own = { ...extra.own, category: pattern.category, gathered, panels: notes };
  if (Object.keys(pattern.layout).length) own.layout = pattern.layout;
  const properties = { ...extra.properties, curvature_coords: 'relative', [OWN]: own };
  const body = { ...extra.body, panels, stitches };
  if (Array.isArray(body.panel_order)) body.panel_order = pattern.panels.map((panel) => panel.name);
  return { ...extra.top, pattern: body, properties };
}

function readPanel(name, file, scale, relative) {
  const vertices = file.vertices.map(([x, y]) => [x * scale, y * scale]);
  const { order, flipped } = orderLoop(
    file.edges.map((edge) => edge.endpoints),
    name,
  );
  const points = order.map((number, at) => vertices[file.edges[number].endpoints[flipped[at] ? 1 : 0]]);
  const edges = order.map((number, at) => {
    const [start, end] = [points[at], points[(at + 1) % points.length]];
    const drawn = flipped[at] ? [end, start] : [start, end];
    const edge = readEdge(file.edges[number], ...drawn, scale, relative);
    return flipped[at] ? reverseEdge(edge) : edge;
  });
  const { vertices: _v, edges: _e, rotation = [0, 0, 0], translation = [0, 0, 0], label = '', ...rest } = file;
  const normal = order.every((number, at) => number === at && !flipped[at] && file.edges[at].endpoints[0] === at);
  const panel = {
    name,
    points,
    edges,
    label,
    rest,
    rotation: fromEulerDegrees(rotation),
    translation: translation.map((value) => value * scale),
    grainline: 0,
    mirrored: false,
    notches: [],
    file: normal && relative && vertices.length === order.length ? file : null,
  };
  return { panel: panelArea(panel) < 0 ? mirrorPanel(panel) : panel, order };
}

/** Order edges into one loop from edge 0; true marks an edge that the file runs the other way. */
function orderLoop(ends, name) {
  const order = [0],
    flipped = [false];
  let tip = ends[0][1];
  while (tip !== ends[0][0]) {
    const number = ends.findIndex((pair, k) => !order.includes(k) && pair.includes(tip));
    if (number < 0) break;
    flipped.push(ends[number][0] !== tip);
    order.push(number);
    tip = flipped[flipped.length - 1] ? ends[number][0] : ends[number][1];
  }
  if (order.length !== ends.length || order.length < 2)
    throw new PatternError(`the edges of panel '${name}' do not form one closed loop.`);
  return { order, flipped };
}

function readEdge(file, start, end, scale, relative) {
  const { endpoints: _e, curvature, label = '', ...rest } = file;
  const edge = { kind: 'line', handles: [], label, contour: '', rest };
  if (curvature === undefined || curvature === null) return edge;
  const { type, params } = Array.isArray(curvature) ? { type: 'quadratic', params: [curvature] } : curvature;
  if (type === 'circle') {
    const radius = (params[0] * scale) / norm(subtract(end, start));
    const drop = Math.sqrt(Math.max(radius * radius - 0.25, 0));
    const height = params[1] ? radius + drop : 0.25 / (Math.max(radius, 0.5) + drop);
    return { ...edge, kind: 'arc', handles: [[0.5, params[2] ? -height : height]] };
  }
  if (type !== 'quadratic' && type !== 'cubic') throw new PatternError(`an edge has the unknown curvature '${type}'.`);
  const handles = relative
    ? params
    : relativeToChord(
        params.map(([x, y]) => [x * scale, y * scale]),
        start,
        end,
      );
  return { ...edge, kind: type, handles };
}

/** Put back what our own writer kept beside the format; what does not fit is ignored. */
function withNotes(panel, note) {
  const count = panel.edges.length;
  const contours = note.contours?.length === count ? note.contours : panel.edges.map(() => '');
  const notches = (note.notches ?? []).filter(([edge, at]) => edge >= 0 && edge < count && at >= 0 && at <= 1);
  return {
    ...panel,
    edges: panel.edges.map((edge, at) => ({ ...edge, contour: contours[at] })),
    grainline: note.grainline ?? 0,
    notches,
  };
}

function writePanel(panel, perMetre) {
  const drawn = panel.mirrored ? mirrorPanel(panel) : panel;
  const count = drawn.points.length;
  const edges = drawn.edges.map((edge, at) => {
    const file = { endpoints: [at, (at + 1) % count] };
    if (edge.kind === 'quadratic' || edge.kind === 'cubic') file.curvature = { type: edge.kind, params: edge.handles };
    else if (!isStraight(edge)) {
      const height = edge.handles[0][1];
      const chord = norm(subtract(drawn.points[(at + 1) % count], drawn.points[at]));
      const radius = unitCircle(edge).radius * chord * perMetre;
      file.curvature = { type: 'circle', params: [radius, Math.abs(height) > 0.5 ? 1 : 0, height < 0 ? 1 : 0] };
    }
    if (edge.label) file.label = edge.label;
    return { ...file, ...edge.rest };
  });
  return {
    translation: drawn.translation.map((value) => value * perMetre),
    rotation: eulerDegrees(drawn.rotation),
    vertices: drawn.points.map(([x, y]) => [x * perMetre, y * perMetre]),
    edges,
    ...(panel.label ? { label: panel.label } : {}),
    ...panel.rest,
  };
}

/** Look at a panel from its other side: x becomes -x and it stands where it stood. */
function mirrorPanel(panel) {
  return {
    ...panel,
    points: panel.points.map(([x, y]) => [-x, y]),
    edges: panel.edges.map(mirrorEdge),
    rotation: multiply(panel.rotation, TURN),
    grainline: -panel.grainline,
    mirrored: !panel.mirrored,
  };
}

/** Return a panel by its name. */
export function getPanel(pattern, name) {
  return pattern.panels.find((panel) => panel.name === name);
}

/** Return both control points of an edge [m]. */
export function chordOf(panel, edge) {
  return [panel.points[edge], panel.points[(edge + 1) % panel.points.length]];
}

/** Return the length of an edge [m]. */
export function edgeLength(pattern, ref) {
  const panel = getPanel(pattern, ref.panel);
  const [start, end] = chordOf(panel, ref.edge);
  return norm(subtract(end, start)) * unitLength(panel.edges[ref.edge]);
}

/** Return where an edge's handles lie [m]. */
export function handlePoints(panel, edge) {
  return placeOnChord(controlPolygon(panel.edges[edge]).slice(1, -1), ...chordOf(panel, edge));
}

/** Return a panel's outline as a polygon [m]: `segments` to each curve, one to each line. */
export function panelOutline(panel, segments = 16) {
  return panel.edges.flatMap((edge, at) =>
    samplePoints(edge, ...chordOf(panel, at), isStraight(edge) ? 1 : segments).slice(0, -1),
  );
}

/** Return the signed area of a polygon, positive where it runs counter-clockwise. */
export function polygonArea(polygon) {
  let twice = 0;
  polygon.forEach((point, k) => {
    const next = polygon[(k + 1) % polygon.length];
    twice += point[0] * next[1] - next[0] * point[1];
  });
  return twice / 2;
}

/** Return a panel's area [m2]. */
export function panelArea(panel) {
  return polygonArea(panelOutline(panel, 64));
}

/** Return a pattern with some panels' geometry replaced; each such panel is written anew. */
export function withPanels(pattern, changed) {
  const panels = pattern.panels.map((panel) => (changed[panel.name] ? { ...changed[panel.name], file: null } : panel));
  return { ...pattern, panels, text: null };
}

/** Return a pattern whose control points of some panels are moved; curves follow their chords. */
export function withPoints(pattern, points) {
  const changed = {};
  for (const [name, moved] of Object.entries(points)) changed[name] = { ...getPanel(pattern, name), points: moved };
  return withPanels(pattern, changed);
}
