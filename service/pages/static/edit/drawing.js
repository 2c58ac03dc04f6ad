/** The pattern as one SVG drawing, in mm with y down: a group for each panel, redrawn where its panel or its look changed. */

import { draw } from '../dom.js';
import { between, isStraight, pathCommand, placeOnChord, unitPoint } from './edge_geometry.js';
import { chordOf, getPanel, handlePoints } from './pattern_model.js';
import { possiblePoints } from './point_operations.js';
import { pointWords } from './names.js';
import { path, showParts } from './parts.js';
import { kindOf } from './session.js';
import { findMirrors, imagePoints } from './symmetry.js';

/** Colours for pairs of panels or points; they come again after this many. */
const COLOURS = 8;
/** Length of a notch [mm]. */
const NOTCH = 6;

const mm = ([x, y]) => [1e3 * x, -1e3 * y];
const pair = ([x, y]) => `${x.toFixed(3)} ${y.toFixed(3)}`;
/** A dot that keeps its size at any zoom: a line without length and with a round or square end. */
const dot = (name, at, data) => path(`dot ${name}`, `M ${pair(mm(at))} h 0.001`, data);

export class Drawing {
  /** @param {SVGSVGElement} svg @param {import("./session.js").Session} session */
  constructor(svg, session) {
    this.session = session;
    this.groups = new Map();
    this.layer = draw('g', { class: 'panels' });
    this.marks = draw('g', { class: 'marks' });
    svg.append(this.layer, this.marks);
  }

  /** Draw the shown state; what has not changed stays. */
  render() {
    const { session } = this,
      { pattern } = session;
    const shared = this.shareLooks(pattern);
    for (const [name, group] of this.groups) {
      if (getPanel(pattern, name)) continue;
      group.element.remove();
      this.groups.delete(name);
    }
    for (const panel of pattern.panels) {
      const selected = session.selection.filter((item) => item.panel === panel.name);
      const place = session.placeOf(panel.name);
      const look = JSON.stringify([selected, shared.get(panel.name), session.options, place.turn]);
      let group = this.groups.get(panel.name);
      if (!group) {
        group = { element: draw('g', { class: 'panel', 'data-panel': panel.name }), parts: [] };
        this.groups.set(panel.name, group);
        this.layer.append(group.element);
      }
      if (group.place !== place) {
        const turn = (-place.turn * 180) / Math.PI;
        group.element.setAttribute(
          'transform',
          `translate(${(1e3 * place.x).toFixed(4)} ${(-1e3 * place.y).toFixed(4)}) rotate(${turn.toFixed(6)})`,
        );
      }
      let { parts } = group;
      if (group.panel !== panel || group.look !== look) {
        parts = this.drawPanel(panel, selected, shared.get(panel.name));
        showParts(group.element, group.parts, parts);
      }
      Object.assign(group, { panel, look, place, parts });
    }
  }

  /** Return what of a panel's look depends on others: mirror colours, seams that do not match, what failed. */
  shareLooks(pattern) {
    const { options, faults } = this.session;
    const looks = new Map(
      pattern.panels.map((panel) => [
        panel.name,
        { mirror: null, images: null, faults: faults.filter((fault) => fault.panel === panel.name) },
      ]),
    );
    if (!options.between && !options.within) return looks;
    // A drag keeps the mirror images and the order of a panel's points.
    findMirrors(this.session.present).forEach(({ source, target, order }, k) => {
      const [a, b] = [pattern.panels[source].name, pattern.panels[target].name];
      if (a !== b && options.between) {
        looks.get(a).mirror = { colour: k % COLOURS, other: b };
        looks.get(b).mirror = { colour: k % COLOURS, other: a };
      }
      if (a === b && options.within) looks.get(a).images = order;
    });
    return looks;
  }

  drawPanel(panel, selected, look) {
    const { session } = this,
      { options, pattern } = session;
    const outline = this.outline(panel);
    const parts = [];
    if (options.allowance > 0)
      parts.push(path('allowance', outline, { 'stroke-width': 2 * options.allowance }));
    const whole = selected.some((item) => kindOf(item) === 'panel');
    const colour = look.mirror ? ` pair-${look.mirror.colour}` : '';
    parts.push(path(`cloth${whole ? ' selected' : ''}${colour}`, outline, { 'data-mirror': look.mirror?.other }));
    if (look.images) parts.push(axisOf(session.present, panel));
    if (options.difference) {
      const before = getPanel(session.original, panel.name);
      if (before) parts.push(path('before', this.outline(before)));
    }
    panel.edges.forEach((edge, at) => parts.push(this.drawEdge(panel, at, selected, look)));
    panel.notches.forEach(([edge, at]) => parts.push(drawNotch(panel, edge, at)));
    parts.push(nameOf(panel, session.placeOf(panel.name).turn));
    if (options.possible) parts.push(...this.drawPossible({ ...pattern, panels: [panel] }));
    if (options.handles) parts.push(...this.drawHandles(panel, selected));
    panel.points.forEach((point, at) => {
      const chosen = selected.some((item) => item.point === at);
      const image = look.images ? ` image image-${Math.min(at, look.images[at]) % COLOURS}` : '';
      const fault = look.faults.some((one) => one.point === at) ? ' fault' : '';
      parts.push(
        dot(`point${chosen ? ' selected' : ''}${image}${fault}`, point, {
          'data-point': at,
          'data-image': look.images?.[at],
        }),
      );
    });
    return parts;
  }

