/**
 * The commands of buttons and keys, each defined once: name, texts, keys, and its function.
 *
 * @typedef {{name: string, label: string, help: string, keys: string[], group: string, run: (session: object, camera: object, more: boolean) => void}} Command   more: with Shift
 */

import { straighten, toCorner, toCurve } from './curve_operations.js';
import { pivotSelected, removeSelectedDart } from './distances.js';
import { getPanel, PatternError } from './pattern_model.js';
import { addPoint, removePoint } from './point_operations.js';
import { cutBetween, joinAlong } from './panel_operations.js';
import { movePlace, turnBack } from './layout.js';
import { moveItems } from './movement.js';
import { findMirrors } from './symmetry.js';
import { keepSeams, seamOf } from './seams.js';
import { kindOf } from './session.js';

/** How far a panel turns by one press [rad]. */
const TURN = Math.PI / 36;

/** @type {Command[]} */
export const COMMANDS = [
  {
    name: 'undo',
    label: 'Undo',
    help: 'undo the last change',
    keys: ['Ctrl+z'],
    group: 'Changes',
    run: (session) => session.undo(),
  },
  {
    name: 'redo',
    label: 'Redo',
    help: 'redo the last undone change',
    keys: ['Ctrl+y', 'Ctrl+Shift+z'],
    group: 'Changes',
    run: (session) => session.redo(),
  },
  {
    name: 'straighten',
    label: 'Straighten',
    help: 'straighten the outline between two selected points',
    keys: ['s'],
    group: 'Shape',
    run: straightenSelected,
  },
  {
    name: 'smooth',
    label: 'To curve',
    help: 'make the selected corners smooth',
    keys: ['c'],
    group: 'Shape',
    run: (session) => bendSelected(session, toCurve, 'smooth'),
  },
  {
    name: 'corner',
    label: 'To corner',
    help: 'make the selected smooth points corners',
    keys: ['k'],
    group: 'Shape',
    run: (session) => bendSelected(session, toCorner, 'a corner'),
  },
  {
    name: 'add',
    label: 'Add point',
    help: 'add a control point in the middle of each selected edge',
    keys: ['a'],
    group: 'Shape',
    run: addSelected,
  },
  {
    name: 'remove',
    label: 'Remove point',
    help: 'remove the selected control points; lengths stay',
    keys: ['Delete', 'Backspace'],
    group: 'Shape',
    run: removeSelected,
  },
  {
    name: 'equalise',
    label: 'Equalise seams',
    help: 'move points as little as possible until both sides of every seam are equally long',
    keys: ['e'],
    group: 'Shape',
    run: equalise,
  },
  {
    name: 'cut',
    label: 'Cut panel',
    help: 'cut a panel between two selected points',
    keys: ['x'],
    group: 'Panels',
    run: cutSelected,
  },
  {
    name: 'join',
    label: 'Join panels',
    help: 'join two panels along the selected seam',
    keys: ['j'],
    group: 'Panels',
    run: joinSelected,
  },
  {
    name: 'pivot',
    label: 'Pivot dart',
    help: "turn the dart of the selected apex to the other selected point",
    keys: ['v'],
    group: 'Panels',
    run: pivotSelected,
  },
  {
    name: 'undart',
    label: 'Remove dart',
    help: 'close the dart of the selected apex or leg at the middle of its mouth',
    keys: ['b'],
    group: 'Panels',
    run: removeSelectedDart,
  },
  {
    name: 'left',
    label: 'Turn left',
    help: 'turn the selected panels on the board by 5 degrees',
    keys: ['['],
    group: 'Panels',
    run: (session) => turnSelected(session, TURN),
  },
  {
    name: 'right',
    label: 'Turn right',
    help: 'turn the selected panels to the other side',
    keys: [']'],
    group: 'Panels',
    run: (session) => turnSelected(session, -TURN),
  },
  {
    name: 'next',
    label: 'Next point',
    help: 'select the next control point; with Shift add it to the selection',
    keys: ['n', 'Shift+n'],
    group: 'Select',
    run: (session, _camera, more) => step(session, 1, more),
  },
  {
    name: 'previous',
    label: 'Previous point',
    help: 'select the previous control point',
    keys: ['p', 'Shift+p'],
    group: 'Select',
    run: (session, _camera, more) => step(session, -1, more),
  },
  {
    name: 'edge',
    label: 'Edge',
    help: 'select the edge that begins at the selected point',
    keys: ['d'],
    group: 'Select',
    run: selectEdge,
  },
  {
    name: 'panel',
    label: 'Panel',
    help: 'select the panel of the selection, or the next panel',
    keys: ['g'],
    group: 'Select',
    run: selectPanel,
  },
  {
    name: 'all',
    label: 'All points',
    help: 'select all points of the selected panels, else of all',
    keys: ['Ctrl+a'],
    group: 'Select',
    run: selectAll,
  },
  {
    name: 'handle',
    label: 'Handle',
    help: 'select the next handle of the selected edge or point',
    keys: ['h'],
    group: 'Select',
    run: selectHandle,
  },
  {
    name: 'nothing',
    label: 'Nothing',
    help: 'select nothing; stop a drag',
    keys: ['Escape'],
    group: 'Select',
    run: (session) => {
      session.cancel();
      session.select([]);
    },
  },
  {
    name: 'fit',
    label: 'Show all',
    help: 'show the whole pattern',
    keys: ['f', '0'],
    group: 'View',
    run: (session) => session.tell('fit'),
  },
  {
    name: 'nearer',
    label: 'Zoom in',
    help: 'also by the wheel or two fingers',
    keys: ['+', '='],
    group: 'View',
    run: (_session, camera) => camera.zoom(1.25),
  },
  {
    name: 'further',
    label: 'Zoom out',
    help: '',
    keys: ['-'],
    group: 'View',
    run: (_session, camera) => camera.zoom(0.8),
  },
];

