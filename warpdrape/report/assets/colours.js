// From values to colours: a texture with a row for each scale, and one for what has no value.
"use strict";

const ROWS = { plain: 0.125, difference: 0.375, nothing: 0.625 }; // middles of rows, from below
const NO_VALUE = [150, 150, 150];

function rgbOf(hex) {
  return [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

// Texture of the two scales, each a list of colours without "#".
function scaleTexture(scales) {
  const width = scales.plain.length;
  const texels = new Uint8Array(4 * width * 4);
  for (let row = 0; row < 4; row++) {
    for (let k = 0; k < width; k++) {
      const colour =
        row === 0 ? rgbOf(scales.plain[k]) : row === 1 ? rgbOf(scales.difference[k]) : NO_VALUE;
      texels.set([...colour, 255], 4 * (row * width + k));
    }
  }
  const texture = new THREE.DataTexture(texels, width, 4, THREE.RGBAFormat);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

// A number with as many digits as people read.
function said(value, unit) {
  if (!Number.isFinite(value)) return "no value";
  const size = Math.abs(value);
  let text;
  if (unit === "°") text = value.toFixed(1);
  else if (size >= 1000) text = value.toFixed(0);
  else if (size !== 0 && size < 1e-4) text = value.toExponential(2);
  else text = String(Number(value.toPrecision(3)));
  return unit === "°" ? `${text}°` : unit ? `${text} ${unit}` : text;
}

// The legend under the 3-D view: the scale's colours, and what its ends and middle mean.
function drawLegend(element, colours, scale, title, unit) {
  const bar = element.querySelector(".bar");
  bar.width = colours.length;
  bar.height = 1;
  const context = bar.getContext("2d");
  colours.forEach((colour, k) => {
    context.fillStyle = `#${colour}`;
    context.fillRect(k, 0, 1, 1);
  });
  const shares = [0, 0.25, 0.5, 0.75, 1];
  const ticks = element.querySelectorAll(".ticks span");
  shares.forEach((share, k) => {
    ticks[k].textContent = said(scale[0] + share * (scale[1] - scale[0]), unit === "°" ? "°" : "");
  });
  element.querySelector(".title").textContent = unit ? `${title} [${unit}]` : title;
}
