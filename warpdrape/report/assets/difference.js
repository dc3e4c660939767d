// Differences of a run from the first one, at the same points of the flat sheet.
"use strict";

const MOVED = "moved"; // name of the distance between the places of one point in two runs

class Counterpart {
  // `match`: what warpdrape/report/rest_match.py has found for a ply; `first`: the first run's view.
  static async make(match, first, blocks) {
    const found = new Counterpart();
    found.ply = first.plies[match.ply];
    found.same = match.same;
    if (!match.same) {
      found.vertices = await blocks.wholeNumbers(match.vertices);
      found.weights = dequantised(await blocks.steps(match.weights, 1), [0], [1]);
      found.middles = await blocks.wholeNumbers(match.middles);
    }
    return found;
  }

  // Value there of a vertex or triangle of the other run's ply; NaN where it has none.
  value(field, number) {
    const packed = this.ply.packed.fields[field];
    if (!packed) return NaN;
    if (this.same) return this.ply.valueAt(field, number);
    if (!packed.atVertices) {
      const triangle = this.middles[number];
      return triangle ? this.ply.valueAt(field, triangle - 1) : NaN;
    }
    const triangle = this.vertices[number];
    if (!triangle) return NaN;
    return this.ply.valueIn(field, triangle - 1, this.weights[2 * number], this.weights[2 * number + 1]);
  }

  // Where the point of a vertex is in the first run [m]; null where it has none.
  place(number) {
    if (this.same) return this.ply.points.subarray(3 * number, 3 * number + 3);
    const triangle = this.vertices[number];
    if (!triangle) return null;
    return this.ply.placeIn(triangle - 1, this.weights[2 * number], this.weights[2 * number + 1]);
  }
}

// Difference of a ply's field at a vertex or triangle from the first run's, in the unit shown.
function differenceAt(ply, field, number, shown) {
  if (!ply.counterpart) return NaN;
  if (field.name !== MOVED) {
    return shown(ply.valueAt(field.name, number)) - shown(ply.counterpart.value(field.name, number));
  }
  const other = ply.counterpart.place(number);
  if (!other) return NaN;
  const start = 3 * number;
  return 1e3 * Math.hypot(...[0, 1, 2].map((k) => ply.points[start + k] - other[k]));
}
