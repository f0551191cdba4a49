"use strict";

/** What a view makes of the images of a scene: bytes of a picture, and a legend where colours mean numbers. */
const Views = (() => {
  const EPSILON = 0.01;
  /** Powers of ten that relative squared errors and efficiencies are shown in. */
  const ERRORS = [-5, 1];

  function picture(image, colour) {
    const { width, height } = image;
    const bytes = new ImageData(width, height);
    const out = [0, 0, 0];
    for (let i = 0; i < width * height; i++) {
      colour(i, out);
      bytes.data.set(out, 4 * i);
      bytes.data[4 * i + 3] = 255;
    }
    return bytes;
  }

  function plain(image, factor) {
    return picture(image, (i, out) => {
      for (let c = 0; c < 3; c++) out[c] = Pixels.encoded(factor * image.values[3 * i + c]);
    });
  }

  /** Orange where the first is brighter, blue where the second is: told apart with any colour vision. */
  function difference(first, second, factor) {
    return picture(first, (i, out) => {
      let sum = 0;
      for (let c = 0; c < 3; c++) sum += first.values[3 * i + c] - second.values[3 * i + c];
      const strength = Pixels.encoded((factor * Math.abs(sum)) / 3);
      out[0] = sum > 0 ? strength : 0;
      out[1] = Math.round(0.5 * strength);
      out[2] = sum > 0 ? 0 : strength;
    });
  }

  function relativeError(image, reference, i) {
    let sum = 0;
    for (let c = 0; c < 3; c++) {
      const [x, r] = [image.values[3 * i + c], reference.values[3 * i + c]];
      sum += (x - r) ** 2 / (r * r + EPSILON);
    }
    return sum / 3;
  }

  function error(image, reference, colours) {
    const [low, high] = ERRORS;
    return picture(image, (i, out) => {
      const power = Math.log10(Math.max(relativeError(image, reference, i), 1e-30));
      const colour = Pixels.mapped(colours, (power - low) / (high - low));
      [out[0], out[1], out[2]] = colour;
    });
  }

  /** Between the powers of ten that nearly all pixels of all methods lie between. */
  function efficiencyRange(images) {
    const all = [];
    for (const image of images) {
      if (image.efficiencies) for (let i = 0; i < image.efficiencies.length; i += 7) all.push(image.efficiencies[i]);
    }
    all.sort((a, b) => a - b);
    const at = (share) => all[Math.floor(share * (all.length - 1))] ?? 0;
    return [Math.floor(at(0.02)), Math.max(Math.ceil(at(0.98)), Math.floor(at(0.02)) + 1)];
  }

  function efficiency(image, range, colours) {
    const [low, high] = range;
    return picture(image, (i, out) => {
      const colour = Pixels.mapped(colours, (image.efficiencies[i] - low) / (high - low));
      [out[0], out[1], out[2]] = colour;
    });
  }

  return { plain, difference, error, efficiency, efficiencyRange, relativeError, ERRORS };
})();
