// The sheet: its geometry and its fields at each frame.

const VERTEX_SHADER = `
attribute float value;
varying float vValue;
varying vec3 vNormal;
void main() {
  vValue = value;
  vNormal = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT_SHADER = `
uniform int mode;           // 0 sides, 1 range of values, 2 states
uniform float low, high;
uniform sampler2D map;
uniform float knots;
uniform vec3 states[3];
uniform vec3 sides[2];
varying float vValue;
varying vec3 vNormal;
void main() {
  vec3 normal = normalize(vNormal);
  if (!gl_FrontFacing) normal = -normal;
  vec3 base = gl_FrontFacing ? sides[0] : sides[1];
  if (mode == 1) {
    float place = high > low ? clamp((vValue - low) / (high - low), 0.0, 1.0) : 0.0;
    base = texture2D(map, vec2((place * (knots - 1.0) + 0.5) / knots, 0.5)).rgb;
  } else if (mode == 2) {
    base = vValue < 0.5 ? states[0] : vValue < 1.5 ? states[1] : states[2];
  }
  if (mode != 0 && isnan(vValue)) base = vec3(0.5);
  float light = 0.7 * max(dot(normal, normalize(vec3(0.35, 0.55, 0.9))), 0.0) + 0.3 * max(normal.z, 0.0);
  float dark = mode == 0 ? 0.5 : 0.66; // colours that are to be read off change less with the light
  gl_FragColor = vec4(base * (dark + (1.06 - dark) * light), 1.0);
}`;

class Sheet {
  constructor(arrays) {
    const of = (name) => arrays[name].values;
    const { origin, step, fields } = run.sheet;
    Object.assign(this, { origin, step, fields, times: of("times"), positions: of("positions"), flat: of("flat") });
    this.vertices = of("vertices");
    this.triangles = of("triangles");
    this.count = this.flat.length / 2; // points; vertices are points, those on creases twice or more
    this.values = new Map(fields.map(({ name }) => [name, of(`field ${name}`)]));
    this.half = Float32Array.from({ length: 65536 }, (_, bits) => THREE.DataUtils.fromHalfFloat(bits));
    this.points = new Float32Array(3 * this.count);
    this.reference = run.kind === "modal" ? this.times.length - 1 : 0; // displacements are from this frame
    this.field = null;
    this.frame = -1;
    this.shape = "deformed";
    this.mesh = this.makeMesh();
    this.creases = this.makeLines(of("creases"));
    this.rim = this.makeLines(of("rim"));
  }

  makeMesh() {
    const geometry = new THREE.BufferGeometry();
    const count = this.vertices.length;
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(count), 1));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(this.triangles), 1));
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX_SHADER,
      fragmentShader: FRAGMENT_SHADER,
      side: THREE.DoubleSide,
      polygonOffset: true, // lines on the sheet lie before it
      polygonOffsetFactor: 0.6,
      polygonOffsetUnits: 1,
      uniforms: {
        mode: { value: 0 },
        low: { value: 0 },
        high: { value: 1 },
        map: { value: viridisTexture() },
        knots: { value: VIRIDIS.length },
        states: { value: STATES.map(([, hex]) => vectorOf(hex)) },
        sides: { value: SIDES.map(([, hex]) => vectorOf(hex)) },
      },
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    return mesh;
  }

  makeLines(ends) {
    const geometry = new THREE.LineSegmentsGeometry();
    geometry.setPositions(new Float32Array(3 * Math.max(ends.length, 2)));
    const lines = new THREE.LineSegments2(geometry, new THREE.LineMaterial({ linewidth: 1.4, transparent: true }));
    lines.frustumCulled = false;
    lines.visible = ends.length > 0;
    lines.userData = { ends };
    return lines;
  }

  // Moves points to a frame; `out` (3 per point) in metres.
  pointsAt(frame, out) {
    const { origin, step, positions, count } = this;
    if (this.shape === "flat") {
      for (let i = 0; i < count; i++) {
        out[3 * i] = this.flat[2 * i];
        out[3 * i + 1] = this.flat[2 * i + 1];
        out[3 * i + 2] = 0;
      }
      return out;
    }
    const start = 3 * count * frame;
    for (let i = 0; i < 3 * count; i += 3) {
      out[i] = origin[0] + step * positions[start + i];
      out[i + 1] = origin[1] + step * positions[start + i + 1];
      out[i + 2] = origin[2] + step * positions[start + i + 2];
    }
    return out;
  }

  // The middle of the points of the frame shown.
  centre() {
    const sum = [0, 0, 0];
    for (let i = 0; i < this.points.length; i++) sum[i % 3] += this.points[i];
    return new THREE.Vector3(...sum).divideScalar(this.count);
  }

  // Value of a field at each point of a frame; null for the plain sheet.
  fieldAt(field, frame) {
    if (field === null) return null;
    const out = new Float32Array(this.count);
    if (field.name === "displacement") {
      const { positions, count } = this;
      const here = 3 * count * frame;
      const there = 3 * count * this.reference;
      for (let i = 0; i < count; i++) {
        const [x, y, z] = [0, 1, 2].map((c) => positions[here + 3 * i + c] - positions[there + 3 * i + c]);
        out[i] = this.step * Math.hypot(x, y, z);
      }
      return out;
    }
    const bits = this.values.get(field.name);
    const start = this.count * frame;
    for (let i = 0; i < this.count; i++) out[i] = field.scale * this.half[bits[start + i]];
    return out;
  }

  // Displacement from the first frame (modal: from the equilibrium), a field that needs no file.
  displacementField() {
    let largest = 0;
    const field = { name: "displacement", label: "displacement", unit: "m" };
    if (run.kind === "modal") field.label = "displacement, scaled";
    for (let k = 0; k < this.times.length; k++) largest = this.fieldAt(field, k).reduce((a, b) => Math.max(a, b), largest);
    return { ...field, low: 0, high: largest, least: 0, largest };
  }

  show(frame, field) {
    const moved = frame !== this.frame || this.shape !== this.shown;
    if (moved) {
      this.pointsAt(frame, this.points);
      this.updateMesh();
      this.updateLines(this.creases);
      this.updateLines(this.rim);
    }
    if (moved || field !== this.field) this.updateValues(field, frame);
    Object.assign(this, { frame, field, shown: this.shape });
  }

  updateMesh() {
    const { position, normal } = this.mesh.geometry.attributes;
    const [x, n, t] = [position.array, normal.array, this.triangles];
    for (let v = 0; v < this.vertices.length; v++) {
      const from = 3 * this.vertices[v];
      x[3 * v] = this.points[from];
      x[3 * v + 1] = this.points[from + 1];
      x[3 * v + 2] = this.points[from + 2];
    }
    n.fill(0);
    for (let k = 0; k < t.length; k += 3) {
      const [a, b, c] = [3 * t[k], 3 * t[k + 1], 3 * t[k + 2]];
      const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
      const wx = x[c] - x[a], wy = x[c + 1] - x[a + 1], wz = x[c + 2] - x[a + 2];
      const nx = uy * wz - uz * wy, ny = uz * wx - ux * wz, nz = ux * wy - uy * wx;
      for (const i of [a, b, c]) {
        n[i] += nx;
        n[i + 1] += ny;
        n[i + 2] += nz;
      }
    }
    for (let i = 0; i < n.length; i += 3) {
      const length = Math.hypot(n[i], n[i + 1], n[i + 2]) || 1;
      n[i] /= length;
      n[i + 1] /= length;
      n[i + 2] /= length;
    }
    position.needsUpdate = normal.needsUpdate = true;
    this.mesh.geometry.boundingSphere = this.mesh.geometry.boundingBox = null; // of the last frame
  }

  updateLines(lines) {
    const buffer = lines.geometry.attributes.instanceStart.data;
    const { ends } = lines.userData;
    for (let k = 0; k < ends.length; k++) {
      for (let c = 0; c < 3; c++) buffer.array[3 * k + c] = this.points[3 * ends[k] + c];
    }
    buffer.needsUpdate = true;
  }

  updateValues(field, frame) {
    const { value } = this.mesh.geometry.attributes;
    this.pointValues = this.fieldAt(field, frame);
    if (this.pointValues) for (let v = 0; v < this.vertices.length; v++) value.array[v] = this.pointValues[this.vertices[v]];
    value.needsUpdate = true;
  }

  // Least and largest value of what is shown.
  extremes() {
    let [least, largest] = [Infinity, -Infinity];
    for (const value of this.pointValues ?? []) {
      if (value < least) least = value;
      if (value > largest) largest = value;
    }
    return least <= largest ? [least, largest] : [0, 0];
  }

  colourBy(field, [low, high]) {
    const { uniforms } = this.mesh.material;
    uniforms.mode.value = field === null ? 0 : field.name === "state" ? 2 : 1;
    uniforms.low.value = low;
    uniforms.high.value = high;
  }
}
