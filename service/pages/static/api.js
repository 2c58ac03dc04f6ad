// Requests to the service's routes under /v1, for every page.

/** An error of the service: `code` is stable, the message names the next step. */
export class Problem extends Error {
  /** @param {string} code @param {string} message @param {number} status */
  constructor(code, message, status) {
    super(message);
    this.name = 'Problem';
    this.code = code;
    this.status = status;
  }
}

/** @returns {string} the token that is sent with each change */
function readCsrf() {
  return document.querySelector('meta[name="csrf-token"]')?.getAttribute('content') ?? '';
}

/**
 * Send a request to the service; if the session has ended, open the sign-in page.
 * @param {string} path @param {RequestInit} [options]
 * @returns {Promise<Response>}
 */
export async function ask(path, options = {}) {
  const method = options.method ?? 'GET';
  const headers = new Headers(options.headers);
  if (method !== 'GET' && method !== 'HEAD') headers.set('X-CSRF-Token', readCsrf());
  let answer;
  try {
    answer = await fetch(path, { ...options, method, headers, credentials: 'same-origin' });
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') throw error;
    throw new Problem('service.unreachable', 'The service does not respond; check that it is running, then try again.', 0);
  }
  if (answer.ok) return answer;
  const told = await answer.json().catch(() => ({}));
  if (told.code === 'session.ended' || told.code === 'key.missing') {
    location.assign('/signin?next=' + encodeURIComponent(location.pathname + location.search));
  }
  throw new Problem(told.code ?? 'service.fault', told.detail ?? `The service answered ${answer.status}.`, answer.status);
}

/** @param {string} path @param {AbortSignal} [signal] @returns {Promise<any>} the answer's JSON */
export async function getJson(path, signal) {
  return (await ask(path, { signal })).json();
}

/** @param {string} path @param {string} method @param {unknown} [value] @returns {Promise<any>} the answer's JSON */
async function sendJson(path, method, value) {
  const body = value === undefined ? undefined : JSON.stringify(value);
  const headers = value === undefined ? {} : { 'Content-Type': 'application/json' };
  return (await ask(path, { method, body, headers })).json();
}

/** @param {string} path @param {unknown} [value] @returns {Promise<any>} the answer's JSON */
export const postJson = (path, value) => sendJson(path, 'POST', value);

/** @param {string} path @param {unknown} [value] @returns {Promise<any>} the answer's JSON */
export const putJson = (path, value) => sendJson(path, 'PUT', value);

/** @param {string} path @param {unknown} value @returns {Promise<any>} the answer's JSON */
export const patchJson = (path, value) => sendJson(path, 'PATCH', value);

/** Add a tag to those of a job's family. @param {string} job @param {string} tag */
export async function addTag(job, tag) {
  const { tags } = await getJson(`/v1/jobs/${job}`);
  if (!tags.includes(tag)) await patchJson(`/v1/jobs/${job}`, { tags: [...tags, tag] });
}

/** @param {string} path @returns {Promise<any>} the answer's JSON */
export const deleteJson = (path) => sendJson(path, 'DELETE');

/** @param {string} path @param {AbortSignal} [signal] @returns {Promise<ArrayBuffer>} the bytes of a file */
export async function getBytes(path, signal) {
  return (await ask(path, { signal })).arrayBuffer();
}

/** @param {string} path @returns {Promise<string>} the text of a file */
export async function getText(path) {
  return (await ask(path)).text();
}

/**
 * Upload a file and report its progress.
 * @param {string} kind scans, bodies, labels, patterns or motions
 * @param {File} file
 * @param {(fraction: number) => void} [progress]
 * @returns {Promise<{sha256: string, name: string, size: number}>}
 */
export function uploadFile(kind, file, progress = () => {}) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', `/v1/${kind}?name=${encodeURIComponent(file.name)}`);
    request.setRequestHeader('X-CSRF-Token', readCsrf());
    request.upload.onprogress = (event) => event.total && progress(event.loaded / event.total);
    request.onerror = () => reject(new Problem('service.unreachable', 'The upload was interrupted; try again.', 0));
    request.onload = () => {
      let told = {};
      try {
        told = JSON.parse(request.responseText);
      } catch { /* not JSON: only the status is known */ }
      if (request.status < 300) resolve(told);
      else reject(new Problem(told.code ?? 'service.fault', told.detail ?? 'The upload was refused.', request.status));
    };
    request.send(file);
  });
}

/** How long to wait before a stream that broke off is opened again [ms]. */
const AGAIN_MS = 1000;

/**
 * Follow a job by Server-Sent Events until it ends; a stream that breaks off is resumed after its last event.
 * @param {string} job
 * @param {(event: {id: number, at: number, kind: string, data: any}) => void} told
 * @param {AbortSignal} [signal] stops following
 * @returns {Promise<string>} the state in which it ended; empty where it was stopped
 */
export async function followJob(job, told, signal) {
  let after = '';
  while (!signal?.aborted) {
    try {
      const headers = { Accept: 'text/event-stream', ...(after && { 'Last-Event-ID': after }) };
      const stream = await ask(`/v1/jobs/${job}/events`, { headers, signal });
      for await (const message of readMessages(stream)) {
        if (message.event === 'end') return JSON.parse(message.data).state;
        after = message.id;
        told(JSON.parse(message.data));
      }
    } catch (error) {
      if (signal?.aborted) return '';
      if (error instanceof Problem && error.status >= 400 && error.status < 500 && error.status !== 429) throw error;
    }
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
  return '';
}

/** @param {Response} answer @returns {AsyncGenerator<Record<string, string>>} the messages of an event stream */
async function* readMessages(answer) {
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  let left = '';
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const blocks = (left + value).split('\n\n');
    left = blocks.pop();
    for (const block of blocks) {
      const fields = block.split('\n').filter((line) => !line.startsWith(':')).map((line) => line.split(/: ?(.*)/s));
      if (fields.length) yield Object.fromEntries(fields.map(([name, value]) => [name, value]));
    }
  }
}
