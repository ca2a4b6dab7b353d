// Plots over time: uPlot with units, a mark at the time of the animation, one cursor for all.

const TIME = { dynamic: ["time", "s"], static: ["load factor", ""], modal: ["load factor", ""] }[run.kind];

class Plots {
  // `onTime(time)` is told where a plot is clicked.
  constructor(arrays, onTime) {
    Object.assign(this, { arrays, onTime, shown: [], time: null });
    this.sections = ["run", "probes", "reactions"].map((name) => this.section(name)).filter(Boolean);
    new ResizeObserver(() => this.fitWidths()).observe(document.querySelector("main"));
  }

  section(name) {
    const grid = document.querySelector(`.grid[data-section="${name}"]`);
    const charts = run.charts.filter((chart) => chart.section === name);
    const outer = grid.closest("section");
    outer.hidden = charts.length === 0;
    document.querySelectorAll(`nav a[href="#${outer.id}"]`).forEach((link) => (link.hidden = charts.length === 0));
    if (charts.length === 0) return null;
    const choice = outer.querySelector("select");
    if (choice) {
      for (const group of new Set(charts.map((chart) => chart.group))) choice.add(new Option(group));
      choice.addEventListener("change", () => this.redraw());
    }
    return { grid, charts, choice };
  }

  // Makes all plots anew: another theme, another probe.
  redraw() {
    for (const { plot } of this.shown) plot.destroy();
    this.shown = [];
    for (const { grid, charts, choice } of this.sections) {
      grid.replaceChildren();
      for (const chart of charts) if (!choice || chart.group === choice.value) this.shown.push(this.make(chart, grid));
    }
    this.mark(this.time);
  }

  make(chart, grid) {
    const card = document.createElement("figure");
    card.className = "card plot";
    const caption = document.createElement("figcaption");
    const place = document.createElement("div");
    card.append(caption, place);
    grid.append(card);

    const { data, factor, unit } = this.data(chart);
    caption.textContent = unit ? `${chart.title} (${unit})` : chart.title;
    if (chart.note) {
      const note = document.createElement("small");
      note.textContent = chart.note;
      caption.append(note);
    }
    const logarithmic = chart.logarithmic && data[1].some((value) => value > 0);
    const axis = { stroke: css("--muted"), font: "12px system-ui, sans-serif", grid: { stroke: css("--grid"), width: 1 }, ticks: { stroke: css("--grid"), width: 1 } };
    const lines = chart.curves.map(({ label }, k) => ({
      label,
      stroke: css(`--c${k}`),
      width: 1.6,
      paths: chart.stairs ? uPlot.paths.stepped({ align: -1 }) : undefined,
      points: { show: data[0].length < 40, size: 5 },
      value: (_, value) => short(value),
    }));
    const plot = new uPlot(
      {
        width: place.clientWidth,
        height: 230,
        scales: {
          x: { time: false },
          y: { distr: logarithmic ? 3 : 1, ...(logarithmic ? {} : { range: (_, low, high) => rangeOf(low, high) }) },
        },
        axes: [
          { ...axis, label: TIME[1] ? `${TIME[0]} (${TIME[1]})` : TIME[0], labelSize: 20, labelFont: axis.font, size: 34 },
          { ...axis, size: (_, texts) => Math.max(58, 18 + 7 * Math.max(0, ...(texts ?? []).map((text) => text.length))), values: (_, values, __, ___, step) => labels(values, logarithmic ? 0 : step) },
        ],
        series: [{ label: TIME[0], value: (_, value) => short(value, 5) }, ...lines],
        cursor: { sync: { key: "time" }, y: false, points: { size: 6 } },
        legend: { live: true },
      },
      data,
      place,
    );
    const mark = document.createElement("div");
    mark.className = "mark";
    plot.over.append(mark);
    const shown = { plot, mark, place, chart, factor };
    plot.hooks.setScale = [(_, key) => key === "x" && this.move(shown)];
    plot.hooks.draw = [() => this.place(shown)]; // the width of the labels, and so all places, are known only then
    plot.hooks.setCursor = [() => plot.cursor.left < 0 && this.tell(shown)];
    let pressed = 0;
    plot.over.addEventListener("pointerdown", (event) => (pressed = event.clientX));
    plot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - pressed) > 3) return; // a stretch of time was chosen
      this.onTime(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
    });
    return shown;
  }

  // Columns in a unit that suits the largest value.
  data(chart) {
    const { rows } = run.tables[chart.table];
    const all = this.arrays[chart.table].values;
    const columns = chart.curves.map(({ column }) => all.subarray((column - 1) * rows, column * rows));
    let largest = 0;
    for (const column of columns) for (const value of column) if (Math.abs(value) > largest) largest = Math.abs(value);
    const { factor, unit } = scaled(largest, chart.unit);
    const shown = columns.map((column) =>
      Array.from(column, (value) => (!Number.isFinite(value) || (chart.logarithmic && value <= 0) ? null : value / factor)),
    );
    return { data: [Array.from(this.arrays[`${chart.table} time`].values), ...shown], factor, unit };
  }

  mark(time) {
    this.time = time;
    for (const shown of this.shown) this.move(shown);
  }

  // The line at the time of the animation, and the values there.
  move(shown) {
    if (!(shown.plot.cursor.left >= 0)) this.tell(shown);
    this.place(shown);
  }

  place({ plot, mark }) {
    const { min, max } = plot.scales.x;
    mark.hidden = this.time === null || !(this.time >= min && this.time <= max);
    if (!mark.hidden) mark.style.transform = `translateX(${plot.valToPos(this.time, "x")}px)`;
  }

  // Values in the legend: at the time of the animation, while no pointer asks for another.
  tell({ plot }) {
    const row = this.time === null ? plot.data[0].length - 1 : plot.valToIdx(this.time);
    if (row >= 0 && plot.legend.idx !== row) plot.setLegend({ idx: row }, false);
  }

  fitWidths() {
    for (const shown of this.shown) {
      const width = shown.place.clientWidth;
      if (width && width !== shown.plot.width) {
        shown.plot.setSize({ width, height: shown.plot.height });
        this.move(shown);
      }
    }
  }
}

// Labels `step` apart on an axis, in as many digits as they need to differ.
function labels(values, step) {
  const largest = Math.max(...values.map((value) => Math.abs(value ?? 0)));
  const digits = step > 0 && largest > 0 ? Math.ceil(Math.log10(largest / step)) + 2 : 4;
  return values.map((value) => (value === null ? "" : short(value, Math.min(Math.max(digits, 4), 10))));
}

// Ends of a vertical axis with some air; also where all values are the same.
function rangeOf(low, high) {
  if (low === null || high === null) return [0, 1];
  if (low === high) return low === 0 ? [-1, 1] : [Math.min(0, 1.2 * low), Math.max(0, 1.2 * low)];
  const air = 0.06 * (high - low);
  return [low >= 0 && low < 0.3 * high ? 0 : low - air, high + air];
}
