// A ply in the 3-D view: its shape at a frame, its colours, and some of its yarns as lines.
"use strict";

const YARN_COLOURS = [0x111111, 0xe6007e]; // of warp and weft: on both scales, light and dark
const YARN_WIDTH = 1.2; // pixels

class PlyView {
  // `packed`: of one ply; `run`: of the run that it belongs to.
  static async make(packed, run, blocks, texture) {
    const ply = new PlyView();
    ply.name = packed.name;
    ply.packed = packed;
    ply.run = run;
    ply.blocks = blocks;
    ply.corners = await blocks.wholeNumbers(packed.corners);
    ply.steps = await blocks.steps(packed.points, run.frames.length);
    ply.rest = dequantised(await blocks.steps(packed.rest, 1), packed.restLow, packed.restHigh);
    ply.points = new Float32Array(3 * packed.vertices);
    ply.normals = new Float32Array(3 * packed.vertices);
    ply.fields = new Map(); // name → numbers of 16 bits over all frames
    ply._addMesh(texture);
    await ply._addYarns();
    return ply;
  }

  _addMesh(texture) {
    const geometry = new THREE.BufferGeometry();
    const count = 3 * this.packed.triangles; // corners are apart, so that triangles have colours
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("uv", new THREE.BufferAttribute(new Float32Array(2 * count), 2));
    const material = new THREE.MeshLambertMaterial({
      map: texture,
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 2,
    });
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.group = new THREE.Group();
    this.group.add(this.mesh);
  }

  async _addYarns() {
    this.yarns = [];
    this.yarnGroup = new THREE.Group();
    this.group.add(this.yarnGroup);
    for (const [family, lines] of this.packed.yarns.entries()) {
      if (!lines.count) continue;
      const triangles = await this.blocks.wholeNumbers(lines.triangles);
      const weights = dequantised(await this.blocks.steps(lines.weights, 1), [0], [1]);
      const line = wideLines(YARN_COLOURS[family], YARN_WIDTH);
      this.yarnGroup.add(line);
      this.yarns.push({ triangles, weights, line });
    }
  }

  async setFrame(frame) {
    this.frame = frame;
    const { low, high } = this.run;
    const start = frame * this.points.length;
    for (let k = 0; k < this.points.length; k++) {
      this.points[k] = unpacked(this.steps[start + k], low[k % 3], high[k % 3]);
    }
    this._findNormals();
    const position = this.mesh.geometry.attributes.position;
    const normal = this.mesh.geometry.attributes.normal;
    this.corners.forEach((vertex, corner) => {
      for (let axis = 0; axis < 3; axis++) {
        position.array[3 * corner + axis] = this.points[3 * vertex + axis];
        normal.array[3 * corner + axis] = this.normals[3 * vertex + axis];
      }
    });
    position.needsUpdate = normal.needsUpdate = true;
    this.mesh.geometry.computeBoundingSphere();
    this.mesh.geometry.computeBoundingBox();
    for (const yarn of this.yarns) this._placeYarns(yarn);
  }

  // Normals at vertices, weighted by the triangles' areas.
  _findNormals() {
    this.normals.fill(0);
    const p = this.points;
    for (let t = 0; t < this.corners.length; t += 3) {
      const [a, b, c] = [3 * this.corners[t], 3 * this.corners[t + 1], 3 * this.corners[t + 2]];
      const u = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
      const v = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
      for (const corner of [a, b, c]) {
        this.normals[corner] += u[1] * v[2] - u[2] * v[1];
        this.normals[corner + 1] += u[2] * v[0] - u[0] * v[2];
        this.normals[corner + 2] += u[0] * v[1] - u[1] * v[0];
      }
    }
    for (let k = 0; k < this.normals.length; k += 3) {
      const size = Math.hypot(this.normals[k], this.normals[k + 1], this.normals[k + 2]) || 1;
      for (let axis = 0; axis < 3; axis++) this.normals[k + axis] /= size;
    }
  }

  _placeYarns(yarn) {
    const ends = new Float32Array(6 * yarn.triangles.length);
    yarn.triangles.forEach((triangle, piece) => {
      for (let end = 0; end < 2; end++) {
        const weights = yarn.weights.subarray(4 * piece + 2 * end, 4 * piece + 2 * end + 2);
        ends.set(this.placeIn(triangle, weights[0], weights[1]), 6 * piece + 3 * end);
      }
    });
    setLines(yarn.line, ends);
  }

  // A place in a triangle, from the weights of its second and third corner.
  placeIn(triangle, second, third, points = this.points) {
    const place = [0, 0, 0];
    [1 - second - third, second, third].forEach((weight, k) => {
      const vertex = this.corners[3 * triangle + k];
      for (let axis = 0; axis < 3; axis++) place[axis] += weight * points[3 * vertex + axis];
    });
    return place;
  }

  async load(field) {
    const packed = this.packed.fields[field];
    if (!packed || this.fields.has(field)) return;
    this.fields.set(field, await this.blocks.steps(packed.block, this.run.frames.length));
  }

  // Value of a field at a vertex or in a triangle, with its sign, at the present frame.
  valueAt(field, number) {
    const packed = this.packed.fields[field];
    const count = packed.atVertices ? this.packed.vertices : this.packed.triangles;
    const step = this.fields.get(field)[this.frame * count + number];
    return unpacked(step, packed.low, packed.high);
  }

  // The same in a triangle, at a point of it.
  valueIn(field, triangle, second, third) {
    if (!this.packed.fields[field].atVertices) return this.valueAt(field, triangle);
    return [1 - second - third, second, third].reduce((sum, weight, k) => {
      return sum + weight * this.valueAt(field, this.corners[3 * triangle + k]);
    }, 0);
  }

  // Colour by a function of vertex or triangle.
  paint(valueOfPart, atVertices, scale, row) {
    const uv = this.mesh.geometry.attributes.uv;
    const [low, high] = scale;
    const texels = 256; // ends of the scale are in the middle of its first and last texel
    for (let corner = 0; corner < this.corners.length; corner++) {
      const part = atVertices ? this.corners[corner] : Math.floor(corner / 3);
      const value = valueOfPart(part);
      const share = Math.min(Math.max((value - low) / (high - low || 1), 0), 1);
      const known = Number.isFinite(value);
      uv.array[2 * corner] = known ? (0.5 + share * (texels - 1)) / texels : 0.5;
      uv.array[2 * corner + 1] = known ? ROWS[row] : ROWS.nothing;
    }
    uv.needsUpdate = true;
  }
}

function dequantised(numbers, low, high) {
  return Float32Array.from(numbers, (n, k) => unpacked(n, low[k % low.length], high[k % low.length]));
}

function wideLines(colour, width) {
  const material = new THREE.LineMaterial({ color: colour, linewidth: width });
  const lines = new THREE.LineSegments2(new THREE.LineSegmentsGeometry(), material);
  lines.frustumCulled = false;
  return lines;
}

function setLines(lines, ends) {
  lines.geometry.dispose();
  lines.geometry = new THREE.LineSegmentsGeometry();
  lines.visible = ends.length > 0;
  if (ends.length) lines.geometry.setPositions(ends);
}
