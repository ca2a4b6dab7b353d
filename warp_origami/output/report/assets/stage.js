// The view in 3D: camera, lines, reading of values under the pointer, axes and scale.

const HOME = [0.8, -1.6, 1.2]; // from the sheet to the camera, as in animation.usdc
const FIELD_OF_VIEW = 35;
const FITTED_POINTS = 30000;

class Stage {
  constructor(sheet) {
    this.sheet = sheet;
    this.box = document.getElementById("viewer");
    this.canvas = document.getElementById("canvas");
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.scene.add(sheet.mesh, sheet.creases, sheet.rim);
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.draw());
    this.measureMotion();
    this.markers = [];
    this.afterDraw = [];
    new ResizeObserver(() => this.resize()).observe(this.box);
    this.resize();
  }

  // Ball around the whole motion, for the depth of the view.
  measureMotion() {
    const [low, high] = [new THREE.Vector3(Infinity, Infinity, Infinity), new THREE.Vector3(-Infinity, -Infinity, -Infinity)];
    for (const point of this.motion()) {
      low.min(point);
      high.max(point);
    }
    this.middle = low.clone().add(high).multiplyScalar(0.5);
    this.radius = Math.max(high.distanceTo(low) / 2, 1e-9);
  }

  // Points of all frames, or of one; of large runs a part of them.
  *motion(only = null) {
    const { sheet } = this;
    const frames = only === null && sheet.shape === "deformed" ? sheet.times.length : 1;
    const stride = Math.max(1, Math.ceil((frames * sheet.count) / FITTED_POINTS));
    const points = new Float32Array(3 * sheet.count);
    const point = new THREE.Vector3();
    for (let k = 0; k < frames; k++) {
      sheet.pointsAt(only ?? k, points);
      for (let i = k % stride; i < sheet.count; i += stride) yield point.fromArray(points, 3 * i);
    }
  }

  // Puts the camera where it sees the points, as near as possible, looking along -direction (as camera.py).
  fit(points, direction = null) {
    const back = direction ? new THREE.Vector3(...direction) : this.camera.position.clone().sub(this.controls.target);
    back.normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(back).normalize();
    const up = back.clone().cross(right);
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360) / 1.12; // with a margin
    const { right: atRight, bottom } = this.reserved();
    const height = this.box.clientHeight;
    const [tx, ty] = [half * (this.camera.aspect - atRight / height), half * (1 - bottom / height)];
    const reach = { right: -Infinity, left: -Infinity, up: -Infinity, down: -Infinity };
    let [near, far] = [-Infinity, Infinity];
    for (const point of points) {
      const [x, y, z] = [point.dot(right), point.dot(up), point.dot(back)];
      reach.right = Math.max(reach.right, x / tx + z);
      reach.left = Math.max(reach.left, -x / tx + z);
      reach.up = Math.max(reach.up, y / ty + z);
      reach.down = Math.max(reach.down, -y / ty + z);
      near = Math.max(near, z);
      far = Math.min(far, z);
    }
    const distance = Math.max((reach.right + reach.left) / 2, (reach.up + reach.down) / 2, near + 0.02 * this.radius);
    const across = right.multiplyScalar((tx * (reach.right - reach.left)) / 2).addScaledVector(up, (ty * (reach.up - reach.down)) / 2);
    this.controls.target.copy(across).addScaledVector(back, (near + far) / 2);
    this.camera.position.copy(across).addScaledVector(back, distance);
    this.controls.update();
    this.draw();
  }

  // Margins that the colour bar has to itself, px: at the right, on phones at the bottom.
  reserved() {
    return matchMedia("(max-width: 640px)").matches ? { right: 0, bottom: 66 } : { right: 175, bottom: 0 };
  }

  // Moves camera and target with the sheet.
  shift(by) {
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.controls.update();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    const { right, bottom } = this.reserved();
    this.camera.setViewOffset(width, height, right / 2, bottom / 2, width, height);
    this.draw();
  }

  // Draws before the next repaint, once.
  draw() {
    this.waiting ??= requestAnimationFrame(() => this.drawNow());
  }

  drawNow() {
    this.waiting = null;
    const distance = this.camera.position.distanceTo(this.middle);
    this.camera.near = Math.max(distance - 1.2 * this.radius, 2e-3 * this.radius);
    this.camera.far = distance + 1.2 * this.radius;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    this.drawTriad();
    this.drawScale();
    for (const marker of this.markers) this.place(marker);
    for (const callback of this.afterDraw) callback();
  }

  drawTriad() {
    const lines = ["x", "y", "z"].map((name, k) => {
      const axis = new THREE.Vector3().setComponent(k, 1).transformDirection(this.camera.matrixWorldInverse);
      const [x, y] = [22 * axis.x, -22 * axis.y];
      const text = `<text x="${1.32 * x}" y="${1.32 * y}">${name}</text>`;
      return [axis.z, `<line class="${name}" x2="${x}" y2="${y}"/>${text}`];
    });
    lines.sort((a, b) => a[0] - b[0]);
    document.getElementById("triad").innerHTML = lines.map(([, line]) => line).join("");
  }

  drawScale() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const perMetre = this.box.clientHeight / (2 * distance * Math.tan((FIELD_OF_VIEW * Math.PI) / 360));
    const length = niceBelow(110 / perMetre);
    const bar = document.getElementById("scale");
    bar.firstElementChild.textContent = quantity(length, "m");
    bar.lastElementChild.style.width = `${length * perMetre}px`;
  }

  // A named point over the picture; `position` is looked at whenever it is drawn.
  addMarker(name, position) {
    const label = document.createElement("div");
    label.className = "marker";
    label.append(document.createElement("i"), name);
    document.getElementById("labels").append(label);
    this.markers.push({ label, position });
  }

  place({ label, position }) {
    const point = position();
    label.hidden = point === null;
    if (point === null) return;
    const seen = point.project(this.camera);
    label.hidden = Math.abs(seen.x) > 1 || Math.abs(seen.y) > 1 || seen.z > 1;
    const [x, y] = [((1 + seen.x) / 2) * this.box.clientWidth, ((1 - seen.y) / 2) * this.box.clientHeight];
    label.style.transform = `translate(${x}px, ${y}px)`;
  }

  // Flat coordinates (m) and value at the place of a pointer event; null beside the sheet.
  read(event) {
    if (!this.sheet.mesh.visible) return null;
    const box = this.canvas.getBoundingClientRect();
    const place = new THREE.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(place, this.camera);
    const [hit] = ray.intersectObject(this.sheet.mesh);
    if (!hit) return null;
    const corners = [hit.face.a, hit.face.b, hit.face.c].map((vertex) => this.sheet.vertices[vertex]);
    const weights = hit.barycoord.toArray();
    const mean = (at) => corners.reduce((sum, point, k) => sum + weights[k] * at(point), 0);
    const { flat, pointValues } = this.sheet;
    return {
      flat: [mean((point) => flat[2 * point]), mean((point) => flat[2 * point + 1])],
      value: pointValues ? mean((point) => pointValues[point]) : null,
    };
  }

  savePicture(name) {
    this.drawNow();
    this.canvas.toBlob((blob) => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }
}
