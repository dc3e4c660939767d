// A plane that cuts plies and tools, and the lines in which it does.
"use strict";

const CUT_COLOURS = [0xd62728, 0x1f77b4, 0x2ca02c, 0x9467bd, 0xff7f0e, 0x17becf, 0xe377c2, 0x8c564b];
const TOOL_CUT_COLOUR = 0x6b7280;
const CUT_WIDTH = 2.2; // pixels

class Cut {
  constructor() {
    this.plane = new THREE.Plane(new THREE.Vector3(1, 0, 0), 0);
    this.axis = null; // 0, 1, 2, or null for none
    this.lines = [];
  }

  // Cut across an axis at a place [m]; what lies on the side of `sign` stays.
  set(axis, place, sign) {
    this.axis = axis;
    if (axis === null) return;
    const normal = [0, 0, 0];
    normal[axis] = sign;
    this.plane.normal.set(...normal);
    this.plane.constant = -sign * place;
  }

  hides(point) {
    return this.axis !== null && this.plane.distanceToPoint(point) < 0;
  }

  // Give every material the plane, and draw the section of everything that is shown.
  apply(views) {
    for (const line of this.lines) {
      line.removeFromParent();
      line.geometry.dispose();
      line.material.dispose();
    }
    this.lines = [];
    const planes = this.axis === null ? [] : [this.plane];
    for (const view of views) {
      for (const ply of view.plies) {
        for (const each of [ply.mesh, ...ply.yarns.map((yarn) => yarn.line)]) {
          this._clip(each.material, planes);
        }
      }
      for (const tool of view.tools) this._clip(tool.mesh.material, planes);
      if (this.axis !== null) this._section(view);
    }
  }

  _clip(material, planes) {
    if (material.clippingPlanes?.length !== planes.length) material.needsUpdate = true;
    material.clippingPlanes = planes;
  }

  _section(view) {
    const place = -this.plane.constant / this.plane.normal.getComponent(this.axis);
    view.plies.forEach((ply, k) => {
      this._add(ply, ply.points, place, CUT_COLOURS[k % CUT_COLOURS.length]);
    });
    for (const tool of view.tools) this._add(tool, tool.points, place, TOOL_CUT_COLOUR);
  }

  _add(body, points, place, colour) {
    if (body.group.matrixAutoUpdate) body.group.updateMatrix();
    const ends = section(points, body.corners, body.group.matrix.elements, this.axis, place);
    if (!ends.length) return;
    const line = wideLines(colour, CUT_WIDTH);
    setLines(line, ends);
    body.group.add(line);
    this.lines.push(line);
  }
}

// Ends of the pieces in which a plane cuts triangles, in their own frame, six numbers a piece.
// `frame`: the matrix that places them, column by column.
function section(points, corners, frame, axis, place) {
  const [x, y, z, beyond] = [0, 4, 8, 12].map((column) => frame[column + axis]);
  const ends = [];
  for (let t = 0; t < corners.length; t += 3) {
    const vertices = [3 * corners[t], 3 * corners[t + 1], 3 * corners[t + 2]];
    const heights = vertices.map(
      (v) => x * points[v] + y * points[v + 1] + z * points[v + 2] + beyond - place,
    );
    const below = heights.map((h) => h < 0);
    if (below[0] === below[1] && below[1] === below[2]) continue;
    for (let k = 0; k < 3; k++) {
      const [a, b] = [k, (k + 1) % 3];
      if (below[a] === below[b]) continue;
      const share = heights[a] / (heights[a] - heights[b]);
      for (let i = 0; i < 3; i++) {
        const [from, to] = [points[vertices[a] + i], points[vertices[b] + i]];
        ends.push(from + share * (to - from));
      }
    }
  }
  return new Float32Array(ends);
}
