// Colours of fields and curves.

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// viridis (S. van der Walt, N. Smith, CC0) at 17 equidistant places, as in animation.usdc
const VIRIDIS = [
  "440154", "48186a", "472d7b", "424086", "3b528b", "33638d", "2c728e", "26828e", "21918c", "1fa088", "28ae80",
  "3fbc73", "5ec962", "84d44b", "addc30", "d8e219", "fde725",
];
const STATES = [["slack", "#aab4c0"], ["wrinkled", "#e69f00"], ["taut", "#2f7fc1"]]; // values 0, 1, 2
const SIDES = [["upper side", "#d9a441"], ["lower side", "#c3ccd6"]]; // polyimide and its aluminium

const bytesOf = (hex) => [0, 2, 4].map((k) => parseInt(hex.replace("#", "").slice(k, k + 2), 16));

function viridisTexture() {
  const data = new Uint8Array(VIRIDIS.length * 4);
  VIRIDIS.forEach((hex, k) => data.set([...bytesOf(hex), 255], 4 * k));
  const texture = new THREE.DataTexture(data, VIRIDIS.length, 1, THREE.RGBAFormat);
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

const vectorOf = (hex) => new THREE.Vector3(...bytesOf(hex).map((byte) => byte / 255));
