/** Mouse, pen and fingers on the board: select, box, drag, pan, pinch, the tools. */

import { draw } from '../dom.js';
import { add, norm, subtract } from './edge_geometry.js';
import { movePanels, withPlaces } from './commands.js';
import { getPanel, handlePoints } from './pattern_model.js';
import { fromBoard, turnBack, turnOut } from './layout.js';
import { moveItems } from './movement.js';
import { contains, cutAlong } from './panel_operations.js';
import { panelOutline } from './pattern_model.js';
import { pick, pickBox, snap } from './picking.js';
import { addPoint } from './point_operations.js';
import { kindOf } from './session.js';

/** A pointer that moves less than this is a click [px]. */
const CLICK = 3;
/** A point comes in line with another within this [px]. */
const ALIGN = 6;
/** The wheel's zoom for each unit it turns. */
const WHEEL = 0.0015;

export class Pointer {
  constructor(svg, session, camera, drawing) {
    Object.assign(this, { svg, session, camera, drawing, down: new Map(), act: null, waiting: null });
    svg.addEventListener('pointerdown', (event) => this.press(event));
    svg.addEventListener('pointermove', (event) => this.move(event));
    svg.addEventListener('pointerup', (event) => this.release(event));
    svg.addEventListener('pointercancel', () => this.stop());
    svg.addEventListener('pointerleave', () => session.setHover(null));
    svg.addEventListener('wheel', (event) => this.turnWheel(event), { passive: false });
  }

  /** Return a place of the window on the board [mm]. */
  place(event) {
    return this.camera.toBoard(event.clientX, event.clientY);
  }

