// The pairs of pieces, and what the service measured of each pair.

import { getJson } from '../api.js';

/**
 * @typedef {{first: string, second: string, paired_by: string, turning: number, area_percent: number,
 *   outline_mm: number, turned_over: boolean, angle: number, shift: [number, number]}} Pair
 */

/** Colours of pairs, told apart by lightness as well as by hue; the number in each piece says the same. */
const COLOURS = ['#2f6f9f', '#c2571a', '#3d8b4f', '#8f4b9b', '#b8860b', '#c0395b', '#2a8c8c', '#6b5b3e', '#5566cc',
  '#7a9a01'];

/** Holds the pairs, and notifies listeners of each change. */
export class Pairing extends EventTarget {
  /** @param {string} first @param {string} second jobs, templates, or uploads by their hash */
  constructor(first, second) {
    super();
    this.words = [first, second];
    /** @type {Pair[]} */
    this.pairs = [];
    /** @type {Record<string, [number, number][]>[]} outlines of both patterns by name */
    this.outlines = [{}, {}];
  }

  /** Let the service propose pairs. @param {string[]} given pairs that are kept, each `first:second` */
  async propose(given = []) {
    const found = await this.#ask(given, { outlines: 'true' });
    this.outlines = [found.first_outlines, found.second_outlines];
    this.pairs = found.pairs;
    this.#tell();
  }

  /** Pair two pieces by hand; what either was paired with before is free. @param {string} first @param {string} second */
  async pair(first, second) {
    const found = await this.#ask([`${first}:${second}`], { only_given: 'true' });
    this.pairs = this.pairs.filter((pair) => pair.first !== first && pair.second !== second).concat(found.pairs);
    const places = Object.keys(this.outlines[1]);
    this.pairs.sort((one, other) => places.indexOf(one.second) - places.indexOf(other.second));
    this.#tell();
  }

  /** Remove a pair. @param {number} row 0 or 1 @param {string} name of a piece in it */
  part(row, name) {
    this.pairs = this.pairs.filter((pair) => (row ? pair.second : pair.first) !== name);
    this.#tell();
  }

  /** @param {number} row @param {string} name @returns {number} the pair's place in the list, or -1 */
  find(row, name) {
    return this.pairs.findIndex((pair) => (row ? pair.second : pair.first) === name);
  }

  /** @param {number} row @returns {string[]} the pieces without a counterpart */
  alone(row) {
    return Object.keys(this.outlines[row]).filter((name) => this.find(row, name) < 0);
  }

  /** @param {number} index @returns {string} the pair's colour */
  colour(index) {
    return COLOURS[index % COLOURS.length];
  }

  /** @param {string[]} pairs @param {Record<string, string>} options */
  #ask(pairs, options) {
    const params = new URLSearchParams({ first: this.words[0], second: this.words[1], ...options });
    for (const pair of pairs) params.append('pair', pair);
    return getJson(`/v1/match?${params}`);
  }

  #tell() {
    this.dispatchEvent(new Event('change'));
  }
}
