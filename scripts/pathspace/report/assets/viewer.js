"use strict";

/** Images of a scene on a canvas: flipped through, beside each other, split, subtracted; with zoom, pan and exposure. */
class Viewer {
  static VIEWS = {
    flip: "Flip",
    side: "Side by side",
    split: "Split",
    difference: "Difference",
    error: "Relative error",
    efficiency: "Efficiency",
  };

  constructor(place, scene, colours) {
    this.scene = scene;
    this.images = scene.images;
    this.colours = colours;
    this.view = "flip";
    this.first = this.images.length > 1 ? 1 : 0;
    this.second = 0;
    this.exposure = 0;
    this.zoom = 1;
    this.centre = [0.5, 0.5];
    this.split = 0.5;
    this.cursor = null;
    this.build(place);
  }

  async start() {
    for (const image of this.images) {
      image.values = await Pixels.unpack(image.data);
      if (image.efficiency) image.efficiencies = await Pixels.unpack(image.efficiency);
    }
    this.range = Views.efficiencyRange(this.images);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.change();
  }

  build(place) {
    const hint = "keys: 1–9 image · ← → next · Shift+1–9 compared with · v view · e E exposure · + − zoom · 0 whole · i j k l cursor";
    place.innerHTML = `
      <div class="controls" role="toolbar" aria-label="Images"><span class="names" role="group" aria-label="Image"></span>
        <label class="other">and <select class="second"></select></label></div>
      <div class="controls"><span class="views" role="group" aria-label="View"></span>
        <label>Exposure <input class="exposure" type="range" min="-8" max="8" step="0.25" value="0"> <output></output></label>
        <label class="slider">Split <input class="split" type="range" min="0" max="1" step="0.01" value="0.5"></label>
        <button type="button" class="whole">Whole image</button></div>
      <canvas class="images" tabindex="0" role="img"></canvas>
      <div class="legend" hidden><span></span><canvas width="256" height="1"></canvas><span></span><span></span></div>
      <p class="reading" role="status"></p>`;
    const find = (name) => place.querySelector(name);
    this.canvas = find("canvas.images");
    this.canvas.title = hint;
    [this.reading, this.legend, this.output] = [find(".reading"), find(".legend"), find("output")];
    [this.secondBox, this.slider] = [find(".other"), find(".slider")];
    this.hint = hint;
    this.names = this.images.map((image, i) => this.button(find(".names"), image.name, () => this.set({ first: i })));
    const views = Object.entries(Viewer.VIEWS).filter(([view]) => this.offers(view));
    this.views = Object.fromEntries(
      views.map(([view, label]) => [view, this.button(find(".views"), label, () => this.set({ view }))]),
    );
    this.select = find(".second");
    this.images.forEach((image, i) => this.select.add(new Option(image.name, i)));
    this.select.onchange = () => this.set({ second: Number(this.select.value) });
    this.exposureInput = find(".exposure");
    this.exposureInput.oninput = () => this.set({ exposure: Number(this.exposureInput.value) });
    this.splitInput = find(".split");
    this.splitInput.oninput = () => this.set({ split: Number(this.splitInput.value) });
    find(".whole").onclick = () => this.set({ zoom: 1, centre: [0.5, 0.5] });
    this.listen();
  }

