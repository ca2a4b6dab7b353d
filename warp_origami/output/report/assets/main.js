// The page: what its controls do.

const at = (id) => document.getElementById(id);

// The clock, the colours and the camera of the animation.
class Animation {
  constructor(sheet, stage, plots, arrays) {
    Object.assign(this, { sheet, stage, plots, arrays });
    this.fields = [...sheet.fields, sheet.displacementField()];
    const usual = run.kind === "modal" ? "displacement" : sheet.fields[0]?.name ?? "";
    for (const { name, label } of this.fields) at("field").add(new Option(label, name));
    at("field").add(new Option("none: two sides", ""));
    at("field").value = usual;
    this.addProbes();
    this.player = new Player(sheet.times, (frame) => this.show(frame));
    this.connect();
    this.colourLines();
    if (run.kind === "modal") this.addModes();
    if (run.kind === "static" || !run.done) this.player.show(this.player.last);
    else if (run.kind === "dynamic") this.player.seek((sheet.times[0] + sheet.times.at(-1)) / 2); // the stowed sheet shows little
    stage.fit(stage.motion(), HOME);
  }

  get field() {
    return this.fields.find(({ name }) => name === at("field").value) ?? null;
  }

  show(frame = this.player?.frame ?? 0) {
    const { sheet, stage } = this;
    const before = at("follow").checked && sheet.frame >= 0 ? sheet.centre() : null;
    sheet.show(frame, this.field);
    if (before) stage.shift(sheet.centre().sub(before));
    const limits = this.limits();
    sheet.colourBy(this.field, limits);
    this.legend(limits);
    at("clock").textContent = this.clock(frame);
    at("time").setAttribute("aria-valuetext", this.clock(frame));
    if (run.kind !== "modal") this.plots.mark(sheet.times[frame]);
    at("reading").hidden = true;
    stage.draw();
  }

  limits() {
    const { field } = this;
    if (field === null) return [0, 1];
    const kind = at("range").value;
    if (kind === "frame") return this.sheet.extremes();
    return kind === "all" ? [field.least, field.largest] : [field.low, field.high];
  }

  clock(frame) {
    const time = this.sheet.times[frame];
    if (run.kind === "static") return `load factor ${time.toFixed(3)}`;
    if (run.kind === "dynamic") return `${time.toFixed(Math.max(0, 3 - Math.floor(Math.log10(run.end))))} s`;
    const mode = Math.min(Math.floor(time + 1e-9), run.frequencies.length - 1);
    const phase = Math.round(360 * (time - mode)) % 360;
    return run.frequencies.length ? `mode ${mode + 1} · ${this.frequency(mode)} · ${phase}°` : "";
  }

  frequency(mode) {
    const value = run.frequencies[mode];
    return value < 0 ? `grows at ${short(-2 * Math.PI * value, 5)} 1/s` : `${short(value, 5)} Hz`;
  }

  legend([low, high]) {
    const { field } = this;
    const box = at("legend");
    box.replaceChildren();
    box.hidden = at("draw").value === "creases";
    const add = (parent, kind, className, text = "") => {
      const element = document.createElement(kind);
      element.className = className;
      element.textContent = text;
      parent.append(element);
      return element;
    };
    if (field === null || field.name === "state") {
      const shares = field === null ? null : this.shares();
      for (const [name, colour] of field === null ? SIDES : STATES) {
        const row = add(box, "div", "key");
        add(row, "i", "").style.background = colour;
        row.append(shares ? `${name} ${(100 * shares[name]).toFixed(0)} %` : name);
      }
      return;
    }
    const { factor, unit } = scaled(Math.max(Math.abs(low), Math.abs(high)), field.unit);
    add(box, "div", "name", unit ? `${field.label} (${unit})` : field.label);
    const bar = add(box, "div", "bar");
    bar.style.setProperty("--colours", VIRIDIS.map((hex) => `#${hex}`).join(","));
    for (const value of ticks(low / factor, high / factor)) {
      const place = high > low ? (100 * (value * factor - low)) / (high - low) : 0;
      add(bar, "span", "tick", short(value, 3)).style.setProperty("--place", `${place}%`);
    }
    const [least, largest] = this.sheet.extremes();
    add(box, "div", "ends", `now ${short(least / factor, 3)} to ${short(largest / factor, 3)}`);
  }

