// What the pages need of three.js; `sh deploy/vendor-three.sh` makes service/pages/static/vendor/three-VERSION.js of it.
export {
  AmbientLight, AnimationMixer, Box3, BufferAttribute, BufferGeometry, Clock, Color, DirectionalLight, DoubleSide, FrontSide,
  Float32BufferAttribute, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, MeshNormalMaterial, MeshStandardMaterial, PerspectiveCamera, Points, PointsMaterial, Quaternion,
  Raycaster, Scene, ShaderMaterial, Sphere, SphereGeometry, SRGBColorSpace, Texture, TextureLoader, Vector2, Vector3,
  WebGLRenderer, BackSide
} from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
export { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
