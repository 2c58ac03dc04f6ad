// What the form's fields order.
import { uploadFile } from './api.js';

/** @param {FormData} form @returns {Promise<any>} an order for `/v1/jobs` without its scan; its other files are uploaded */
export async function readOrder(form) {
  const upload = async (kind, file) => (await uploadFile(kind, file)).sha256;
  const text = (name) => String(form.get(name) ?? '').trim();
  const file = (name) => (form.get(name)?.size ? form.get(name) : null);
  const order = {};
  if (file('body_file')) order.body = await upload('bodies', file('body_file'));
  else if (text('body')) order.body = text('body');
  if (file('labels')) order.labels = await upload('labels', file('labels'));
  for (const name of ['name', 'as', 'wearing', 'template']) if (text(name)) order[name] = text(name);
  const tags = text('tags').split(',').map((tag) => tag.trim()).filter(Boolean);
  if (tags.length) order.tags = tags;
  const settings = {};
  for (const name of ['fabric', 'quality', 'method', 'redrape', 'units', 'up']) if (text(name)) settings[name] = text(name);
  if (text('height')) settings.height = Number(text('height'));
  if (Object.keys(settings).length) order.settings = settings;
  return order;
}

/** Options that change what is detected in a scan, besides files. */
export const DETECTED_BY = ['as', 'body', 'units', 'up', 'height'];

/** @param {FormData} form @returns {Record<string, string>} the options that change what is detected in a scan */
export function readDetected(form) {
  const values = DETECTED_BY.map((name) => [name, String(form.get(name)).trim()]);
  return Object.fromEntries(values.filter(([, text]) => text));
}
