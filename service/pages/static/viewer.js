// Meshes in 3D, drawn when something changed and not otherwise. Metres, y up.
import {
  Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, HemisphereLight, Line, LineBasicMaterial, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, MeshNormalMaterial, OrbitControls, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, SphereGeometry, SRGBColorSpace, Vector2, Vector3,
  WebGLRenderer,
} from './vendor/three-0.187.0.js';

/** Radius of the mark that stands where the pointer is in the other view [m]: seen on a whole person, smaller than a button. */
const MARK = 0.008;

/** Size of a cloud's points [m]. */
const POINT = 0.007;

/** Free space around what is framed, as a share of its distance, and the time of a turn of the turntable [ms]: slow enough to look at a seam. */
const MARGIN = 0.04;
const TURN_MS = 12_000;

/** Colours of a value from 0 to 1, light to dark: those of the report's error map. */
const STOPS = [[0, [0.9, 0.92, 0.9]], [0.25, [0.98, 0.86, 0.55]], [0.5, [0.95, 0.6, 0.26]], [0.75, [0.8, 0.25, 0.2]], [1, [0.42, 0.05, 0.24]]];

/** @param {number} share @returns {number[]} red, green, blue in 0..1, sRGB */
export function colourOf(share) {
  const at = Math.min(Math.max(share, 0), 1);
  const next = Math.max(1, STOPS.findIndex(([stop]) => at <= stop));
  const [[low, from], [high, to]] = [STOPS[next - 1], STOPS[next]];
  return from.map((value, n) => value + ((to[n] - value) * (at - low)) / (high - low));
}

/** Names of what draws by software. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/**
 * Open a canvas for WebGL. Where that is done by software edges are not smoothed, which would take a quarter of a page's whole time.
 * @returns {{canvas: HTMLCanvasElement, context: WebGL2RenderingContext, isFast: boolean}} @throws {Error} where there is none
 */
function openContext() {
  const open = (antialias) => {
    const canvas = document.createElement('canvas');
    return { canvas, context: canvas.getContext('webgl2', { alpha: true, antialias, powerPreference: 'low-power' }) };
  };
  const plain = open(false);
  if (!plain.context) throw new Error('the browser has no WebGL');
  const told = plain.context.getExtension('WEBGL_debug_renderer_info')?.UNMASKED_RENDERER_WEBGL ?? plain.context.RENDERER;
  if (SOFTWARE.test(plain.context.getParameter(told))) return { ...plain, isFast: false };
  plain.context.getExtension('WEBGL_lose_context')?.loseContext();
  return { ...open(true), isFast: true };
}