  outline(panel) {
    const commands = panel.edges.map((edge, at) => pathCommand(edge, drawnEdge(panel, at)));
    return `M ${pair(mm(panel.points[0]))} ${commands.join(' ')} Z`;
  }

  drawEdge(panel, at, selected, look) {
    const chosen = selected.some((item) => kindOf(item) === 'edge' && item.edge === at);
    const fault = look.faults.some((one) => one.edge === at && one.point === undefined) ? ' fault' : '';
    const drawn = drawnEdge(panel, at);
    const d = `M ${pair(drawn[0])} ${pathCommand(panel.edges[at], drawn)}`;
    return path(`edge${chosen ? ' selected' : ''}${fault}`, d, { 'data-edge': at });
  }

  /** Draw where control points could be added, one path for each edge. */
  drawPossible(pattern) {
    const ways = new Map();
    for (const { edge, place } of possiblePoints(pattern)) {
      ways.set(edge, `${ways.get(edge) ?? ''} M ${pair(mm(place))} h 0.001`);
    }
    return [...ways].map(([edge, d]) => path('dot possible', d, { 'data-edge': edge }));
  }

  /** Draw the handles of curves at selected points and of selected edges. */
  drawHandles(panel, selected) {
    const count = panel.points.length;
    return panel.edges.flatMap((edge, at) => {
      const near = selected.some((item) => item.edge === at || item.point === at || item.point === (at + 1) % count);
      if (!near || !edge.handles.length) return [];
      const ends = chordOf(panel, at);
      return handlePoints(panel, at).flatMap((place, handle) => {
        const chosen = selected.some((item) => item.edge === at && item.handle === handle) ? ' selected' : '';
        const from = edge.kind === 'cubic' ? ends[handle] : between(...ends, 0.5);
        return [
          path('arm', `M ${pair(mm(from))} L ${pair(mm(place))}`),
          dot(`handle${chosen}`, place, { 'data-edge': at, 'data-handle': handle }),
        ];
      });
    });
  }

  /** Draw what lies over the panels: a box, a ruler, a line to cut along; board mm. */
  mark(...elements) {
    this.marks.replaceChildren(...elements);
  }
}

function drawnEdge(panel, at) {
  const [start, end] = chordOf(panel, at);
  return [start, ...handlePoints(panel, at), end].map(mm);
}

function drawNotch(panel, edge, at) {
  const [here, from, to] = placeOnChord(unitNotch(panel.edges[edge], at), ...chordOf(panel, edge)).map(mm);
  const along = [to[0] - from[0], to[1] - from[1]],
    size = Math.hypot(...along) || 1;
  return path('notch', `M ${pair(here)} l ${pair([(NOTCH * along[1]) / size, (-NOTCH * along[0]) / size])}`);
}

const notches = new WeakMap();

/** Return where a notch is, and two points that it stands across, in the edge's chord; kept with the edge. */
function unitNotch(edge, at) {
  if (notches.get(edge)?.at !== at) {
    const across = isStraight(edge) ? [0, 1] : [Math.max(at - 0.01, 0), Math.min(at + 0.01, 1)];
    notches.set(edge, { at, points: [at, ...across].map((share) => unitPoint(edge, share)) });
  }
  return notches.get(edge).points;
}

/** Write a panel's name in its middle, upright, a word on each line, so that neighbours' names do not overlap. */
function nameOf(panel, turn) {
  const middle = [0, 1].map((k) => panel.points.reduce((sum, point) => sum + point[k], 0) / panel.points.length);
  const [x, y] = mm(middle).map((value) => value.toFixed(1));
  const words = panel.name.split('_');
  const parts = words.map((text, line) => ({ tag: 'tspan', attributes: { x, dy: line ? '1.15em' : 0 }, text }));
  return { tag: 'text', attributes: { class: 'name', x, y, transform: `rotate(${((turn * 180) / Math.PI).toFixed(3)} ${x} ${y})` }, parts };
}

/** Draw the axis on which a panel is its own mirror image. */
function axisOf(pattern, panel) {
  const index = pattern.panels.findIndex(({ name }) => name === panel.name);
  const { rotation } = findMirrors(pattern).find(({ source, target }) => source === index && target === index);
  const angle = Math.atan2(rotation[1][0], rotation[0][0]) / 2,
    way = [Math.cos(angle), Math.sin(angle)];
  const middle = [0, 1].map((k) => panel.points.reduce((sum, point) => sum + point[k], 0) / panel.points.length);
  const along = panel.points.map((point) => (point[0] - middle[0]) * way[0] + (point[1] - middle[1]) * way[1]);
  const ends = [Math.min(...along) - 0.03, Math.max(...along) + 0.03].map((t) =>
    mm([middle[0] + t * way[0], middle[1] + t * way[1]]),
  );
  return path('axis', `M ${pair(ends[0])} L ${pair(ends[1])}`);
}

/** Return the images of a selected point, as text. */
export function describeImages(pattern, point) {
  return imagePoints(pattern, findMirrors(pattern), point).map((image) => pointWords(pattern, image));
}