  // Shares of the area that are slack, wrinkled and taut now, from history.csv; null if they are not known.
  shares() {
    const row = this.rowAt("history");
    if (row === null || run.kind === "modal") return null;
    const { columns, rows } = run.tables.history;
    const entries = STATES.map(([name]) => [name, columns.indexOf(name)]);
    if (entries.some(([, column]) => column < 1)) return null;
    return Object.fromEntries(entries.map(([name, column]) => [name, this.arrays.history.values[(column - 1) * rows + row]]));
  }

  // Number of the last row of a table that is not after the frame shown.
  rowAt(table) {
    const times = this.arrays[`${table} time`]?.values;
    if (!times?.length) return null;
    const time = this.sheet.times[this.sheet.frame] * (1 + 1e-9);
    let [low, high] = [0, times.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  addProbes() {
    const table = run.tables.probes;
    const names = new Set((table?.columns ?? []).slice(1).map((column) => column.replace(/\.[^.]*$/, "")));
    at("markers").closest("label").hidden = names.size === 0 || run.kind === "modal";
    if (run.kind === "modal") return;
    for (const name of names) {
      const columns = ["x", "y", "z"].map((axis) => table.columns.indexOf(`${name}.${axis}`) - 1);
      this.stage.addMarker(name, () => {
        const row = this.rowAt("probes");
        if (!at("markers").checked || at("shape").value === "flat" || row === null) return null;
        return new THREE.Vector3(...columns.map((column) => this.arrays.probes.values[column * table.rows + row]));
      });
    }
  }

  addModes() {
    const box = at("modes");
    box.hidden = run.frequencies.length === 0;
    const count = run.frequencies.length;
    const buttons = run.frequencies.map((_, mode) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(`mode ${mode + 1}`, document.createElement("br"), this.frequency(mode));
      button.addEventListener("click", () => choose(mode));
      box.append(button);
      return button;
    });
    const first = (mode) => this.sheet.times.findIndex((time) => time >= mode - 1e-9);
    const choose = (mode) => {
      buttons.forEach((button, k) => button.setAttribute("aria-pressed", k === mode));
      const playing = this.player.playing;
      const [from, to] = [first(mode), first(mode + 1)];
      this.player.restrict(from, Math.max(from, to));
      if (!playing) this.player.show(from + Math.round((to - from) / 4)); // the largest deflection
    };
    if (count) choose(0);
  }

  // Lines that stand out from what lies below them.
  colourLines() {
    const draw = at("draw").value;
    const alone = draw === "creases";
    const field = this.field;
    const onViridis = !alone && field !== null && field.name !== "state";
    const colour = alone ? css("--text") : onViridis ? "#ffffff" : "#1b2430";
    this.sheet.mesh.visible = !alone;
    const edge = onViridis ? "#a9b8c9" : colour; // seen on the sheet and beside it: layers that lie on each other keep their ends
    for (const [lines, line, opacity] of [[this.sheet.creases, colour, 0.9], [this.sheet.rim, edge, 0.8]]) {
      lines.visible = draw !== "sheet" && lines.userData.ends.length > 0;
      lines.material.color.set(line);
      lines.material.opacity = opacity;
    }
    this.stage.draw();
  }

  view(name) {
    const { stage } = this;
    const now = () => stage.motion(this.sheet.frame);
    const directions = { top: [0, -1e-3, 1], front: [0, -1, 0], side: [1, 0, 0] };
    if (name === "home") stage.fit(stage.motion(), HOME);
    else if (name === "fit") stage.fit(now());
    else if (name in directions) stage.fit(now(), directions[name]);
  }

  connect() {
    const { stage, sheet, player } = this;
    const changed = () => {
      this.colourLines();
      this.show();
    };
    for (const id of ["field", "range", "draw"]) at(id).addEventListener("change", changed);
    at("markers").addEventListener("change", () => stage.draw());
    at("shape").addEventListener("change", () => {
      sheet.shape = at("shape").value;
      stage.measureMotion();
      this.show();
      this.view(sheet.shape === "flat" ? "top" : "home");
    });
    at("view").addEventListener("change", () => {
      this.view(at("view").value);
      at("view").value = "";
    });
    at("picture").addEventListener("click", () => stage.savePicture(`${run.name} ${this.clock(sheet.frame)}.png`));
    document.addEventListener("keydown", (event) => this.key(event));

    let asked = null;
    stage.canvas.addEventListener("pointermove", (event) => {
      asked ??= requestAnimationFrame(() => {
        asked = null;
        this.read(event);
      });
    });
    stage.canvas.addEventListener("click", (event) => this.read(event)); // a finger does not hover
    stage.canvas.addEventListener("pointerleave", () => (at("reading").hidden = true));
  }

  read(event) {
    const box = at("reading");
    const found = event.buttons || this.player.playing ? null : this.stage.read(event);
    box.hidden = found === null;
    if (found === null) return;
    const { field } = this;
    const value = field === null ? "" : field.name === "state" ? STATES[Math.round(found.value)]?.[0] ?? "" : quantity(found.value, field.unit, 3);
    const [x, y] = found.flat.map((number) => quantity(number, "m", 4));
    box.textContent = `${value ? `${value} · ` : ""}flat x ${x}, y ${y}`;
    const frame = this.stage.box.getBoundingClientRect();
    box.style.left = `${Math.min(event.clientX - frame.left + 14, frame.width - box.offsetWidth - 8)}px`;
    box.style.top = `${event.clientY - frame.top + 16}px`;
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select, textarea, a, summary")) return;
    const button = event.target.closest("button, input[type=checkbox]");
    if (button && [" ", "Enter"].includes(event.key)) return; // they press it themselves
    const { player } = this;
    const many = event.shiftKey ? 10 : 1;
    const act = {
      " ": () => player.toggle(),
      ArrowRight: () => player.step(many),
      ArrowLeft: () => player.step(-many),
      Home: () => player.step(-Infinity),
      End: () => player.step(Infinity),
      f: () => this.view("fit"),
      c: () => {
        at("draw").value = at("draw").value === "creases" ? "both" : "creases";
        at("draw").dispatchEvent(new Event("change"));
      },
    }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }
}

// Says in the place of the picture why there is none.
function nothing(reason) {
  at("nothing").textContent = reason;
  at("nothing").hidden = false;
  at("animation").classList.add("empty");
}

async function start() {
  if (typeof DecompressionStream === "undefined") {
    nothing("This browser is too old for the animation and the plots (it cannot unpack data). The tables are below.");
    return;
  }
  const arrays = await unpacked();
  let animation = null;
  const plots = new Plots(arrays, (time) => run.kind !== "modal" && animation?.player.seek(time));
  plots.redraw();
  if (run.sheet === null) nothing("The animation of this run is missing or damaged.");
  else {
    try {
      const sheet = new Sheet(arrays);
      animation = new Animation(sheet, new Stage(sheet), plots, arrays);
    } catch (error) {
      if (!/WebGL/i.test(String(error))) throw error;
      nothing("This browser does not give the page 3D graphics (WebGL). The plots and tables are below.");
    }
  }
  const themed = (dark) => {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    plots.redraw();
    animation?.colourLines();
  };
  at("theme").addEventListener("click", () => themed(document.documentElement.dataset.theme !== "dark"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => themed(event.matches));
  window.report = { run, animation, plots }; // for the console, and for tests
  document.documentElement.dataset.ready = "yes";
}

start();
