// Blocks of packed numbers, back to arrays; warpdrape/report/packing.py says how they are made.
"use strict";

const NOTHING = 65535;

class Blocks {
  constructor(document) {
    this._document = document;
    this._found = new Map();
  }

  // Bytes of a block: base64, then zlib. Each is undone once, and kept.
  async _bytes(number) {
    const text = this._document.getElementById(`block-${number}`).textContent;
    const packed = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  _once(number, make) {
    if (!this._found.has(number)) this._found.set(number, this._bytes(number).then(make));
    return this._found.get(number);
  }

  // Whole numbers of 32 bits.
  wholeNumbers(number) {
    return this._once(number, (bytes) => {
      const view = new DataView(bytes.buffer);
      return Uint32Array.from({ length: bytes.length / 4 }, (_, k) => view.getUint32(4 * k, true));
    });
  }

  // Numbers of 16 bits at so many frames, as they were before differences were taken.
  steps(number, frames) {
    return this._once(number, (bytes) => {
      const count = bytes.length / 2;
      const row = count / frames;
      const numbers = new Uint16Array(count);
      for (let k = 0; k < count; k++) {
        const step = bytes[k] | (bytes[count + k] << 8);
        numbers[k] = k < row ? step : step + numbers[k - row]; // modulo 65536
      }
      return numbers;
    });
  }

  async text(number) {
    return new TextDecoder().decode(await this._bytes(number));
  }
}

// The value that a number stands for; NaN for none.
function unpacked(number, low, high) {
  return number === NOTHING ? NaN : low + (number * (high - low)) / (NOTHING - 1);
}
