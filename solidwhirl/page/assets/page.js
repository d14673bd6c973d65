// Draws the charts of the page, applies their controls, and follows the colours that are chosen.
"use strict";
window.solidwhirl = (() => {
  const TOKENS = ["ink", "muted", "faint", "paper", "panel", "forward", "backward", "mixed",
    "straight", "band", "good", "bad", "c0", "c1", "c2", "c3", "c4", "c5", "c6", "c7"];
  const root = document.documentElement;
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const coarse = window.matchMedia("(pointer: coarse)");
  const narrow = () => window.innerWidth < 640;
  const charts = new Map();
  const viewers = new Map();

  function remembered() {
    try { return localStorage.getItem("solidwhirl-theme") || "auto"; } catch { return "auto"; }
  }
  function remember(name) {
    try { localStorage.setItem("solidwhirl-theme", name); } catch { /* a private window */ }
  }
  function readTheme() {
    const style = getComputedStyle(root);
    const theme = { dark: root.dataset.theme === "dark" };
    for (const name of TOKENS) theme[name] = style.getPropertyValue("--" + name).trim();
    return theme;
  }
  function setTheme(name) {
    root.dataset.theme = name === "auto" ? (dark.matches ? "dark" : "light") : name;
  }
  setTheme(remembered());

  const isPlain = (v) => v !== null && typeof v === "object" && !Array.isArray(v) && !ArrayBuffer.isView(v);

  // {dtype, shape, bdata} -> {values, shape}
  function array(value) {
    const bytes = Uint8Array.from(atob(value.bdata), (c) => c.charCodeAt(0));
    const values = value.dtype === "f4" ? new Float32Array(bytes.buffer) : new Int32Array(bytes.buffer);
    return { values, shape: value.shape };
  }
  function rows(values, shape) {
    if (shape.length < 2) return values;
    const step = values.length / Math.max(1, shape[0]);
    return Array.from({ length: shape[0] }, (_, k) =>
      rows(values.subarray(k * step, (k + 1) * step), shape.slice(1)));
  }
  function decoded(value) {
    if (Array.isArray(value)) return value.map(decoded);
    if (!isPlain(value)) return value;
    if (typeof value.bdata === "string") {
      const found = array(value);
      return rows(found.values, found.shape);
    }
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, decoded(v)]));
  }
  function withOpacity(color, opacity) {
    const n = parseInt(color.slice(1), 16);
    return `rgba(${n >> 16},${(n >> 8) & 255},${n & 255},${opacity})`;
  }
  function tokens(value, theme) {
    if (typeof value === "string") {
      if (value[0] !== "@") return value;
      const [name, opacity] = value.slice(1).split("/");
      if (!(name in theme)) return value;
      return opacity ? withOpacity(theme[name], opacity) : theme[name];
    }
    if (Array.isArray(value)) {
      return value.length && typeof value[0] === "number" ? value : value.map((v) => tokens(v, theme));
    }
    if (!isPlain(value)) return value;
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, tokens(v, theme)]));
  }
  function merged(first, second) {
    const out = { ...first };
    for (const [key, value] of Object.entries(second)) {
      out[key] = isPlain(value) && isPlain(out[key]) ? merged(out[key], value) : value;
    }
    return out;
  }
  // The page's layout with what a chart gives of its own.
  function layout(own, theme) {
    const axis = {
      automargin: true, gridcolor: theme.faint, linecolor: theme.muted, tickcolor: theme.muted,
      zerolinecolor: theme.faint, zeroline: false, showline: true, ticks: "outside", ticklen: 4,
      title: { standoff: 8 }, minexponent: 6, tickfont: { size: narrow() ? 11 : 12 }, exponentformat: "power",
    };
    const sceneAxis = {
      gridcolor: theme.faint, linecolor: theme.muted, zerolinecolor: theme.faint,
      showbackground: false, tickfont: { size: 10 }, color: theme.muted,
    };
    const base = {
      font: { family: getComputedStyle(document.body).fontFamily, size: narrow() ? 12 : 13, color: theme.ink },
      paper_bgcolor: theme.paper, plot_bgcolor: theme.paper, template: {},
      margin: { l: narrow() ? 48 : 64, r: 28, t: 12, b: 48 }, // r: half of the last label of x
      hovermode: "closest", hoverdistance: 24, separators: ".\u202f",
      hoverlabel: { bgcolor: theme.panel, bordercolor: theme.muted, font: { color: theme.ink } },
      legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)",
        font: { size: narrow() ? 11 : 12 } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: theme.muted, activecolor: theme.ink },
      dragmode: coarse.matches ? false : "zoom",
      uirevision: "kept", autosize: true,
    };
    const found = merged(base, tokens(own, theme));
    const keys = new Set(Object.keys(found).filter((k) => /^[xy]axis\d*$/.test(k)));
    for (const key of keys) found[key] = merged(axis, found[key]);
    for (const key of Object.keys(found).filter((k) => /^scene\d*$/.test(k))) {
      for (const name of ["xaxis", "yaxis", "zaxis"]) {
        found[key] = merged(found[key], { [name]: merged(sceneAxis, found[key][name] || {}) });
      }
      found.dragmode = "turntable";
    }
    return found;
  }
  const config = {
    displaylogo: false, responsive: true, scrollZoom: false,
    displayModeBar: coarse.matches || narrow() ? false : "hover",
    showSendToCloud: false, plotlyServerURL: "", // nothing leaves the page
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"],
  };

  function dataOf(name) {
    return JSON.parse(document.getElementById(name + "-data").textContent);
  }
  function nested(flat) {
    let out = {};
    for (const [path, value] of Object.entries(flat)) {
      const keys = path.split(".");
      out = merged(out, keys.reduceRight((inner, key) => ({ [key]: inner }), value));
    }
    return out;
  }
  // Which traces show, and what chosen options change in the layout.
  function state(chart) {
    const shown = chart.traces.map(() => true);
    let own = chart.layout;
    chart.controls.forEach((control, k) => {
      const input = chart.inputs[k];
      if (control.options) {
        const chosen = control.options[Number(input.value)];
        const mine = new Set(chosen.traces);
        for (const option of control.options) {
          for (const t of option.traces) if (!mine.has(t)) shown[t] = false;
        }
        own = merged(own, nested(chosen.layout));
      } else if (!input.checked) {
        for (const t of control.traces) shown[t] = false;
      }
    });
    return { shown, own };
  }
  // On a narrow screen the names of rows take several lines; returns the height that they add.
  function wrapRows(look) {
    const names = look.yaxis?.ticktext;
    if (!narrow() || !names) return 0;
    const wrapped = Array.from(names, (name) => name.replace(/(.{12,24}?)[ _](?=.)/g, "$1<br>"));
    look.yaxis = { ...look.yaxis, ticktext: wrapped, tickfont: { size: 10 } };
    const lines = Math.max(...wrapped.map((name) => name.split("<br>").length));
    return 9 * Math.max(0, lines - 2) * wrapped.length;
  }
  function legendRows(traces, width) {
    const named = traces.filter((t) => t.visible !== false && t.showlegend !== false && t.name);
    if (named.length < 2) return 0;
    const letters = Math.max(...named.map((t) => t.name.length));
    const columns = Math.max(1, Math.floor((width - 70) / (letters * 6.5 + 48)));
    return Math.ceil(named.length / columns);
  }
  // hatched bars keep their own colour under the hatching
  function hatched(trace) {
    const pattern = trace.marker?.pattern;
    if (!pattern || pattern.fillmode) return trace;
    return merged(trace, { marker: { pattern: { fillmode: "overlay" } } });
  }
  async function draw(chart) {
    const theme = readTheme();
    const { shown, own } = state(chart);
    const traces = chart.traces.map((t, k) => ({ ...hatched(tokens(t, theme)), ...(shown[k] ? {} : { visible: false }) }));
    const look = layout(own, theme);
    const legend = look.showlegend === false || own.legend ? 0 : legendRows(traces, chart.host.clientWidth);
    look.height = chart.height + wrapRows(look) + 19 * Math.max(0, legend - 1);
    chart.host.style.height = look.height + "px";
    const options = { ...config, toImageButtonOptions: { format: "svg", filename: chart.name } };
    chart.drawn = true;
    await Plotly.react(chart.host, traces, look, options);
    chart.host.dataset.drawn = "yes";
  }
  function prepare(host) {
    const data = decoded(dataOf(host.id));
    const box = document.querySelector(`.controls[data-for="${host.id}"]`);
    const chart = { name: host.id, host, drawn: false, ...data };
    chart.inputs = box ? [...box.querySelectorAll("[data-control]")] : [];
    for (const input of chart.inputs) input.addEventListener("change", () => draw(chart));
    return chart;
  }
  function chartOf(host) {
    if (!charts.has(host.id)) charts.set(host.id, prepare(host));
    return charts.get(host.id);
  }
  // Draws other data in a host, now; `inputs` are those of its controls.
  function show(host, data, inputs) {
    const chart = { name: host.id, host, drawn: false, ...decoded(data), inputs };
    charts.set(host.id, chart);
    return draw(chart);
  }
  function redraw(host) { return draw(charts.get(host.id)); }
  function drawOnce(host) {
    const chart = chartOf(host);
    return chart.drawn ? Promise.resolve() : draw(chart);
  }
  function viewerOnce(host) {
    if (!viewers.has(host.id)) {
      viewers.set(host.id, api.modeViewer(host, dataOf(host.id), readTheme()) || {});
    }
    return viewers.get(host.id);
  }
  function restyle() {
    for (const chart of charts.values()) if (chart.drawn) draw(chart);
    const theme = readTheme();
    for (const viewer of viewers.values()) viewer.theme?.(theme);
  }

  // The drawing library lies in the page compressed.
  async function loadLibrary() {
    const packed = document.getElementById("library");
    if (!packed) return;
    const bytes = Uint8Array.from(atob(packed.textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
    packed.remove();
  }
  function sayTooOld() {
    for (const host of document.querySelectorAll(".plot, .viewer")) {
      host.textContent = "This browser is too old to draw the chart; one of 2023 or later can.";
    }
  }

  async function start() {
    const select = document.getElementById("theme");
    select.value = remembered();
    select.addEventListener("change", () => { remember(select.value); setTheme(select.value); restyle(); });
    dark.addEventListener("change", () => { if (select.value === "auto") { setTheme("auto"); restyle(); } });
    document.getElementById("print").addEventListener("click", () => window.print());
    for (const button of document.querySelectorAll("button[data-print]")) {
      button.addEventListener("click", () => {
        const part = document.getElementById(button.dataset.print);
        part.classList.add("printed");
        root.classList.add("in-part");
        window.print();
      });
    }
    if (window.innerWidth < 960) document.getElementById("contents").open = false;

    followContents();
    try {
      await loadLibrary();
    } catch {
      sayTooOld();
      return;
    }

    const plots = [...document.querySelectorAll(".plot")];
    const hosts = [...document.querySelectorAll(".viewer")];
    const near = new IntersectionObserver((entries) => {
      for (const entry of entries) if (entry.isIntersecting) drawOnce(entry.target);
    }, { rootMargin: "400px" });
    plots.forEach((host) => near.observe(host));
    const seen = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (entry.isIntersecting) viewerOnce(entry.target).resume?.();
        else if (viewers.has(entry.target.id)) viewers.get(entry.target.id).pause?.();
      }
    }, { rootMargin: "50px" });
    hosts.forEach((host) => seen.observe(host));

    // what is far away is drawn when there is nothing else to do
    const later = window.requestIdleCallback || ((f) => setTimeout(f, 60));
    const waiting = plots.slice();
    const next = async () => {
      const host = waiting.shift();
      if (!host) { root.dataset.drawn = "all"; return; }
      await drawOnce(host);
      later(next);
    };
    later(next);

    // charts keep the width that they are drawn with: that of a sheet
    window.addEventListener("beforeprint", () => {
      root.dataset.theme = "light";
      root.classList.add("printing");
      plots.forEach((host) => draw(chartOf(host)));
      hosts.forEach((host) => viewerOnce(host).theme?.(readTheme()));
    });
    window.addEventListener("afterprint", () => {
      root.classList.remove("printing", "in-part");
      document.querySelector("section.printed")?.classList.remove("printed");
      setTheme(select.value);
      restyle();
    });
  }
  function followContents() {
    const links = new Map([...document.querySelectorAll("nav a")].map((a) => [a.hash.slice(1), a]));
    const watch = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        for (const a of links.values()) a.removeAttribute("aria-current");
        links.get(entry.target.id)?.setAttribute("aria-current", "true");
      }
    }, { rootMargin: "-15% 0px -75% 0px" });
    document.querySelectorAll("main > section").forEach((s) => watch.observe(s));
  }
  window.addEventListener("DOMContentLoaded", start);
  const api = { array, tokens, layout, config, show, redraw, theme: readTheme, modeViewer: () => ({}) };
  return api;
})();
