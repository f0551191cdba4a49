"use strict";

/** Values of images, and how they become colours. */
const Pixels = (() => {
  const halves = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const exponent = (bits >> 10) & 31;
    const fraction = bits & 1023;
    const sign = bits & 32768 ? -1 : 1;
    halves[bits] =
      exponent === 31
        ? fraction ? NaN : sign * Infinity
        : sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -14 * (fraction / 1024));
  }

  async function inflate(text) {
    const packed = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Half-precision numbers, whose low bytes stand before their high ones. */
  async function unpack(text) {
    const bytes = await inflate(text);
    const count = bytes.length / 2;
    const values = new Float32Array(count);
    for (let i = 0; i < count; i++) values[i] = halves[bytes[i] | (bytes[count + i] << 8)];
    return values;
  }

  /** The sRGB curve, to a byte. */
  function encoded(linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    return Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
  }

  /** A colour of a map for a number from 0 to 1. */
  function mapped(colours, share) {
    const place = Math.min(255, Math.max(0, Math.round(255 * (Number.isFinite(share) ? share : 0))));
    return colours[place];
  }

  return { unpack, encoded, mapped };
})();
