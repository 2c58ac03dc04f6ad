// Meshes and the flat pattern of a result, as the service packs them for a view: arrays are read where they lie.

/**
 * @typedef {{positions: Float32Array, faces: Uint8Array|Uint16Array|Uint32Array, values: Record<string, Float32Array>,
 *   colours: Uint8Array|null}} ShownMesh positions [m], triangles, further numbers of each vertex, RGB bytes
 */

const KINDS = { f4: Float32Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };

/**
 * Read a container.
 * @param {ArrayBuffer} content
 * @returns {{meshes: Map<string, ShownMesh>, garment: import('./garment.js').Garment|null}}
 */
export function readShown(content) {
  const start = 8 + new DataView(content).getUint32(4, true);
  const text = new TextDecoder();
  if (text.decode(new Uint8Array(content, 0, 4)) !== 'GQV1') throw new Error('the packed meshes cannot be read');
  const head = JSON.parse(text.decode(new Uint8Array(content, 8, start - 8)));
  const take = ([kind, place, count]) => new KINDS[kind](content, start + place, count);
  const meshes = new Map(Object.entries(head.meshes).map(([name, mesh]) => [name, {
    positions: take(mesh.positions), faces: take(mesh.faces), colours: mesh.colours && take(mesh.colours),
    values: Object.fromEntries(Object.entries(mesh.values).map(([value, place]) => [value, take(place)])),
  }]));
  return { meshes, garment: head.flat && readFlat(head.flat, take) };
}

/** @returns {import('./garment.js').Garment} the flat pattern */
function readFlat(flat, take) {
  const panels = flat.panels.map((name) => ({ name, edges: [] }));
  for (const [at, index, label, contour, uv] of flat.edges) panels[at].edges[index] = { panel: panels[at].name, index, label, contour, uv: take(uv) };
  const seams = flat.seams.map((pair) => pair.map(([at, index]) => panels[at].edges[index]));
  return { uv: take(flat.uv), uvFaces: take(flat.uv_faces), uvNode: take(flat.uv_node), panelOfUv: take(flat.panel_of_uv), panels, seams };
}
