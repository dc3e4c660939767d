// Curves over time, one plot a kind, of all runs together.
"use strict";

const CURVE_COLOURS = ["#3b7dd8", "#e07b28", "#2f9e5b", "#c8395a", "#8a63c9", "#8f6a4f", "#1aa3b5", "#8b9a1f"];
const DASHES = [[], [7, 4], [2, 3], [9, 3, 2, 3], [12, 4], [1, 4]];
const PLOT_HEIGHT = 210;

// Range of an axis: of curves that never differ from one value a range of one unit.
function rangeOf(low, high) {
  if (low === null || high === null) return [0, 1];
  return low < high ? uPlot.rangeNum(low, high, 0.1, true) : [low === 0 ? 0 : low - 0.5, low + 1];
}

class Plots {
  // `runs`: as in the page; `onTime`: told the time [ms] at which somebody has clicked.
  constructor(parent, runs, onTime) {
    this.parent = parent;
    this.runs = runs;
    this.onTime = onTime;
    this.time = 0;
    this.plots = [];
    const titles = new Map();
    runs.forEach((run, number) => {
      for (const plot of run.plots) {
        if (!titles.has(plot.title)) titles.set(plot.title, []);
        titles.get(plot.title).push({ run, number, plot });
      }
    });
    this.groups = [...titles.values()];
    new ResizeObserver(() => this._fit()).observe(parent);
    this.build();
  }

  build() {
    for (const plot of this.plots) plot.destroy();
    this.parent.replaceChildren();
    this.plots = this.groups.map((group) => this._plot(group));
  }

  // Show the present moment [ms] as a line.
  mark(time) {
    this.time = time;
    for (const plot of this.plots) plot.redraw(false, false);
  }

  _width() {
    const columns = getComputedStyle(this.parent).gridTemplateColumns.split(" ").length;
    const gap = 16;
    return Math.max((this.parent.clientWidth - gap * (columns - 1)) / columns - 2, 200);
  }

  _fit() {
    for (const plot of this.plots) plot.setSize({ width: this._width(), height: PLOT_HEIGHT });
  }

  _plot(group) {
    const { title, unit } = group[0].plot;
    const tables = group.map(({ plot }) => [plot.times, ...plot.lines.map((line) => line.values)]);
    const series = group.flatMap(({ run, number, plot }) =>
      plot.lines.map((line, k) => ({
        label: this.runs.length > 1 ? `${run.name}: ${line.name}` : line.name,
        stroke: CURVE_COLOURS[k % CURVE_COLOURS.length],
        dash: DASHES[number % DASHES.length],
        width: 1.5,
        spanGaps: true,
        points: { show: false },
        value: (_, value) => (value === null || value === undefined ? "–" : said(value, unit)),
      })),
    );
    const style = getComputedStyle(document.documentElement);
    const ink = style.getPropertyValue("--ink").trim();
    const grid = { stroke: style.getPropertyValue("--rule").trim(), width: 1 };
    const axis = { stroke: ink, grid, ticks: grid, font: "11px system-ui, sans-serif" };
    const frame = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.textContent = `${title} [${unit}] over time [ms]`;
    frame.append(caption);
    this.parent.append(frame);
    const options = {
      width: this._width(),
      height: PLOT_HEIGHT,
      scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(low, high) } },
      cursor: { sync: { key: "time" } },
      series: [{ label: "time", value: (_, v) => (v === null ? "–" : said(v, "ms")) }, ...series],
      axes: [axis, { ...axis, size: 62 }],
      hooks: { draw: [(plot) => this._drawMark(plot, ink)] },
    };
    const plot = new uPlot(options, uPlot.join(tables), frame);
    plot.over.addEventListener("click", () => {
      if (plot.cursor.left >= 0) this.onTime(plot.posToVal(plot.cursor.left, "x"));
    });
    return plot;
  }

  _drawMark(plot, ink) {
    const x = Math.round(plot.valToPos(this.time, "x", true));
    const { left, top, width, height } = plot.bbox;
    if (x < left || x > left + width) return;
    plot.ctx.save();
    plot.ctx.strokeStyle = ink;
    plot.ctx.setLineDash([]); // uPlot leaves that of the last curve
    plot.ctx.globalAlpha = 0.6;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }
}