/** A view of some meshes: orbit by mouse, touch or the arrow keys. */
export class Viewer {
  /** @param {HTMLElement} place @throws {Error} where the browser has no WebGL */
  constructor(place) {
    this.place = place;
    const { isFast, ...opened } = openContext();
    this.renderer = new WebGLRenderer({ ...opened, alpha: true });
    this.renderer.setPixelRatio(isFast ? Math.min(window.devicePixelRatio, 2) : 1);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1, 0.01, 50);
    this.scene.add(new HemisphereLight(0xffffff, 0x8a8f99, 1.9));
    const lamp = new DirectionalLight(0xffffff, 1.6);
    lamp.position.set(0.6, 0.8, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera);
    place.append(this.renderer.domElement);
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-label', '3D view: drag to turn, wheel to zoom, arrow keys to turn, plus and minus to zoom');
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.draw());
    this.controls.addEventListener('start', () => { this.isFramed = false; });
    canvas.addEventListener('keydown', (event) => this.turnByKey(event));
    this.meshes = new Map();
    this.mark = new Mesh(new SphereGeometry(MARK, 16, 12), new MeshBasicMaterial({ color: 0xd9480f, depthTest: false }));
    this.mark.renderOrder = 5;
    this.mark.visible = false;
    this.lines = [];
    this.scene.add(this.mark);
    this.style = 'cloth';
    this.isFramed = false;
    this.isSpinning = false;
    this.wireframe = false;
    new ResizeObserver(() => this.resize()).observe(place);
    this.resize();
  }

  /** Fit the picture to its place. */
  resize() {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.isFramed) this.frame(this.azimuth);
    this.draw();
  }

  /** Draw once, before the browser's next picture. */
  draw() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.renderer.render(this.scene, this.camera);
      this.place.dispatchEvent(new CustomEvent('drawn'));
    });
  }

  /**
   * Show a mesh, or a cloud where it has no faces.
   * @param {string} name @param {Float32Array} positions @param {ArrayLike<number>} faces
   * @param {{colour?: number, isVisible?: boolean, isCloth?: boolean, colours?: Uint8Array|null}} [look] `colours` are RGB of each vertex
   */
  add(name, positions, faces, { colour = 0x6694bd, isVisible = true, isCloth = false, colours = null } = {}) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    if (colours) geometry.setAttribute('color', new BufferAttribute(linearOf(colours), 3));
    const look = { color: new Color(colours ? 0xffffff : colour), vertexColors: Boolean(colours) };
    let mesh;
    if (faces.length) {
      geometry.setIndex(new BufferAttribute(faces.BYTES_PER_ELEMENT > 1 ? faces : Uint16Array.from(faces), 1));
      geometry.computeVertexNormals();
      mesh = new Mesh(geometry, new MeshLambertMaterial({ ...look, side: DoubleSide, wireframe: this.wireframe }));
    } else mesh = new Points(geometry, new PointsMaterial({ ...look, size: POINT }));
    mesh.visible = isVisible;
    mesh.userData = { colour, isCloth };
    this.meshes.set(name, mesh);
    this.scene.add(mesh);
    if (isVisible) this.draw();
  }

  /** @param {string} name @param {Float32Array} positions another state of a mesh, such as a frame of an animation */
  move(name, positions) {
    const { geometry } = this.meshes.get(name);
    geometry.attributes.position.array.set(positions);
    geometry.attributes.position.needsUpdate = true;
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
    geometry.boundingBox = null;
    this.draw();
  }

  /** @param {string} name @param {boolean} isVisible */
  show(name, isVisible) {
    this.meshes.get(name).visible = isVisible;
    this.draw();
  }

  /** @param {boolean} isOn */
  setWireframe(isOn) {
    this.wireframe = isOn;
    for (const { material } of this.meshes.values()) if ('wireframe' in material) material.wireframe = isOn;
    this.draw();
  }

  /**
   * Colour the garment's meshes: `cloth`, `normals`, or by a colour of each vertex.
   * @param {string} style @param {(name: string) => Float32Array|null} colours linear RGB of a mesh's vertices; null: as cloth
   */
  colour(style, colours) {
    for (const [name, mesh] of this.meshes) {
      if (!mesh.userData.isCloth) continue;
      mesh.material.dispose();
      const shown = style === 'cloth' || style === 'normals' ? null : colours(name);
      if (style === 'normals') mesh.material = new MeshNormalMaterial({ side: DoubleSide });
      else mesh.material = new MeshLambertMaterial({ color: new Color(shown ? 0xffffff : mesh.userData.colour), side: DoubleSide, vertexColors: Boolean(shown) });
      mesh.material.wireframe = this.wireframe;
      if (shown) mesh.geometry.setAttribute('color', new BufferAttribute(shown, 3));
    }
    this.draw();
  }

  /** @returns {number} the angle from which the camera looks, around the upright axis; 0: the front [rad] */
  get azimuth() {
    const offset = this.camera.position.clone().sub(this.controls.target);
    return Math.atan2(offset.x, offset.z);
  }

  /**
   * Look at all that is shown, level, from so far that the whole stays in view as it turns; until it is moved it stays whole in every size.
   * @param {number} [angle] around the upright axis; 0: the front, a quarter to its left [rad]
   * @param {number} [least] distance of the camera [m]
   * @returns {number} the distance [m]
   */
  frame(angle = 0, least = 0) {
    const shown = [...this.meshes.values()].filter((mesh) => mesh.visible), box = new Box3(), { target } = this.controls;
    for (const mesh of shown) box.expandByObject(mesh);
    if (box.isEmpty()) return 0;
    box.getCenter(target);
    const up = Math.tan((Math.PI * this.camera.fov) / 360), across = Math.sin(Math.atan(up * this.camera.aspect));
    let far = least / (1 + MARGIN);
    for (const { array } of shown.map((mesh) => mesh.geometry.attributes.position)) {
      for (let n = 0; n < array.length; n += 3) {
        const radius = Math.hypot(array[n] - target.x, array[n + 2] - target.z);
        far = Math.max(far, Math.abs(array[n + 1] - target.y) / up + radius, radius / across);
      }
    }
    this.camera.position.copy(target).add(new Vector3(Math.sin(angle), 0, Math.cos(angle)).multiplyScalar((1 + MARGIN) * far));
    this.controls.update();
    this.isFramed = true;
    this.draw();
    return (1 + MARGIN) * far;
  }

  /** @param {Viewer} other a view, as which this one looks from now on */
  follow(other) {
    this.isFramed = other.isFramed;
    this.camera.position.copy(this.controls.target).add(other.camera.position).sub(other.controls.target);
    this.controls.update();
    this.draw();
  }

  /** @param {boolean} isOn turn what is shown before the camera, until it is told to stop */
  spin(isOn) {
    this.isSpinning = isOn;
    let before = performance.now();
    const step = (now) => {
      if (!this.isSpinning) return;
      this.turn((-2 * Math.PI * (now - before)) / TURN_MS);
      before = now;
      requestAnimationFrame(step);
    };
    if (isOn) requestAnimationFrame(step);
  }

  /** @param {number} angle to turn the camera around the upright axis by [rad] */
  turn(angle) {
    const offset = this.camera.position.clone().sub(this.controls.target).applyAxisAngle(new Vector3(0, 1, 0), angle);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  /** @param {KeyboardEvent} event turn by the arrow keys, zoom by plus and minus */
  turnByKey(event) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const step = Math.PI / 24;
    if (event.key === 'ArrowLeft' || event.key === 'ArrowRight') offset.applyAxisAngle(new Vector3(0, 1, 0), event.key === 'ArrowLeft' ? -step : step);
    else if (event.key === 'ArrowUp' || event.key === 'ArrowDown') {
      const side = new Vector3(0, 1, 0).cross(offset).normalize();
      const turned = offset.clone().applyAxisAngle(side, event.key === 'ArrowUp' ? -step : step);
      if (Math.abs(turned.y) < 0.99 * turned.length()) offset.copy(turned);
    } else if (event.key === '+' || event.key === '=') offset.multiplyScalar(0.9);
    else if (event.key === '-') offset.multiplyScalar(1 / 0.9);
    else return;
    event.preventDefault();
    this.isFramed = false;
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  /**
   * Find what the pointer is over.
   * @param {string} name of a mesh @param {PointerEvent} event
   * @returns {{face: number, weights: number[], point: number[]}|null}
   */
  pick(name, event) {
    const mesh = this.meshes.get(name);
    if (!mesh?.visible) return null;
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.camera);
    const [hit] = ray.intersectObject(mesh);
    if (!hit) return null;
    const corners = [hit.face.a, hit.face.b, hit.face.c].map((n) => new Vector3().fromBufferAttribute(mesh.geometry.attributes.position, n));
    return { face: hit.faceIndex, weights: weigh(hit.point, corners), point: hit.point.toArray() };
  }

  /** Look at the middle from a side, level. @param {number} angle from the front about the vertical [rad] */
  face(angle) {
    const far = this.camera.position.distanceTo(this.controls.target);
    this.camera.position.copy(this.controls.target).add(new Vector3(far * Math.sin(angle), 0, far * Math.cos(angle)));
    this.controls.update();
    this.draw();
  }

  /** @param {number[]|null} point where the mark stands [m]; null: nowhere */
  setMark(point) {
    this.mark.visible = point !== null;
    if (point) this.mark.position.fromArray(point);
    this.draw();
  }

  /** @param {number[]} point [m] @returns {number[]} where it is on the screen [px] */
  project(point) {
    const box = this.renderer.domElement.getBoundingClientRect(), at = new Vector3(...point).project(this.camera);
    return [box.left + ((at.x + 1) / 2) * box.width, box.top + ((1 - at.y) / 2) * box.height];
  }

  /** @param {{points: Float32Array, colour: number}[]} curves lines on the garment, in front of all */
  setLines(curves) {
    for (const line of this.lines) {
      this.scene.remove(line);
      line.geometry.dispose();
    }
    this.lines = curves.map(({ points, colour }) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(points, 3));
      const line = new Line(geometry, new LineBasicMaterial({ color: colour, depthTest: false }));
      line.renderOrder = 4;
      this.scene.add(line);
      return line;
    });
    this.draw();
  }
}