  press(event) {
    this.svg.focus({ preventScroll: true });
    this.svg.setPointerCapture(event.pointerId);
    this.down.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.down.size === 2) {
      this.stop();
      this.act = { kind: 'pinch' };
      return;
    }
    this.act = this.begin(event, this.place(event));
  }

  begin(event, at) {
    const { session } = this,
      from = [event.clientX, event.clientY];
    if (event.button === 1 || session.tool === 'pan') return { kind: 'pan', last: from };
    if (session.tool === 'ruler' || session.tool === 'cut') return { kind: session.tool, at };
    const hit = pick(session, at, this.camera.scale, event.pointerType);
    if (hit.possible) return { kind: 'possible', hit, from };
    if (!hit.item)
      return event.pointerType === 'touch'
        ? { kind: 'pan', last: from, from, clears: true }
        : { kind: 'box', at, from, more: event.shiftKey };
    const more = event.shiftKey,
      was = session.isSelected(hit.item);
    if (more) session.select([hit.item], true);
    else if (!was) session.select([hit.item]);
    const kind = { point: 'points', handle: 'points', edge: 'none', panel: 'panels' }[kindOf(hit.item)];
    return { kind, at, from, hit, single: was && !more, start: session.present };
  }

  move(event) {
    const last = this.down.get(event.pointerId);
    if (this.down.has(event.pointerId)) this.down.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.act?.kind === 'pinch') return this.pinch(event.pointerId, last);
    if (!this.act) return this.hover(event);
    const { act } = this,
      here = [event.clientX, event.clientY];
    if (act.kind === 'pan') {
      this.camera.pan(here[0] - act.last[0], here[1] - act.last[1]);
      act.last = here;
      return undefined;
    }
    if (act.from && !act.moving && norm(subtract(here, act.from)) < CLICK) return undefined;
    act.moving = true;
    // Of all movements before the next frame only the last one is drawn.
    this.latest = { at: this.place(event), free: event.altKey };
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      if (this.act === act) this.drag(act, this.latest);
    });
    return undefined;
  }

  drag(act, { at, free }) {
    if (act.kind === 'points') this.dragPoints(act, at, free);
    if (act.kind === 'panels') this.dragPanels(act, at);
    if (act.kind === 'box') this.drawing.mark(boxOf(act.at, at));
    if (act.kind === 'ruler' || act.kind === 'cut') this.drawing.mark(lineOf(act.at, at, act.kind));
    if (act.kind === 'ruler') this.session.say(`${norm(subtract(at, act.at)).toFixed(1)} mm`);
  }

  dragPoints(act, at, free) {
    const { session } = this,
      { item } = act.hit;
    const panel = getPanel(act.start, item.panel),
      place = session.placeOf(item.panel);
    const old = item.point !== undefined ? panel.points[item.point] : handlePoints(panel, item.edge)[item.handle];
    let by = turnBack(place, [at[0] - act.at[0], act.at[1] - at[1]]);
    if (!free) {
      const moving = session.selection
        .filter((other) => other.panel === item.panel && other.point !== undefined)
        .map((other) => other.point);
      by = subtract(snap(session, panel, add(old, by), moving, (ALIGN * this.camera.scale) / 1e3), old);
    }
    const out = turnOut(place, by);
    const items = session.selection.filter((other) => ['point', 'handle'].includes(kindOf(other)));
    const moves = items.map((other) => ({
      item: other,
      by: other.panel === item.panel ? by : turnBack(session.placeOf(other.panel), out),
    }));
    try {
      session.preview(moveItems(act.start, moves, session.keep));
      session.say(`moved by ${out[0].toFixed(1)}, ${out[1].toFixed(1)} mm`);
    } catch (error) {
      session.refuse(error);
    }
  }

  dragPanels(act, at) {
    const { session } = this;
    const move = { x: (at[0] - act.at[0]) / 1e3, y: (act.at[1] - at[1]) / 1e3 };
    session.preview(movePanels(session, act.start, session.selected('panel'), move));
  }

  release(event) {
    const { act, session } = this;
    this.down.delete(event.pointerId);
    this.act = null;
    if (!act || act.kind === 'pinch') return;
    if (this.waiting !== null) {
      cancelAnimationFrame(this.waiting);
      this.waiting = null;
      this.drag(act, this.latest);
    }
    const at = this.place(event);
    this.drawing.mark();
    if (act.kind === 'points' || act.kind === 'panels') {
      if (act.moving) session.commit();
      else if (act.single) session.select([act.hit.item]);
    }
    if (act.kind === 'box') session.select(act.moving ? pickBox(session, act.at, at) : [], act.more);
    if (act.kind === 'pan' && act.clears && norm(subtract(act.last, act.from)) < CLICK) session.select([]);
    if (act.kind === 'possible' && !act.moving) this.addPossible(act.hit.possible);
    if (act.kind === 'cut') this.cut(act.at, at);
  }

  addPossible(spot) {
    const { session } = this;
    let added = null;
    const done = session.change((pattern) => {
      added = addPoint(pattern, spot, session.keep);
      return added.pattern;
    }, 'Added a control point; no edge changed its shape.');
    if (done) session.select([added.point]);
  }

  cut(from, to) {
    const { session } = this;
    const middle = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
    const panel = session.present.panels.find(({ name }) =>
      contains(panelOutline(getPanel(session.present, name)), fromBoard(session.placeOf(name), middle)),
    );
    if (!panel) return session.say('Draw the line across a panel to cut it.', true);
    const ends = [from, to].map((at) => fromBoard(session.placeOf(panel.name), at));
    return session.change(
      (pattern) =>
        cutAlong(withPlaces(session, pattern), panel.name, ends, (ALIGN * this.camera.scale) / 1e3, session.keep),
      'Cut in two; a seam joins the halves.',
    );
  }

  stop() {
    if (this.waiting !== null) cancelAnimationFrame(this.waiting);
    Object.assign(this, { act: null, waiting: null });
    this.drawing.mark();
    this.session.cancel();
  }

  hover(event) {
    const hit = pick(this.session, this.place(event), this.camera.scale, event.pointerType);
    this.session.setHover(hit.place ? { panel: (hit.item ?? hit.possible).panel, place: hit.place } : null);
  }

  pinch(moved, last) {
    const other = [...this.down.entries()].find(([id]) => id !== moved)?.[1],
      here = this.down.get(moved);
    if (!other || !last) return;
    const middle = this.camera.toBoard((other[0] + here[0]) / 2, (other[1] + here[1]) / 2);
    this.camera.zoom(norm(subtract(here, other)) / Math.max(norm(subtract(last, other)), 1), middle);
    this.camera.pan((here[0] - last[0]) / 2, (here[1] - last[1]) / 2);
  }

  turnWheel(event) {
    event.preventDefault();
    this.camera.zoom(Math.exp(-event.deltaY * WHEEL), this.place(event));
  }
}

const boxOf = (a, b) =>
  draw('rect', {
    class: 'box',
    x: Math.min(a[0], b[0]),
    y: Math.min(a[1], b[1]),
    width: Math.abs(a[0] - b[0]),
    height: Math.abs(a[1] - b[1]),
  });
const lineOf = (a, b, kind) => draw('path', { class: kind, d: `M ${a[0]} ${a[1]} L ${b[0]} ${b[1]}` });
