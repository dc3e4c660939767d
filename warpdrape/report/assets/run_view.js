// A run in the 3-D view: its plies and tools at a frame.
"use strict";

const TOOL_COLOUR = 0x8a9099;
const TOOL_OPACITY = 0.22;

class RunView {
  // `packed`: of one run; `texture`: of the colours.
  static async make(packed, blocks, texture) {
    const view = new RunView();
    view.packed = packed;
    view.scene = new THREE.Scene();
    view.plies = [];
    for (const ply of packed.plies) {
      view.plies.push(await PlyView.make(ply, packed, blocks, texture));
    }
    view.tools = [];
    for (const tool of packed.tools) view.tools.push(await toolView(tool, blocks));
    for (const each of [...view.plies, ...view.tools]) view.scene.add(each.group);
    view.scene.add(new THREE.AmbientLight(0xffffff, 1.9));
    view.light = new THREE.DirectionalLight(0xffffff, 1.6);
    view.scene.add(view.light, view.light.target);
    return view;
  }

  // Show the frame at a share of the run's time, from 0 to 1.
  async setShare(share) {
    const times = this.packed.times;
    const wanted = times[0] + share * (times[times.length - 1] - times[0]);
    let frame = 0;
    times.forEach((time, k) => {
      if (Math.abs(time - wanted) < Math.abs(times[frame] - wanted)) frame = k;
    });
    this.frame = frame;
    for (const ply of this.plies) await ply.setFrame(frame);
    for (const tool of this.tools) {
      tool.group.matrix.fromArray(tool.packed.places[frame]);
      tool.group.matrixWorldNeedsUpdate = true;
    }
  }

  // Lift plies off each other by so much [m], to look between them.
  spread(gap) {
    this.plies.forEach((ply, k) => ply.group.position.set(0, 0, gap * k));
  }

  // What is under the slider: time, and the ways of tools that move.
  words() {
    const parts = [`${said(this.packed.times[this.frame] * 1e3, "ms")}`];
    for (const [tool, ways] of Object.entries(this.packed.travel)) {
      parts.push(`${tool} ${said(ways[this.frame], "mm")}`);
    }
    return parts.join(" · ");
  }

  // Box round all plies and tools [m], over all frames for the plies.
  box() {
    const box = new THREE.Box3();
    box.expandByPoint(new THREE.Vector3(...this.packed.low));
    box.expandByPoint(new THREE.Vector3(...this.packed.high));
    return box;
  }
}

async function toolView(packed, blocks) {
  const corners = await blocks.wholeNumbers(packed.corners);
  const steps = await blocks.steps(packed.points, 1);
  const points = dequantised(steps, packed.low, packed.high);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  geometry.setIndex(new THREE.BufferAttribute(corners, 1));
  const material = new THREE.MeshLambertMaterial({
    color: TOOL_COLOUR,
    transparent: true,
    opacity: TOOL_OPACITY,
    side: THREE.DoubleSide,
    depthWrite: false,
    flatShading: true,
  });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.renderOrder = 1; // after what is not translucent
  const group = new THREE.Group();
  group.matrixAutoUpdate = false; // places are given whole
  group.add(mesh);
  return { packed, name: packed.name, corners, points, mesh, group };
}