/** @param {Float32Array} values @param {number} end @returns {Float32Array} linear red, green, blue of each vertex */
export function paint(values, end) {
  const colours = new Float32Array(3 * values.length), colour = new Color();
  const table = Array.from({ length: 257 }, (_, n) => colour.setRGB(...colourOf(n / 256), SRGBColorSpace).toArray());
  values.forEach((value, n) => colours.set(table[Math.round(256 * Math.min(Math.max(value / end, 0), 1))], 3 * n));
  return colours;
}

/** @param {Uint8Array} colours RGB bytes, sRGB @returns {Float32Array} the same, linear in 0..1 */
export function linearOf(colours) {
  const colour = new Color(), table = Float32Array.from({ length: 256 }, (_, n) => colour.setRGB(n / 255, 0, 0, SRGBColorSpace).r);
  return Float32Array.from(colours, (value) => table[value]);
}

/** @param {Vector3} point @param {Vector3[]} corners @returns {number[]} barycentric weights */
function weigh(point, [a, b, c]) {
  const u = b.clone().sub(a), v = c.clone().sub(a), w = point.clone().sub(a);
  const uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = w.dot(u), wv = w.dot(v), whole = uu * vv - uv * uv;
  const beta = (vv * wu - uv * wv) / whole, gamma = (uu * wv - uv * wu) / whole;
  return [1 - beta - gamma, beta, gamma];
}
