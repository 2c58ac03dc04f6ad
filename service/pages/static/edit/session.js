/**
 * The state of the editor: the states of the pattern, the selection, the options. Views listen and draw it.
 *
 * Events: `pattern` (the shown state is another), `selection`, `options`, `faults`, `said` (text for users), `hover`, `fit`.
 *
 * @typedef {import("./movement.js").Item} Item   or {panel, edge} for an edge, or {panel} for a whole panel
 */

import { getPanel, PatternError } from './pattern_model.js';
import { layOut, overlaps } from './layout.js';

/** Most states that undo keeps; unchanged panels are shared between them. */
const KEPT = 500;

/** Return what kind of item is selected: `point`, `handle`, `edge` or `panel`. */
export function kindOf(item) {
  if (item.point !== undefined) return 'point';
  if (item.handle !== undefined) return 'handle';
  return item.edge !== undefined ? 'edge' : 'panel';
}

/** Return whether two items are the same. */
export const sameItem = (a, b) =>
  a.panel === b.panel && a.point === b.point && a.edge === b.edge && a.handle === b.handle;

export class Session extends EventTarget {
  /** @param {import("./pattern_model.js").Pattern} pattern @param {object[][]} pieces   panels that are cut as one, placed in it */
  constructor(pattern, pieces = []) {
    super();
    this.pieces = pieces;
    this.aspect = 1.5;
    this.start(pattern);
    this.tool = 'select';
    this.options = {
      symmetric: true,
      sewn: true,
      step: 1,
      grid: 0,
      align: true,
      possible: false,
      between: false,
      within: false,
      allowance: 0,
      difference: false,
      handles: true,
    };
  }

  /** Compare with another pattern than the one that was opened: the one that was recovered. */
  compare(pattern) {
    this.original = pattern;
    this.tell('pattern');
  }

  /** Mark the places of the service's findings. */
  setFaults(items) {
    this.faults = items;
    this.tell('faults');
  }

  /** Begin with another pattern; what was done before cannot be undone. */
  start(pattern) {
    this.original = pattern;
    this.faults = [];
    this.states = [pattern];
    this.at = 0;
    this.shown = null;
    this.selection = [];
    this.places = layOut(pattern, this.aspect, this.pieces);
    this.tell('pattern');
    this.tell('selection');
  }

  /** Lay panels out for a board of another aspect (width over height). */
  arrange(aspect = this.aspect) {
    this.aspect = aspect;
    this.places = layOut(this.present, aspect, this.pieces);
    this.tell('pattern');
    this.tell('fit');
  }

  /** Return the state that is shown: what a drag makes, else the present one. */
  get pattern() {
    return this.shown ?? this.states[this.at];
  }

  /** Return the present state, without what a drag shows. */
  get present() {
    return this.states[this.at];
  }

  get canUndo() {
    return this.at > 0;
  }

  get canRedo() {
    return this.at < this.states.length - 1;
  }

  /** Return the options that operations keep to. */
  get keep() {
    return { symmetric: this.options.symmetric, sewn: this.options.sewn };
  }

  /** Return where a panel lies, in the shown state or another. */
  placeOf(name, pattern = this.pattern) {
    return pattern.layout[name] ?? this.places[name] ?? { x: 0, y: 0, turn: 0 };
  }

  /** Show a state without keeping it: a drag. */
  preview(pattern) {
    this.shown = pattern;
    this.tell('pattern');
  }

  /** Forget what was shown. */
  cancel() {
    if (this.shown === null) return;
    this.shown = null;
    this.tell('pattern');
  }

  /** Keep a state as the next one. */
  commit(pattern = this.shown) {
    this.shown = null;
    const before = this.present,
      isOverlapping = (state) => overlaps(state, (name) => this.placeOf(name, state), this.pieces);
    if (pattern && pattern !== this.present) {
      this.states = [...this.states.slice(Math.max(this.at - KEPT, 0), this.at + 1), pattern];
      this.at = this.states.length - 1;
    }
    this.dropGone();
    // What has grown over another is laid out anew; panels that were moved by hand stay where they are.
    const isGrown = this.present.panels !== before.panels && isOverlapping(this.present) && !isOverlapping(before);
    if (isGrown) this.arrange();
    this.tell('pattern');
  }

  /**
   * Change the pattern by an operation; if it refuses, show why and change nothing.
   *
   * @param {(pattern: object) => object} operation
   * @param {string|(() => string)} done   what to say
   */
  change(operation, done) {
    try {
      const next = operation(this.present);
      this.commit(next);
      this.say(typeof done === 'function' ? done() : done);
      return true;
    } catch (error) {
      this.refuse(error);
      return false;
    }
  }

  /** Show why an operation was refused; rethrow any other error. */
  refuse(error) {
    if (!(error instanceof PatternError)) throw error;
    this.say(error.message, true);
  }

  undo() {
    this.step(-1, 'Undone.', 'There is nothing to undo.');
  }

  redo() {
    this.step(1, 'Redone.', 'There is nothing to redo.');
  }

  step(by, done, refused) {
    const at = this.at + by;
    if (at < 0 || at >= this.states.length) return this.say(refused);
    this.at = at;
    this.shown = null;
    this.dropGone();
    this.tell('pattern');
    return this.say(done);
  }

  /** Select items, or with `more` add each to the selection or remove it. */
  select(items, more = false) {
    if (!more) this.selection = items;
    else {
      const off = items.filter((item) => this.isSelected(item));
      this.selection = [
        ...this.selection.filter((item) => !off.some((other) => sameItem(item, other))),
        ...items.filter((item) => !off.includes(item)),
      ];
    }
    this.tell('selection');
  }

  isSelected(item) {
    return this.selection.some((other) => sameItem(item, other));
  }

  /** Return the selected items of a kind. */
  selected(kind) {
    return this.selection.filter((item) => kindOf(item) === kind);
  }

  /** Unselect what the shown state does not have. */
  dropGone() {
    const kept = this.selection.filter((item) => {
      const panel = getPanel(this.pattern, item.panel);
      if (!panel) return false;
      const edge = panel.edges[item.edge];
      return item.point !== undefined
        ? item.point < panel.points.length
        : item.edge === undefined || (edge && (item.handle === undefined || item.handle < edge.handles.length));
    });
    if (kept.length === this.selection.length) return;
    this.selection = kept;
    this.tell('selection');
  }

  setOption(name, value) {
    this.options = { ...this.options, [name]: value };
    this.tell('options');
  }

  setTool(tool) {
    this.tool = tool;
    this.tell('options');
  }

  /** Say where in which panel the pointer is [m], or null. */
  setHover(hover) {
    this.hover = hover;
    this.tell('hover');
  }

  say(text, bad = false) {
    this.dispatchEvent(new CustomEvent('said', { detail: { text, bad } }));
  }

  tell(name) {
    this.dispatchEvent(new Event(name));
  }
}