/** Return the command of a key press, or null. */
export function commandOf(event) {
  const letter = /^[a-z]$/i.test(event.key);
  const name = `${event.ctrlKey || event.metaKey ? 'Ctrl+' : ''}${letter && event.shiftKey ? 'Shift+' : ''}${letter ? event.key.toLowerCase() : event.key}`;
  return COMMANDS.find((command) => command.keys.includes(name)) ?? null;
}

/**
 * Move the selection by arrow keys: points and handles in the pattern, panels on the board.
 *
 * @param {[number, number]} by   on the board [mm, y up]
 */
export function nudge(session, by) {
  const items = session.selection.filter((item) => ['point', 'handle'].includes(kindOf(item)));
  if (items.length) {
    const moves = items.map((item) => ({ item, by: turnBack(session.placeOf(item.panel), by) }));
    return session.change((pattern) => moveItems(pattern, moves, session.keep), `Moved by ${by[0]}, ${by[1]} mm.`);
  }
  const panels = session.selected('panel');
  if (!panels.length) return false;
  const move = { x: by[0] / 1e3, y: by[1] / 1e3 };
  return session.change(
    (pattern) => movePanels(session, pattern, panels, move),
    'Moved on the board; the pattern is unchanged.',
  );
}

/** Return a pattern with the selected panels moved on the board. */
export function movePanels(session, pattern, items, move) {
  return items.reduce(
    (state, { panel }) => movePlace(state, getPanel(state, panel), session.placeOf(panel, pattern), move),
    pattern,
  );
}

/** Return a pattern with the place of each panel, so that the parts of a cut panel keep it. */
export function withPlaces(session, pattern) {
  return { ...pattern, layout: Object.fromEntries(pattern.panels.map(({ name }) => [name, session.placeOf(name)])) };
}

function twoPoints(session, what) {
  const points = session.selected('point');
  if (points.length !== 2) throw new PatternError(`select exactly two control points of one panel ${what}.`);
  return points;
}

function straightenSelected(session) {
  session.change(
    (pattern) => straighten(pattern, ...twoPoints(session, 'to straighten the outline between them'), session.keep),
    'Straightened.',
  );
}

function bendSelected(session, operation, became) {
  session.change((pattern) => {
    const points = session.selected('point');
    if (!points.length) throw new PatternError('select one or more control points.');
    return points.reduce((state, point) => operation(state, point, session.keep), pattern);
  }, `The point is now ${became}.`);
}

function addSelected(session) {
  let added = null;
  const done = session.change((pattern) => {
    const [edge, ...more] = session.selected('edge');
    if (!edge || more.length) throw new PatternError('select one edge to add a control point to.');
    added = addPoint(pattern, { ...edge, fraction: 0.5 }, session.keep);
    return added.pattern;
  }, 'Added a control point; no edge changed its shape.');
  if (done) session.select([added.point]);
}

