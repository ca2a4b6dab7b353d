// What the page uses of three.js; see README.md.
export {
  BufferAttribute, BufferGeometry, DataTexture, DataUtils, DoubleSide, LinearFilter, Mesh,
  PerspectiveCamera, Raycaster, RGBAFormat, Scene, ShaderMaterial, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { LineSegments2 } from "three/addons/lines/LineSegments2.js";
export { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
export { LineMaterial } from "three/addons/lines/LineMaterial.js";
