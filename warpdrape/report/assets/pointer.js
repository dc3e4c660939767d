// The values of the place that the pointer is at.
"use strict";

const TIP_OFFSET = 16; // pixels beside the pointer

function tellValues(report) {
  const [canvas, tip] = [byId("canvas"), byId("tip")];
  on(canvas, "pointerleave", () => (tip.hidden = true));
  on(canvas, "pointermove", (event) => {
    const { left, top } = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - left, event.clientY - top];
    const hit = event.buttons ? null : report.stage.hit(x, y); // while turning it would be in the way
    tip.hidden = !hit;
    if (!hit) return;
    tip.replaceChildren(
      ...measured(report, hit).map(([words, chosen]) => {
        const line = document.createElement(chosen ? "b" : "div");
        line.textContent = words;
        return line;
      }),
    );
    const right = x > canvas.clientWidth / 2;
    tip.style.left = right ? "" : `${x + TIP_OFFSET}px`;
    tip.style.right = right ? `${canvas.clientWidth - x + TIP_OFFSET}px` : "";
    tip.style.top = `${Math.min(y, Math.max(canvas.clientHeight - tip.clientHeight, 0))}px`;
  });
}

// Lines about a place, each with whether it is of the field that is shown.
function measured(report, { number, ply, triangle, second, third }) {
  const run = report.data.runs[number];
  const mm = (place) => place.map((p) => (1e3 * p).toFixed(1)).join(", ");
  const rows = [
    [report.data.runs.length > 1 ? `${run.name}: ${ply.name}` : ply.name, false],
    [`triangle ${triangle}, at (${mm(ply.placeIn(triangle, second, third))}) mm`, false],
    [`on the blank (${mm(ply.placeIn(triangle, second, third, ply.rest).slice(0, 2))}) mm`, false],
  ];
  for (const field of report.data.fields) {
    if (!ply.fields.has(field.name)) continue;
    const value = ply.valueIn(field.name, triangle, second, third);
    rows.push([`${field.title}: ${said(value, field.unit)}`, field === report.field]);
  }
  if (report.mode !== OWN && number > 0) rows.push([differenceWords(report, ply, triangle), true]);
  return rows;
}

// How a triangle differs from the first run; at vertices it is the mean of its corners.
function differenceWords(report, ply, triangle) {
  const moved = report.mode === MOVED;
  const field = moved ? { name: MOVED } : report.field;
  const packed = ply.packed.fields[report.field.name];
  if (!moved && !packed) return "difference: no value";
  const shown = (value) => (report.field.signed ? value : Math.abs(value));
  const corners = ply.corners.subarray(3 * triangle, 3 * triangle + 3);
  const parts = moved || packed.atVertices ? [...corners] : [triangle];
  const sum = parts.reduce((total, part) => total + differenceAt(ply, field, part, shown), 0);
  const words = moved ? "way from the place there" : "difference";
  return `${words}: ${said(sum / parts.length, moved ? "mm" : report.field.unit)}`;
}