function removeSelected(session) {
  const done = session.change((pattern) => {
    const points = [...session.selected('point')];
    if (!points.length) throw new PatternError('select the control points to remove.');
    // Numbers above a removed point change, so each is found again by its place.
    const places = points.map(({ panel, point }) => ({ panel, place: getPanel(pattern, panel).points[point] }));
    return places.reduce((state, { panel, place }) => {
      const point = getPanel(state, panel).points.findIndex((at) => at[0] === place[0] && at[1] === place[1]);
      return point < 0 ? state : removePoint(state, { panel, point }, session.keep);
    }, pattern);
  }, 'Removed; the outline is as long as before.');
  if (done) session.select([]);
}

function equalise(session) {
  const mirrors = session.options.symmetric ? findMirrors(session.present) : [];
  session.change(
    (pattern) => keepSeams(pattern, { before: null, held: [], mirrors }),
    'The sides of all seams are equally long.',
  );
}

function cutSelected(session) {
  const done = session.change(
    (pattern) => cutBetween(withPlaces(session, pattern), ...twoPoints(session, 'to cut between them'), session.keep),
    'Cut in two; a seam joins the halves.',
  );
  if (done) session.select([]);
}

function joinSelected(session) {
  const done = session.change((pattern) => {
    const [edge] = session.selected('edge');
    const sewn = edge ? seamOf(pattern, edge) : null;
    if (!sewn) throw new PatternError('select an edge that is sewn to another panel, to join both along it.');
    return joinAlong(withPlaces(session, pattern), sewn.index, session.keep);
  }, 'Joined into one panel.');
  if (done) session.select([]);
}

function turnSelected(session, turn) {
  session.change((pattern) => {
    const panels = session.selected('panel');
    if (!panels.length) throw new PatternError('select a panel to turn it on the board.');
    return movePanels(session, pattern, panels, { turn });
  }, 'Turned on the board; the pattern is unchanged.');
}

function step(session, by, more) {
  const points = session.present.panels.flatMap((panel) =>
    panel.points.map((_, point) => ({ panel: panel.name, point })),
  );
  const last = session.selection[session.selection.length - 1];
  const at = points.findIndex((point) => point.panel === last?.panel && point.point === (last.point ?? 0));
  const next = points[(at < 0 ? (by > 0 ? 0 : points.length - 1) : at + by + points.length) % points.length];
  session.select([next], more);
}

function selectEdge(session) {
  const last = session.selection[session.selection.length - 1] ?? { panel: session.present.panels[0].name, point: 0 };
  const count = getPanel(session.present, last.panel).points.length;
  session.select([{ panel: last.panel, edge: last.point ?? ((last.edge ?? -1) + 1) % count }]);
}

function selectPanel(session) {
  const names = session.present.panels.map((panel) => panel.name),
    last = session.selection[session.selection.length - 1];
  const next = last && kindOf(last) !== 'panel' ? last.panel : names[(names.indexOf(last?.panel) + 1) % names.length];
  session.select([{ panel: next }]);
}

function selectAll(session) {
  const chosen = session.selected('panel').map((item) => item.panel);
  const panels = session.present.panels.filter((panel) => !chosen.length || chosen.includes(panel.name));
  session.select(panels.flatMap((panel) => panel.points.map((_, point) => ({ panel: panel.name, point }))));
}

function selectHandle(session) {
  const last = session.selection[session.selection.length - 1];
  if (!last || kindOf(last) === 'panel') return session.say('Select a control point or an edge with a curve.', true);
  const panel = getPanel(session.present, last.panel),
    count = panel.points.length;
  const edges = last.edge !== undefined ? [last.edge] : [last.point, (last.point - 1 + count) % count];
  const handles = edges.flatMap((edge) =>
    panel.edges[edge].handles.map((_, handle) => ({ panel: panel.name, edge, handle })),
  );
  if (!handles.length) return session.say('There is no curve here, so there is no handle.', true);
  const at = last.handle === undefined ? -1 : handles.findIndex((item) => item.handle === last.handle);
  return session.select([handles[(at + 1) % handles.length]]);
}
