// The viewer of mode shapes: bodies that turn and whirl, drawn by plotly in space. The axis of the
// engine lies along plotly's x, its x along plotly's y, its y upwards.
"use strict";
solidwhirl.modeViewer = (host, data, firstTheme) => {
  const SECTORS = 28, RING = 33, ZIGZAG = 7, TOO_SLOW = 250, TOO_FAST = 20;
  const WHIRL = {
    forward: { color: "@forward", dash: "solid", symbol: "circle", sign: "●" },
    backward: { color: "@backward", dash: "dash", symbol: "square-open", sign: "□" },
    straight: { color: "@straight", dash: "dot", symbol: "diamond-open", sign: "◇" },
    mixed: { color: "@mixed", dash: "dashdot", symbol: "diamond", sign: "◆" },
    torsional: { sign: "△" }, axial: { sign: "▷" }, coupled: { sign: "☆" }, disk: { sign: "◎" },
  };
  const BODY_COLORS = ["@c5", "@c4", "@c2", "@c3", "@c7", "@muted"];
  const VIEWS = [["cut open", "cut"], ["see-through", "clear"], ["closed", "closed"]];
  if (!data.turns) VIEWS.push(["lines only", "lines"]);
  const still = window.matchMedia("(prefers-reduced-motion: reduce)");
  const numbers = (value) => solidwhirl.array(value).values;

  // --- what does not change with the mode
  const { reach, joints } = data;
  const length = Math.max(reach.last - reach.first, 2 * reach.radius, 1e-6);
  const pieces = data.pieces.map((p) => ({
    ...p, points: numbers(p.points), cells: numbers(p.cells), color: BODY_COLORS[p.body % BODY_COLORS.length],
  }));
  const stations = {
    body: numbers(data.stations.body), z: numbers(data.stations.z), orbit: numbers(data.stations.orbit),
  };
  const lines = data.lines.map(numbers);
  const angles = Array.from({ length: SECTORS + 1 }, (_, s) => (2 * Math.PI * s) / SECTORS);
  const turns = Array.from({ length: RING }, (_, k) => (2 * Math.PI * k) / (RING - 1));

  // Points at rest of a piece as x, y, z of the engine, and its triangles.
  function mesh(piece, view) {
    if (piece.kind !== "meridian") {
      const count = piece.points.length / 3, copies = piece.copies || 1;
      const rest = [0, 1, 2].map(() => new Float32Array(count * copies));
      const use = [];
      for (let k = 0; k < copies; k++) {
        const turn = (2 * Math.PI * k) / copies, c1 = Math.cos(turn), s1 = Math.sin(turn);
        for (let p = 0; p < count; p++) {
          const [x, y, z] = piece.points.subarray(3 * p, 3 * p + 3), at = k * count + p;
          rest[0][at] = x * c1 - y * s1; rest[1][at] = x * s1 + y * c1; rest[2][at] = z;
        }
        for (let c = 0; c < piece.cells.length; c += 3) {
          const tri = piece.cells.subarray(c, c + 3).map((p) => p + k * count);
          const cut = view === "cut" && tri.every((p) => rest[0][p] < 1e-9 && rest[1][p] > -1e-9);
          if (!cut) use.push(tri);
        }
      }
      return { rest, i: use.map((t) => t[0]), j: use.map((t) => t[1]), k: use.map((t) => t[2]), theta: null };
    }
    const count = piece.points.length / 2;
    const open = view === "cut" && data.bodies.length + pieces.length > 1;
    const steps = open ? (3 * SECTORS) / 4 : SECTORS;
    // a quarter is left out between -x and +y, towards the eye
    const theta = angles.slice(0, steps + 1).map((a) => a + (open ? Math.PI : 0));
    const rest = [0, 1, 2].map(() => new Float32Array(count * theta.length));
    theta.forEach((a, s) => {
      for (let p = 0; p < count; p++) {
        const r = piece.points[2 * p + 1], at = s * count + p;
        rest[0][at] = r * Math.cos(a); rest[1][at] = r * Math.sin(a); rest[2][at] = piece.points[2 * p];
      }
    });
    const i = [], j = [], k = [];
    for (let s = 0; s < steps; s++) {
      for (let c = 0; c < piece.cells.length; c += 2) {
        const a = s * count + piece.cells[c], b = s * count + piece.cells[c + 1];
        i.push(a, a); j.push(b, b + count); k.push(b + count, a + count);
      }
    }
    return { rest, i, j, k, theta };
  }

  // --- motions of the chosen mode
  function unpacked(found) {
    const whole = new Int16Array(numbers(found.packed).buffer);
    return Float32Array.from(whole, (w) => w * found.scale);
  }
  // Real and imaginary part of the displacement of a piece's points at angle a (of a meridian).
  function ringMotion(terms, count, p, a, re, im) {
    re.fill(0); im.fill(0);
    const c1 = Math.cos(a), s1 = Math.sin(a);
    terms.order.forEach((n, t) => {
      const cos = Math.cos(n * a), sin = Math.sin(n * a);
      const along = n === 0 ? 1 : terms.family[t] === 0 ? cos : sin;
      const across = n === 0 ? 1 : terms.family[t] === 0 ? sin : -cos;
      const at = 6 * (t * count + p), v = terms.values;
      for (let part = 0; part < 2; part++) {
        const u = along * v[at + part], w = across * v[at + 2 + part], z = along * v[at + 4 + part];
        const out = part ? im : re;
        out[0] += u * c1 - w * s1; out[1] += u * s1 + w * c1; out[2] += z;
      }
    });
  }
  function fieldOf(piece, shape, terms) {
    const size = shape.rest[0].length;
    const re = [0, 1, 2].map(() => new Float32Array(size)), im = [0, 1, 2].map(() => new Float32Array(size));
    if (!terms.order.length) return { re, im };
    if (piece.kind === "solid") {
      terms.order.forEach((_, t) => {
        for (let p = 0; p < size; p++) for (let c = 0; c < 3; c++) {
          const at = 6 * (t * size + p) + 2 * c;
          re[c][p] += terms.values[at]; im[c][p] += terms.values[at + 1];
        }
      });
      return { re, im };
    }
    if (piece.kind === "sector") {
      // copy k turns the field of the sector by its angle, and shifts its phase by n times that
      const count = piece.points.length / 3, v = terms.values, n = terms.order[0];
      for (let at = 0; at < size; at++) {
        const k = Math.floor(at / count), p = 6 * (at - k * count), turn = (2 * Math.PI * k) / piece.copies;
        const c1 = Math.cos(turn), s1 = Math.sin(turn), cn = Math.cos(n * turn), sn = Math.sin(n * turn);
        const u = [0, 2, 4].map((c) => [v[p + c] * cn - v[p + c + 1] * sn, v[p + c] * sn + v[p + c + 1] * cn]);
        [re, im].forEach((out, part) => {
          out[0][at] = u[0][part] * c1 - u[1][part] * s1;
          out[1][at] = u[0][part] * s1 + u[1][part] * c1;
          out[2][at] = u[2][part];
        });
      }
      return { re, im };
    }
    const count = piece.points.length / 2, r3 = [0, 0, 0], i3 = [0, 0, 0];
    shape.theta.forEach((a, s) => {
      for (let p = 0; p < count; p++) {
        ringMotion(terms, count, p, a, r3, i3);
        for (let c = 0; c < 3; c++) { re[c][s * count + p] = r3[c]; im[c][s * count + p] = i3[c]; }
      }
    });
    return { re, im };
  }

  // --- the controls
  const make = (tag, props = {}, ...inside) => {
    const node = Object.assign(document.createElement(tag), props);
    node.append(...inside);
    return node;
  };
  const labelled = (text, input) => make("label", {}, text + " ", input);
  const stateList = make("select", { className: "viewer-state" });
  data.states.forEach((s, k) => stateList.append(make("option", { value: k, textContent: s.label })));
  const modeList = make("select", { className: "viewer-mode" });
  const viewList = make("select", { className: "viewer-view" });
  VIEWS.forEach(([text, value]) => viewList.append(make("option", { value, textContent: text })));
  const play = make("button", { type: "button", className: "viewer-play" });
  const pace = make("input", { type: "range", min: 0.1, max: 2, step: 0.05, value: 0.5, className: "viewer-pace" });
  const size = make("input", { type: "range", min: 0, max: 0.3, step: 0.005, value: 0.09, className: "viewer-size" });
  const check = (name) => make("input", { type: "checkbox", checked: true, className: "viewer-" + name });
  const wants = { orbits: check("orbits"), bearings: check("bearings"), names: check("names") };
  const isNarrow = host.clientWidth < 520;
  // names would cover a small picture
  wants.names.checked = !isNarrow;
  const bar = make("div", { className: "controls" },
    labelled("modes", stateList), labelled("mode", modeList), play, labelled("speed", pace),
    labelled("amplitude", size), labelled(data.turns ? "body" : "bodies", viewList),
    ...(data.turns ? [] : Object.entries(wants).map(([name, box]) => make("label", {}, box, " " + name))));
  if (data.turns) viewList.value = "closed";
  const key = make("p", { className: "caption viewer-key" });
  const plot = make("div", { className: "viewer-plot" });
  plot.style.width = "100%";
  const facts = make("p", { className: "viewer-facts" });
  facts.setAttribute("aria-live", "polite");
  host.replaceChildren(bar, plot, facts, key);

  let theme = firstTheme, playing = !still.matches, asked = false, onScreen = true, phase = 0, busy = false, last = 0, frame = 0;
  let mode = null, drawn = [], traces = [], alive = [], slow = 0;

  function fillModes() {
    const found = data.states[Number(stateList.value)].modes;
    modeList.replaceChildren(...found.map((m, k) => make("option", {
      value: k, textContent: (WHIRL[m.whirl]?.sign || "◇") + " " + m.label,
    })));
  }
  function choose() {
    const found = data.states[Number(stateList.value)].modes[Number(modeList.value)];
    mode = {
      ...found, center: unpacked(found.center),
      terms: found.terms.map((t) => ({ ...t, values: unpacked(t) })),
      // turns of the bodies per turn of the phase
      spin: data.bodies.map((b) => (found.hertz > 0 ? (b.ratio * found.rpm) / 60 / found.hertz : 0)),
    };
    const growth = found.growth > 1e-9 * found.hertz ? ", grows by itself" : "";
    facts.textContent = `${found.label}${found.rpm > 0 ? `, reference shaft at ${Math.round(found.rpm)} rpm` : ""}${growth}. ` +
      data.bodies.filter((b) => b.ratio !== 0 && found.rpm > 0)
        .map((b) => `${b.name} turns ${(b.ratio * found.rpm / 60 / found.hertz).toFixed(2)} times per period`).join("; ") +
      (found.rpm > 0 ? "." : "");
  }
  const scale = () => Number(size.value) * length;

  // Displacement of station s along x and y at the phase now.
  function centerNow(s, cos, sin) {
    const v = mode.center, at = 4 * s;
    return [v[at] * cos - v[at + 1] * sin, v[at + 2] * cos - v[at + 3] * sin];
  }
  const point = (out, z, x, y) => { out.x.push(z); out.y.push(x); out.z.push(y); };
  const gap = (out) => point(out, NaN, NaN, NaN);
  const empty = () => ({ x: [], y: [], z: [] });

  function centerLines(cos, sin) {
    const out = empty(), a = scale();
    for (const line of lines) {
      for (const s of line) {
        const [ux, uy] = centerNow(s, cos, sin);
        point(out, stations.z[s], a * ux, a * uy);
      }
      gap(out);
    }
    return out;
  }
  // A line along each body that turns with it; of bodies without a surface of revolution, spokes.
  function stripes(cos, sin) {
    const out = empty(), a = scale(), re = [0, 0, 0], im = [0, 0, 0];
    pieces.forEach((piece, n) => {
      const ratio = data.bodies[piece.body].ratio;
      if (ratio === 0 || mode.rpm === 0 || Math.abs(mode.spin[piece.body]) > TOO_FAST) return;
      const angle = mode.spin[piece.body] * phase, c1 = Math.cos(angle), s1 = Math.sin(angle);
      if (piece.kind !== "meridian") {
        const radius = reach.radius;
        for (const s of lines[piece.body].filter((s) => stations.orbit[s])) {
          const [ux, uy] = centerNow(s, cos, sin);
          point(out, stations.z[s], a * ux, a * uy);
          point(out, stations.z[s], a * ux + radius * c1, a * uy + radius * s1);
          gap(out);
        }
        return;
      }
      const count = piece.points.length / 2;
      for (let c = 0; c < piece.cells.length; c += 2) {
        for (const p of [piece.cells[c], piece.cells[c + 1]]) {
          ringMotion(mode.terms[n], count, p, angle, re, im);
          const u = re.map((v, k) => a * (v * cos - im[k] * sin));
          const r = 1.012 * piece.points[2 * p + 1];
          point(out, piece.points[2 * p] + u[2], r * c1 + u[0], r * s1 + u[1]);
        }
        gap(out);
      }
    });
    return out;
  }
  // Where the stations of one sense are at some phases.
  function orbitPoints(sense, phases) {
    const out = empty(), a = scale();
    mode.sense.forEach((found, s) => {
      if (found !== sense) return;
      for (const turn of phases) {
        const [ux, uy] = centerNow(s, Math.cos(turn), Math.sin(turn));
        point(out, stations.z[s], a * ux, a * uy);
      }
      if (phases.length > 1) gap(out);
    });
    return out;
  }
  // Springs along ±x and ±y from a body to what holds it.
  function springs(cos, sin) {
    const out = empty(), a = scale(), outside = 1.3 * reach.radius, half = 0.035 * length;
    for (const joint of joints) {
      const [s, t] = joint.ends;
      const [ux, uy] = centerNow(s, cos, sin), [vx, vy] = t === undefined ? [0, 0] : centerNow(t, cos, sin);
      const z = stations.z[s], end = t === undefined ? z : stations.z[t];
      const inner = joint.radii[0];
      const outer = t === undefined ? Math.max(outside, inner + 0.1 * length) : joint.radii[1];
      for (let k = 0; k < 4; k++) {
        const dx = [1, 0, -1, 0][k], dy = [0, 1, 0, -1][k];
        for (let n = 0; n <= ZIGZAG + 1; n++) {
          const part = n / (ZIGZAG + 1), wide = n === 0 || n > ZIGZAG ? 0 : (n % 2 ? 1 : -1) * 0.25 * half;
          const r = inner + part * (outer - inner);
          point(out, z + part * (end - z) + wide, a * (ux + part * (vx - ux)) + r * dx, a * (uy + part * (vy - uy)) + r * dy);
        }
        if (t === undefined) {  // the ground
          gap(out);
          for (const side of [-1, 1]) point(out, z + side * half, outer * dx, outer * dy);
        }
        gap(out);
      }
    }
    return out;
  }
  function labels() {
    const out = { ...empty(), text: [] };
    data.bodies.forEach((b, k) => {
      const own = lines[k];
      if (!own || !own.length) return;
      const s = own[Math.floor(own.length / 2)];
      const radii = pieces.filter((p) => p.body === k && p.kind === "meridian" && !p.disk).flatMap((p) =>
        Array.from(p.points.filter((_, at) => at % 2 === 1 && Math.abs(p.points[at - 1] - stations.z[s]) < 0.08 * length)));
      point(out, stations.z[s], 0, 0.03 * length + Math.max(0.03 * length, ...radii));
      out.text.push(b.name + (b.ratio === 0 ? " (does not turn)" : ""));
    });
    for (const joint of wants.bearings.checked ? joints : []) {
      const s = joint.ends[0];
      const outer = joint.ends.length > 1 ? joint.radii[1] : Math.max(1.3 * reach.radius, joint.radii[0] + 0.1 * length);
      point(out, stations.z[s], 0, -outer - 0.05 * length);
      out.text.push(joint.name);
    }
    return out;
  }
  // Points of a piece as plotly has them, at the phase now.
  function moved(entry, cos, sin) {
    const a = scale(), { rest } = entry.shape, { re, im } = entry.field;
    const put = (c) => rest[c].map((v, p) => v + a * (re[c][p] * cos - im[c][p] * sin));
    return { x: put(2), y: put(0), z: put(1) };
  }

  const lineOf = (color, dash, width) => ({ color, dash, width });
  function build() {
    const view = viewList.value, cos = Math.cos(phase), sin = Math.sin(phase);
    drawn = view === "lines" ? [] : pieces.map((piece, n) => {
      const shape = mesh(piece, view);
      return { piece, shape, field: fieldOf(piece, shape, mode.terms[n]) };
    });
    traces = []; alive = [];
    const add = (trace, now) => { traces.push(trace); if (now) alive.push([traces.length - 1, now]); };
    const thread = (now, name, line, more = {}) => add(
      { type: "scatter3d", mode: "lines", name, line, hoverinfo: "name", connectgaps: false, ...now(cos, sin), ...more }, now);
    for (const entry of drawn) {
      add({
        type: "mesh3d", ...moved(entry, cos, sin), i: entry.shape.i, j: entry.shape.j, k: entry.shape.k,
        color: entry.piece.color, opacity: view === "clear" ? 0.28 : 1, flatshading: false,
        name: data.bodies[entry.piece.body].name + (entry.piece.disk ? " (rigid disk)" : ""), hoverinfo: "name",
        lighting: { ambient: 0.62, diffuse: 0.6, specular: 0.12, roughness: 0.7, fresnel: 0.05 },
        lightposition: { x: -2000, y: 4000, z: 5000 },
      }, (c, s) => moved(entry, c, s));
    }
    if (!data.turns) thread(centerLines, "centre line", lineOf("@ink", "solid", 5));
    if (view !== "lines" && !data.turns) thread(stripes, "line that turns with the body", lineOf("@ink", "solid", 3));
    if (wants.bearings.checked && joints.length) thread(springs, "bearings", lineOf("@muted", "solid", 3));
    if (wants.orbits.checked) {
      for (const [sense, style] of Object.entries(WHIRL)) {
        if (!mode.sense.includes(sense)) continue;
        const name = sense === "straight" ? "orbit that is a line" : sense + " orbit";
        add({ type: "scatter3d", mode: "lines", name, line: lineOf(style.color, style.dash, 6), hoverinfo: "name",
          ...orbitPoints(sense, turns) });
        const dots = () => orbitPoints(sense, [phase]);
        add({
          type: "scatter3d", mode: "markers", name, hoverinfo: "name", ...dots(),
          marker: { color: style.color, symbol: style.symbol, size: isNarrow ? 4 : 6, line: { color: style.color, width: 1 } },
        }, dots);
      }
    }
    if (wants.names.checked && !data.turns) {
      add({ type: "scatter3d", mode: "text", ...labels(), textfont: { color: "@ink", size: isNarrow ? 10 : 12 }, hoverinfo: "skip" });
    }
  }
  function layoutNow() {
    const margin = 0.3 * length * 0.5;
    // room for bearings and the ground around the bodies, or for the motion alone
    const out = data.turns ? 1.1 * reach.radius : Math.max(1.45 * reach.radius, 0.16 * length) + 0.1 * length;
    const wide = data.turns ? reach.last - reach.first + 2 * margin : length + 2 * margin, middle = 0.5 * (reach.first + reach.last), hidden = { visible: false, showspikes: false };
    // what the camera sees at the distance of the axis, in units of plotly's cube
    const unit = Math.max(wide / (1.0 * plot.clientWidth / height()), (2 * out) / 1.04);
    return solidwhirl.layout({
      showlegend: false, margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: "kept",
      scene: {
        aspectmode: "manual",
        aspectratio: { x: wide / unit, y: (2 * out) / unit, z: (2 * out) / unit },
        xaxis: { ...(data.turns ? hidden : { title: { text: "z [m]" } }), range: [middle - 0.5 * wide, middle + 0.5 * wide], nticks: 6, showspikes: false, showgrid: false, zeroline: false },
        yaxis: { ...hidden, range: [-out, out] },
        zaxis: { ...hidden, range: [-out, out] },
        // blades are seen from the end of the axis, shafts from the side
        camera: { eye: data.turns ? { x: 1.15, y: -0.75, z: 0.45 } : { x: 0.55, y: -1.2, z: 0.5 }, projection: { type: "perspective" } },
      },
    }, theme);
  }
  const height = () => Math.max(340, Math.min(600, 0.62 * plot.clientWidth));
  const config = { ...solidwhirl.config, displayModeBar: false, scrollZoom: false };

  // A canvas that keeps its picture can be printed.
  async function keeping(drawing) {
    const own = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, options) {
      return own.call(this, kind, /webgl/.test(kind) ? { ...options, preserveDrawingBuffer: true } : options);
    };
    try { await drawing(); } finally { HTMLCanvasElement.prototype.getContext = own; }
  }
  async function redraw() {
    build();
    const layout = layoutNow();
    const kept = plot._fullLayout?.scene?.camera;
    if (kept) layout.scene.camera = kept;
    layout.height = height();
    plot.style.height = layout.height + "px";
    busy = true;
    try {
      await keeping(() => Plotly.react(plot, solidwhirl.tokens(traces, theme), layout, config));
      host.dataset.drawn = "yes";
      host.dataset.mode = mode.label;
    } finally { busy = false; }
  }
  async function step() {
    const cos = Math.cos(phase), sin = Math.sin(phase), x = [], y = [], z = [], at = [];
    for (const [index, now] of alive) {
      const p = now(cos, sin);
      x.push(p.x); y.push(p.y); z.push(p.z); at.push(index);
    }
    busy = true;
    try { await Plotly.restyle(plot, { x, y, z }, at); } finally { busy = false; }
    host.dataset.phase = phase.toFixed(3);
  }
  const nextFrame = () => new Promise((done) => requestAnimationFrame(done));
  // One frame, then at least as long a rest, which leaves the page the other half of the time.
  async function tick() {
    if (!playing || !onScreen) { frame = 0; return; }
    let rest = 30;
    if (!busy) {
      // a slow machine loses frames, not time; the time of a frame may lie before `last`
      const now = performance.now();
      phase += 2 * Math.PI * Number(pace.value) * Math.min(0.12, (now - last) / 1000);
      last = now;
      const before = performance.now();
      await step();
      // plotly draws in the frame that follows, and the next one waits for it
      await nextFrame();
      await nextFrame();
      rest = performance.now() - before;
      slow = rest > TOO_SLOW ? slow + 1 : 0;
      if (slow > 2 && !asked) {
        playing = false;
        facts.append(" This machine draws slowly: the motion stands still until you press play.");
        frame = 0;
        run();
        return;
      }
    }
    frame = setTimeout(() => { frame = requestAnimationFrame(tick); }, Math.max(0, rest - 34));
  }
  function run() {
    play.textContent = playing ? "❚❚ pause" : "▶ play";
    play.setAttribute("aria-pressed", String(playing));
    last = performance.now();
    if (playing && onScreen && !frame) frame = requestAnimationFrame(tick);
  }
  function writeKey() {
    const mark = (whirl, text) => make("span", {}, make("span", {
      textContent: WHIRL[whirl].sign, style: `color:var(--${WHIRL[whirl].color.slice(1)})`,
    }), " " + text);
    if (data.turns) {
      key.replaceChildren(mark("forward", "forward wave; "), mark("backward", "backward wave; "),
        mark("straight", "standing. Drag to turn the view, pinch or right-drag to shift it."));
      return;
    }
    key.replaceChildren(mark("forward", "forward orbit, full line; "), mark("backward", "backward orbit, broken line; "),
      mark("straight", "line, dotted. The thin line along a body turns with it (not drawn beyond 20 turns per period). Drag to turn the view, pinch or right-drag to shift it."));
  }

  const gl = make("canvas").getContext("webgl2") || make("canvas").getContext("webgl");
  if (!gl) {
    host.replaceChildren(make("p", { className: "box warning",
      textContent: "This browser draws nothing in space (WebGL is off). The chart of deflections below shows the same modes." }));
    host.style.minHeight = "0";
    host.dataset.drawn = "yes";
    return {};
  }
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  const later = () => { choose(); redraw(); };
  stateList.addEventListener("change", () => { fillModes(); later(); });
  modeList.addEventListener("change", later);
  for (const input of [viewList, ...Object.values(wants)]) input.addEventListener("change", redraw);
  size.addEventListener("input", () => { if (!busy) redraw(); });
  size.addEventListener("change", redraw);
  play.addEventListener("click", () => { playing = !playing; asked = playing; run(); });
  const moving = data.states.findIndex((s) => s.modes.some((m) => (m.rpm > 0 || data.turns) && (data.turns ? m.whirl !== "straight" : ["forward", "backward", "mixed"].includes(m.whirl))));
  stateList.value = Math.max(0, moving);
  fillModes();
  // the lowest forward whirl, which unbalance excites
  const chosen = data.states[Number(stateList.value)].modes;
  modeList.value = Math.max(0, chosen.findIndex((m) => m.whirl === "forward"));
  choose();
  writeKey();
  redraw().then(run);
  return {
    theme(next) { theme = next; redraw(); },
    pause() { onScreen = false; },
    resume() { if (!onScreen) { onScreen = true; run(); } },
  };
};
