// The canvas: one view beside another, all seen by one camera.
"use strict";

const ELEVATION_DEG = 32;
const AZIMUTH_DEG = -62;
const ABREAST = 3; // views in a row

class Stage {
  constructor(canvas, views) {
    this.canvas = canvas;
    this.views = views;
    this.cut = new Cut();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.localClippingEnabled = true;
    this.renderer.setScissorTest(true);
    this.camera = new THREE.PerspectiveCamera(28, 1, 1e-4, 1e3);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.box = views.reduce((box, view) => box.union(view.box()), new THREE.Box3());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    this.look(ELEVATION_DEG, AZIMUTH_DEG);
  }

  get columns() {
    return Math.min(this.views.length, ABREAST);
  }

  get rows() {
    return Math.ceil(this.views.length / this.columns);
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / this.columns / (clientHeight / this.rows);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // Look at everything from a direction [deg].
  look(elevation, azimuth) {
    const [e, a] = [elevation, azimuth].map((angle) => (angle * Math.PI) / 180);
    const middle = this.box.getCenter(new THREE.Vector3());
    const radius = 0.5 * this.box.getSize(new THREE.Vector3()).length();
    const narrow = Math.min(this.camera.aspect, 1);
    const half = (0.5 * this.camera.fov * Math.PI) / 180;
    const away = (0.74 * radius) / Math.sin(Math.atan(narrow * Math.tan(half)));
    this.camera.near = away / 50;
    this.camera.far = away * 20;
    this.camera.updateProjectionMatrix();
    const toward = new THREE.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    this.camera.position.copy(middle).addScaledVector(toward, away);
    this.controls.target.copy(middle);
    this.controls.update();
    this.draw();
  }

  // Where a view lies on the canvas, in its pixels from the upper left corner.
  area(number) {
    const width = this.canvas.clientWidth / this.columns;
    const height = this.canvas.clientHeight / this.rows;
    const row = Math.floor(number / this.columns);
    return { left: (number % this.columns) * width, top: row * height, width, height };
  }

  draw() {
    if (this._waiting) return;
    this._waiting = true;
    requestAnimationFrame(() => {
      this._waiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    const style = getComputedStyle(document.documentElement);
    const ground = new THREE.Color(style.getPropertyValue("--scene").trim());
    this.views.forEach((view, k) => {
      const { left, top, width, height } = this.area(k);
      const bottom = this.canvas.clientHeight - top - height;
      this.renderer.setViewport(left, bottom, width, height);
      this.renderer.setScissor(left, bottom, width, height);
      view.scene.background = ground;
      this._light(view);
      this.renderer.render(view.scene, this.camera);
    });
  }

  // The light comes from beside the eye.
  _light(view) {
    const offset = new THREE.Vector3(-0.4, 0.6, 0.7).applyQuaternion(this.camera.quaternion);
    view.light.target.position.copy(this.controls.target);
    view.light.position.copy(this.controls.target).add(offset);
  }

  // The part of a ply that is seen at a point of the canvas; null for none.
  hit(x, y) {
    const number = this.views.findIndex((_, k) => {
      const { left, top, width, height } = this.area(k);
      return x >= left && x < left + width && y >= top && y < top + height;
    });
    if (number < 0) return null;
    const { left, top, width, height } = this.area(number);
    const at = new THREE.Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const view = this.views[number];
    const shown = view.plies.filter((ply) => ply.group.visible);
    view.scene.updateMatrixWorld();
    const found = ray.intersectObjects(shown.map((ply) => ply.mesh), false);
    const first = found.find((each) => !this.cut.hides(each.point));
    if (!first) return null;
    const ply = shown.find((each) => each.mesh === first.object);
    return { number, view, ply, triangle: first.faceIndex, ...weightsIn(ply, first) };
  }
}

// Weights of the second and third corner of the triangle that a ray has met.
function weightsIn(ply, met) {
  const local = ply.group.worldToLocal(met.point.clone());
  const corners = [0, 1, 2].map((k) => {
    const vertex = 3 * ply.corners[3 * met.faceIndex + k];
    return new THREE.Vector3(...ply.points.subarray(vertex, vertex + 3));
  });
  const weights = THREE.Triangle.getBarycoord(local, ...corners, new THREE.Vector3());
  return { second: weights ? weights.y : 1 / 3, third: weights ? weights.z : 1 / 3 };
}
