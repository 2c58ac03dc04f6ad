/**
 * What is drawn, as a list of parts: an element stays in the document while its part changes, and only what differs is
 * set.
 *
 * @typedef {{tag: string, attributes: Record<string, any>, text?: string, parts?: Part[], element?: SVGElement}} Part
 */

import { draw } from '../dom.js';

/** Return a path with a class and other attributes, to be drawn by `showParts`. */
export const path = (className, d, attributes = {}) => ({
  tag: 'path',
  attributes: { class: className, d, ...attributes },
});

/**
 * Draw parts in a place instead of those that it has.
 *
 * @param {Element} place   has the elements of `shown` and no others @param {Part[]} shown @param {Part[]} wanted
 */
export function showParts(place, shown, wanted) {
  wanted.forEach((part, k) => {
    const old = shown[k];
    if (old?.tag === part.tag) change(old, part);
    else {
      make(part);
      if (old) old.element.replaceWith(part.element);
      else place.append(part.element);
    }
  });
  for (const { element } of shown.slice(wanted.length)) element.remove();
}

function make(part) {
  part.element = draw(part.tag, part.attributes);
  if (part.text !== undefined) part.element.textContent = part.text;
  showParts(part.element, [], part.parts ?? []);
}

function change(old, part) {
  const { element } = old,
    { attributes } = part;
  part.element = element;
  for (const [name, value] of Object.entries(attributes)) {
    if (value === old.attributes[name]) continue;
    if (value === undefined) element.removeAttribute(name);
    else element.setAttribute(name, value);
  }
  for (const name of Object.keys(old.attributes)) if (!(name in attributes)) element.removeAttribute(name);
  if (part.text !== old.text) element.textContent = part.text;
  else if (part.text === undefined) showParts(element, old.parts ?? [], part.parts ?? []);
}
