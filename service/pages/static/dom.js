// Making elements; text is always text, never HTML.
import { speakOfControls } from './words.js';

/**
 * Make an element.
 * @param {string} name tag, with classes: 'p.error'
 * @param {Record<string, any>} [attributes] attributes; `on...` are listeners; null and false are left out
 * @param {...(Node|string|null)} children
 * @returns {HTMLElement}
 */
export function make(name, attributes = {}, ...children) {
  const [tag, ...classes] = name.split('.');
  const element = document.createElement(tag);
  if (classes.length) element.className = classes.join(' ');
  set(element, attributes);
  element.append(...children.filter((child) => child !== null));
  return element;
}

const SVG = 'http://www.w3.org/2000/svg';

/**
 * Make an element of a drawing.
 * @param {string} tag @param {Record<string, any>} [attributes] @param {...Node} children
 * @returns {SVGElement}
 */
export function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, tag);
  set(element, attributes);
  element.append(...children);
  return element;
}

/** @param {Element} element @param {Record<string, any>} attributes */
function set(element, attributes) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(key, value === true ? '' : value);
  }
}

/** @param {string} selector @param {ParentNode} [root] @returns {any} the element, which is there */
export function find(selector, root = document) {
  const found = root.querySelector(selector);
  if (!found) throw new Error(`the page has no ${selector}`);
  return found;
}

/**
 * Show an error on the page, for screen readers too.
 * @param {Element} place @param {unknown} error
 */
export function showError(place, error) {
  const code = error && /** @type {any} */ (error).code;
  place.replaceChildren(make('p.error', { role: 'alert' }, speakOfControls(String(error?.message ?? error)), code ? ' ' : null,
    code ? make('code', {}, code) : null));
}
