// The page's controls, and what they do.
"use strict";

const OWN = "own"; // what is shown: each run's own values; else a difference from the first run
const DIFFERENCE = "difference";
const MOST_SPREAD = 0.15; // of the size of all that is seen, between two plies
const PLAY_EVERY = 90; // milliseconds a frame
const LOOKS = {
  oblique: [ELEVATION_DEG, AZIMUTH_DEG],
  "oblique, from below": [-ELEVATION_DEG, AZIMUTH_DEG],
  above: [89.9, -90],
  below: [-89.9, -90],
  front: [0, -90],
  side: [0, 0],
};

class Report {
  constructor(data) {
    this.data = data;
    this.blocks = new Blocks(document);
    this.mode = OWN;
    this.share = 1;
    this.scales = Object.fromEntries(data.fields.map((field) => [field.name, field.scale]));
    this.differenceScale = [-1, 1];
  }

  async start() {
    this._savers();
    this.plots = new Plots(byId("plots"), this.data.runs, (time) => this.setTime(time));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this._recolour());
    if (!hasWebgl()) {
      byId("no-webgl").hidden = false;
      byId("view").hidden = true;
      return;
    }
    const texture = scaleTexture(this.data.colours);
    const views = [];
    for (const run of this.data.runs) views.push(await RunView.make(run, this.blocks, texture));
    await this._counterparts(views);
    for (const view of views) await view.setShare(this.share);
    this.stage = new Stage(byId("canvas"), views);
    this.field = this.data.fields[0];
    addControls(this);
    await this.loadField();
    await this.setShare(this.share);
    byId("view").dataset.ready = "yes";
    for (const field of this.data.fields) await this._load(field); // for what the pointer tells
  }

  async _counterparts(views) {
    for (const [number, run] of this.data.runs.entries()) {
      for (const [k, match] of (run.matches || []).entries()) {
        if (!match) continue;
        views[number].plies[k].counterpart = await Counterpart.make(match, views[0], this.blocks);
      }
    }
  }

  async _load(field) {
    for (const view of this.stage.views) {
      for (const ply of view.plies) await ply.load(field.name);
    }
  }

  async loadField() {
    await this._load(this.field);
    if (this.mode !== OWN) await this._findDifferenceScale();
    this.showScale();
  }

  // Go to the frame nearest to a time of the first run [ms].
  setTime(time) {
    if (!this.stage) return this.plots.mark(time);
    const times = this.data.runs[0].times;
    const [first, last] = [times[0], times[times.length - 1]];
    const share = last > first ? (time / 1e3 - first) / (last - first) : 0;
    return this.setShare(Math.min(Math.max(share, 0), 1));
  }

  async setShare(share) {
    this.share = share;
    const slider = byId("time");
    slider.value = Math.round(share * slider.max);
    for (const view of this.stage.views) await view.setShare(share);
    this.paint();
    const { views } = this.stage;
    const words = views.map((view, k) => {
      return views.length > 1 ? `${this.data.runs[k].name}: ${view.words()}` : view.words();
    });
    byId("moment").textContent = words.join("   |   ");
    slider.setAttribute("aria-valuetext", words.join(", "));
    this.plots.mark(1e3 * this.data.runs[0].times[views[0].frame]);
  }

  // Colour all plies, and draw.
  paint() {
    const shown = (value) => (this.field.signed ? value : Math.abs(value));
    this.stage.views.forEach((view, number) => {
      for (const ply of view.plies) {
        if (this.mode === OWN || number === 0) this._paintOwn(ply, shown);
        else this._paintDifference(ply, shown);
      }
    });
    this.stage.cut.apply(this.stage.views);
    this.stage.draw();
  }

  _paintOwn(ply, shown) {
    const packed = ply.packed.fields[this.field.name];
    const value = packed ? (part) => shown(ply.valueAt(this.field.name, part)) : () => NaN;
    ply.paint(value, packed?.atVertices ?? false, this.scales[this.field.name], "plain");
  }

  _paintDifference(ply, shown) {
    const moved = this.mode === MOVED;
    const packed = ply.packed.fields[this.field.name];
    const field = moved ? { name: MOVED } : this.field;
    const known = moved || packed;
    const value = known ? (part) => differenceAt(ply, field, part, shown) : () => NaN;
    const row = moved ? "plain" : "difference";
    ply.paint(value, moved || (packed?.atVertices ?? false), this.differenceScale, row);
  }

  // The scale of differences holds those at the end of the runs.
  async _findDifferenceScale() {
    const { share } = this;
    const shown = (value) => (this.field.signed ? value : Math.abs(value));
    for (const view of this.stage.views) await view.setShare(1);
    let largest = 0;
    for (const view of this.stage.views.slice(1)) {
      for (const ply of view.plies) {
        const packed = ply.packed.fields[this.field.name];
        const moved = this.mode === MOVED;
        if (!moved && !packed) continue;
        const count = moved || packed.atVertices ? ply.packed.vertices : ply.packed.triangles;
        for (let part = 0; part < count; part++) {
          const field = moved ? { name: MOVED } : this.field;
          const size = Math.abs(differenceAt(ply, field, part, shown));
          if (size > largest) largest = size;
        }
      }
    }
    for (const view of this.stage.views) await view.setShare(share);
    const top = roundedUp(largest) || 1;
    this.differenceScale = this.mode === MOVED ? [0, top] : [-top, top];
  }

  showScale() {
    const { title, unit, name } = this.field;
    const scale = this.scales[name];
    drawLegend(byId("legend"), this.data.colours.plain, scale, title, unit);
    byId("low").value = String(scale[0]);
    byId("high").value = String(scale[1]);
    const apart = byId("difference-legend");
    apart.hidden = this.mode === OWN;
    if (this.mode === OWN) return;
    const first = this.data.runs[0].name;
    const moved = this.mode === MOVED;
    const words = moved ? `way from the place in ${first}` : `${title}: difference from ${first}`;
    const colours = moved ? this.data.colours.plain : this.data.colours.difference;
    drawLegend(apart, colours, this.differenceScale, words, moved ? "mm" : unit);
  }

  play() {
    const [button, slider] = [byId("play"), byId("time")];
    if (this.playing) return this._pause();
    button.textContent = "Pause";
    if (this.share >= 1) this.share = 0;
    let step = Math.round(this.share * slider.max);
    this.playing = setInterval(() => {
      this.setShare(step / slider.max);
      if (++step > slider.max) this._pause();
    }, PLAY_EVERY);
    return undefined;
  }

  _pause() {
    clearInterval(this.playing);
    this.playing = null;
    byId("play").textContent = "Play";
  }

  placeNames() {
    const place = byId("names");
    place.replaceChildren();
    if (this.data.runs.length < 2) return;
    this.data.runs.forEach((run, k) => {
      const { left, top } = this.stage.area(k);
      const name = document.createElement("span");
      name.textContent = run.name;
      name.style.left = `${left + 10}px`;
      name.style.top = `${top + 6}px`;
      place.append(name);
    });
  }

  _recolour() {
    this.plots.build();
    if (this.stage) this.stage.draw();
  }

  savePicture() {
    this.stage.drawNow(); // what was drawn before may be gone from the canvas
    byId("canvas").toBlob((blob) => save(blob, "view.png"));
  }

  _savers() {
    for (const button of document.querySelectorAll("[data-block]")) {
      on(button, "click", async () => {
        const text = await this.blocks.text(Number(button.dataset.block));
        save(new Blob([text], { type: "text/plain" }), button.dataset.file);
      });
    }
  }
}

function byId(id) {
  return document.getElementById(id);
}

function on(element, event, action) {
  element.addEventListener(event, action);
}

function fill(select, entries) {
  for (const [value, words] of entries) select.append(new Option(words, value));
}

function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// The next round number from a value on.
function roundedUp(value) {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((digit) => digit * power >= value * (1 - 1e-9));
}

function hasWebgl() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

window.report = new Report(JSON.parse(byId("data").textContent));
window.report.start().catch((error) => {
  byId("trouble").hidden = false;
  byId("trouble").textContent = `The 3-D view could not be shown: ${error.message}`;
  throw error;
});