  button(place, label, action) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = label;
    button.onclick = action;
    place.append(button, " ");
    return button;
  }

  reference() {
    return this.images.find((image) => image.name === "reference");
  }

  offers(view) {
    if (view === "error") return Boolean(this.reference());
    if (view === "efficiency") return this.images.some((image) => image.efficiency);
    return view === "flip" || this.images.length > 1;
  }

  compares() {
    return ["side", "split", "difference"].includes(this.view);
  }

  set(values) {
    Object.assign(this, values);
    this.change();
  }

  listen() {
    const { canvas } = this;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomAt(1.2 ** -Math.sign(event.deltaY), this.place(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      const box = this.box();
      const onSplit = this.view === "split" && Math.abs(event.offsetX - this.split * canvas.clientWidth) < 8;
      this.drag = onSplit ? "split" : { x: event.offsetX, y: event.offsetY, centre: this.centre, size: box.size };
    });
    canvas.addEventListener("pointerup", () => (this.drag = null));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  moved(event) {
    if (this.drag === "split") {
      this.set({ split: Math.min(1, Math.max(0, event.offsetX / this.canvas.clientWidth)) });
    } else if (this.drag) {
      const { x, y, centre, size } = this.drag;
      this.set({ centre: [centre[0] - (event.offsetX - x) / size[0], centre[1] - (event.offsetY - y) / size[1]] });
    }
    this.cursor = this.place(event).pixel;
    this.read();
  }

  key(event) {
    const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
    const image = this.images[this.first];
    const step = (x, y) => {
      const [column, row] = this.cursor ?? [Math.floor(image.width / 2), Math.floor(image.height / 2)];
      const clamp = (value, size) => Math.min(size - 1, Math.max(0, value));
      this.set({ cursor: [clamp(column + x, image.width), clamp(row + y, image.height)] });
    };
    const turn = (by) => this.set({ first: (this.first + by + this.images.length) % this.images.length });
    const views = Object.keys(this.views);
    const actions = {
      ArrowRight: () => turn(1),
      ArrowLeft: () => turn(-1),
      v: () => this.set({ view: views[(views.indexOf(this.view) + 1) % views.length] }),
      e: () => this.set({ exposure: Math.min(8, this.exposure + 0.5) }),
      E: () => this.set({ exposure: Math.max(-8, this.exposure - 0.5) }),
      "+": () => this.zoomAt(1.5, { at: this.centre }),
      "=": () => this.zoomAt(1.5, { at: this.centre }),
      "-": () => this.zoomAt(1 / 1.5, { at: this.centre }),
      0: () => this.set({ zoom: 1, centre: [0.5, 0.5] }),
      j: () => step(-1, 0),
      l: () => step(1, 0),
      i: () => step(0, -1),
      k: () => step(0, 1),
    };
    if (digit && this.images[digit - 1]) {
      this.set(event.shiftKey ? { second: digit - 1 } : { first: digit - 1 });
    } else if (actions[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) {
      actions[event.key]();
    } else {
      return;
    }
    event.preventDefault();
  }

  /** Keeps the place under the cursor where it is. */
  zoomAt(factor, { at }) {
    const zoom = Math.min(64, Math.max(1, this.zoom * factor));
    const share = 1 - this.zoom / zoom;
    this.set({ zoom, centre: this.centre.map((centre, i) => centre + (at[i] - centre) * share) });
  }

  /** Where the image lies in a panel: its size, and its left upper corner, in CSS pixels. */
  box(panels = this.view === "side" ? 2 : 1) {
    const { width, height } = this.images[this.first];
    const [room, tall] = [this.canvas.clientWidth / panels, this.canvas.clientHeight];
    const scale = this.zoom * Math.min(room / width, tall / height);
    const size = [scale * width, scale * height];
    return { room, size, corner: [room / 2 - this.centre[0] * size[0], tall / 2 - this.centre[1] * size[1]] };
  }

  place(event) {
    const { room, size, corner } = this.box();
    const x = ((event.offsetX % room) - corner[0]) / size[0];
    const y = (event.offsetY - corner[1]) / size[1];
    const { width, height } = this.images[this.first];
    const pixel = x >= 0 && x < 1 && y >= 0 && y < 1 ? [Math.floor(x * width), Math.floor(y * height)] : null;
    return { at: [x, y], pixel };
  }

  /** Makes the pictures anew, which a movement alone does not need. */
  change() {
    const [first, second] = [this.images[this.first], this.images[this.second]];
    const factor = 2 ** this.exposure;
    const key = [this.view, this.first, this.second, this.exposure].join();
    if (first.values && key !== this.made) {
      this.made = key;
      const pictures = {
        flip: () => [Views.plain(first, factor)],
        side: () => [Views.plain(first, factor), Views.plain(second, factor)],
        split: () => [Views.plain(first, factor), Views.plain(second, factor)],
        difference: () => [Views.difference(first, second, factor)],
        error: () => [Views.error(first, this.reference(), this.colours)],
        efficiency: () => [first.efficiencies ? Views.efficiency(first, this.range, this.colours) : Views.plain(first, 0)],
      };
      this.pictures = pictures[this.view]().map((bytes) => {
        const canvas = new OffscreenCanvas(bytes.width, bytes.height);
        canvas.getContext("2d").putImageData(bytes, 0, 0);
        return canvas;
      });
    }
    this.controls(first, second);
    this.draw();
    this.read();
  }

  controls(first, second) {
    this.names.forEach((button, i) => button.setAttribute("aria-pressed", String(i === this.first)));
    Object.entries(this.views).forEach(([view, b]) => b.setAttribute("aria-pressed", String(view === this.view)));
    this.select.value = this.second;
    this.secondBox.hidden = !this.compares();
    this.slider.hidden = this.view !== "split";
    this.exposureInput.value = this.exposure;
    this.splitInput.value = this.split;
    this.output.textContent = `${this.exposure >= 0 ? "+" : "−"}${Math.abs(this.exposure)} stops`;
    const other = this.compares() ? ` and ${second.name}` : "";
    this.canvas.setAttribute("aria-label", `${this.scene.name}: ${first.name}${other}, ${Viewer.VIEWS[this.view]}`);
    this.showLegend();
  }

  showLegend() {
    const legends = { error: [Views.ERRORS, "(x − r)² / (r² + 0.01)"], efficiency: [this.range, "1 / (variance · s)"] };
    this.legend.hidden = !legends[this.view];
    if (this.legend.hidden) return;
    const [[low, high], what] = legends[this.view];
    const [from, canvas, to, meaning] = this.legend.children;
    [from.textContent, to.textContent, meaning.textContent] = [`10^${low}`, `10^${high}`, what];
    const bytes = new ImageData(256, 1);
    this.colours.forEach((colour, i) => bytes.data.set([...colour, 255], 4 * i));
    canvas.getContext("2d").putImageData(bytes, 0, 0);
  }

  draw() {
    if (!this.pictures) return;
    const ratio = devicePixelRatio || 1;
    const { canvas } = this;
    [canvas.width, canvas.height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    const { room, size, corner } = this.box();
    context.imageSmoothingEnabled = size[0] < this.pictures[0].width;
    const panel = (picture, left, clipLeft, clipWidth) => {
      context.save();
      context.beginPath();
      context.rect(clipLeft, 0, clipWidth, canvas.clientHeight);
      context.clip();
      context.drawImage(picture, left + corner[0], corner[1], ...size);
      context.restore();
    };
    const at = this.split * room;
    if (this.view === "side") {
      this.pictures.forEach((picture, i) => panel(picture, i * room, i * room, room));
    } else if (this.view === "split") {
      panel(this.pictures[0], 0, 0, at);
      panel(this.pictures[1], 0, at, room - at);
    } else {
      panel(this.pictures[0], 0, 0, room);
    }
    if (this.view === "side" || this.view === "split") {
      context.fillStyle = "#fff";
      context.fillRect((this.view === "side" ? room : at) - 1, 0, 2, canvas.clientHeight);
    }
    if (this.cursor && document.activeElement === canvas) {
      const scale = size[0] / this.pictures[0].width;
      context.strokeStyle = "#fff";
      context.strokeRect(corner[0] + this.cursor[0] * scale, corner[1] + this.cursor[1] * scale, scale, scale);
    }
  }

  /** Values under the cursor. */
  read() {
    if (!this.cursor) {
      this.reading.textContent = this.hint;
      return;
    }
    const [x, y] = this.cursor;
    const shown = new Set([this.first, ...(this.compares() ? [this.second] : [])].map((i) => this.images[i]));
    if (this.reference()) shown.add(this.reference());
    const lines = [...shown].filter((image) => image.values).map((image) => {
      const i = y * image.width + x;
      const values = [0, 1, 2].map((c) => image.values[3 * i + c].toPrecision(4)).join("  ");
      return `${image.name}: ${values}`;
    });
    const extra = [];
    const first = this.images[this.first];
    if (this.view === "error" && first.values) {
      const error = Views.relativeError(first, this.reference(), y * first.width + x);
      extra.push(`relative squared error ${error.toPrecision(3)}`);
    }
    if (this.view === "efficiency" && first.efficiencies) {
      extra.push(`efficiency ${(10 ** first.efficiencies[y * first.width + x]).toPrecision(3)}`);
    }
    this.reading.textContent = [`pixel ${x}, ${y}`, ...extra].join(" · ") + "\n" + lines.join("\n");
  }
}
