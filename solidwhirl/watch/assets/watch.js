// Shows what comes over the connection, and sends the positions of the sliders.
"use strict";
(() => {
  const at = (id) => document.getElementById(id);
  const body = document.body;
  const AGAIN_MS = [200, 400, 800, 1500];
  const sliders = new Map(); // by name: what the server says, its inputs and its value
  let socket = null, tries = 0, doing = "", picture = null;

  function element(tag, properties = {}, ...inside) {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...inside);
    return made;
  }

  // -- connection --
  function connect() {
    socket = new WebSocket(new URL("socket", location.href.replace(/^http/, "ws")));
    socket.onopen = () => { tries = 0; body.classList.remove("lost"); showState(); };
    socket.onmessage = (event) => take(JSON.parse(event.data));
    socket.onclose = () => {
      body.classList.add("lost");
      showState();
      setTimeout(connect, AGAIN_MS[Math.min(tries++, AGAIN_MS.length - 1)]);
    };
  }
  function send(message) {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  }
  const takers = { source, doing: takeDoing, scene, drawing, problems, refused, picture: takePicture, written };
  function take(message) { takers[message.kind]?.(message); }

  function showState() {
    const state = at("state"), has = (name) => body.classList.contains(name);
    state.className = has("lost") ? "lost" : doing ? "busy" : "";
    if (has("lost")) state.textContent = "connection lost; trying again …";
    else if (doing) state.textContent = doing;
    else if (has("stale")) state.textContent = "the file can not be used";
    else if (!picture) state.textContent = "loading …";
    else state.textContent = picture.stage === "moving" ? `${(1e3 * picture.seconds).toFixed(0)} ms` : "up to date";
  }

  // -- what the server says --
  function source(message) {
    at("file").textContent = message.file;
    if (!picture) at("title").textContent = message.file.split("/").pop();
    at("name").hidden = !message.asks_name;
    at("write").textContent = message.asks_name ? "Write new file" : "Write to file";
  }
  function takeDoing(message) { doing = message.text; showState(); }
  function scene(message) {
    at("title").textContent = message.title;
    document.title = `${message.title} – solidwhirl watch`;
    const shape = JSON.stringify([message.sliders, message.fixed]);
    if (at("sliders").dataset.shape !== shape) {
      at("sliders").dataset.shape = shape;
      build(message);
    }
    moveTo(message.positions);
    at("remarks").replaceChildren(...message.remarks.map((text) => element("p", { className: "caption", textContent: text })));
  }
  function drawing(message) {
    at("picture").hidden = false;
    at("drawing").innerHTML = message.svg;
  }
  function problems(message) {
    body.classList.toggle("stale", message.problems.length > 0);
    at("problems").replaceChildren(...message.problems.map(problem));
    showState();
  }
  function refused(message) { at("refused").replaceChildren(...message.problems.map(problem)); }
  function problem(one) {
    const found = element("div", { className: "problem" });
    if (one.place) found.append(element("span", { className: "place", textContent: one.place }), " ");
    found.append(one.text);
    if (one.source) found.append(element("pre", { textContent: `${one.line} | ${one.source}` }));
    return found;
  }
  function written(message) {
    at("written").textContent = message.text;
    at("written").className = message.done ? "" : "bad";
  }
  function takePicture(message) {
    picture = message;
    at("picture").hidden = false;
    at("verdict").replaceChildren(...message.verdict.map((one) => {
      const line = element("p", { className: one.good === null ? "" : one.good ? "good" : "bad" });
      line.append(element("span", { className: "about", textContent: one.about }));
      line.insertAdjacentHTML("beforeend", one.text);
      return line;
    }));
    const level = at("level");
    level.textContent = message.preliminary ? `${message.level}, preliminary` : `level ${message.level}`;
    if (message.stage === "waiting" && !message.preliminary) level.textContent += ", error bands follow";
    level.classList.toggle("preliminary", message.preliminary);
    at("critical-speeds").innerHTML = message.critical_speeds;
    at("caption").innerHTML = message.caption;
    drawChart();
    // for who follows the page by a script
    Object.assign(at("picture").dataset, { stage: message.stage, level: message.level,
      preliminary: message.preliminary, positions: JSON.stringify(message.positions) });
    showState();
  }
  function drawChart() {
    if (!picture || !window.Plotly) return;
    const host = at("campbell");
    host.hidden = picture.chart === null;
    if (picture.chart) window.solidwhirl.show(host, picture.chart, controls(host, picture.chart.controls));
  }
  // Boxes over the chart; those that are there keep what is chosen.
  function controls(host, wanted) {
    const box = at("campbell-controls");
    const labels = JSON.stringify(wanted.map((control) => control.label));
    if (box.dataset.labels !== labels) {
      const before = new Map([...box.querySelectorAll("[name]")].map((i) => [i.name, i]));
      box.dataset.labels = labels;
      box.replaceChildren(...wanted.map((control) => {
        const name = control.label, old = before.get(name), redraw = () => window.solidwhirl.redraw(host);
        if (control.options) {
          const list = element("select", { name, onchange: redraw }, ...control.options.map((option, k) => element("option", { value: k, textContent: option.label })));
          if (old) list.value = old.value;
          return element("label", {}, `${name} `, list);
        }
        return element("label", {}, element("input", { type: "checkbox", name, onchange: redraw, checked: old ? old.checked : control.shown }), ` ${name}`);
      }));
    }
    return [...box.querySelectorAll("[name]")];
  }

  // -- sliders --
  const STEPS = 400;
  function place(s, value) {
    const part = s.is_log ? Math.log(value / s.low) / Math.log(s.high / s.low) : (value - s.low) / (s.high - s.low);
    return Math.round(STEPS * Math.min(1, Math.max(0, Number.isFinite(part) ? part : 0)));
  }
  function valueAt(s, step) {
    if (Number(step) === place(s, s.value)) return s.value;
    const part = step / STEPS;
    const value = s.is_log ? s.low * (s.high / s.low) ** part : s.low + part * (s.high - s.low);
    return Number(value.toPrecision(4));
  }
  function shown(value) {
    const size = Math.abs(value);
    if (size !== 0 && (size >= 1e6 || size < 1e-3)) return String(value.toExponential()).replace("e+", "e");
    return String(value);
  }
  function build(message) {
    sliders.clear();
    const groups = new Map();
    const group = (name) => {
      if (!groups.has(name)) groups.set(name, element("fieldset", { className: "group" }, element("legend", { textContent: name })));
      return groups.get(name);
    };
    for (const s of message.sliders) {
      const range = element("input", { type: "range", min: 0, max: STEPS, step: 1, id: `slider-${s.name}` });
      const number = element("input", { type: "number", step: "any" });
      range.dataset.name = number.dataset.name = s.name;
      range.setAttribute("aria-label", `${s.group}, ${s.label}`);
      number.setAttribute("aria-label", `${s.group}, ${s.label} as a number`);
      const label = element("label", { htmlFor: range.id }, `${s.label} `, element("span", { className: "unit", textContent: `[${s.unit}]` }));
      const row = element("div", { className: "slider" }, label, number, range);
      const own = { ...s, range, number, row, now: s.value };
      sliders.set(s.name, own);
      range.addEventListener("input", () => set(own, valueAt(own, range.value)));
      number.addEventListener("change", () => {
        const value = Number(number.value);
        set(own, number.value.trim() && Number.isFinite(value) ? value : own.now);
      });
      group(s.group).append(row);
    }
    for (const [name, text] of message.fixed) group(name).append(element("p", { textContent: text }));
    at("sliders").replaceChildren(...groups.values());
    if (!groups.size) at("sliders").append(element("p", { className: "caption", textContent: "This scene has no number to move." }));
  }
  function put(s, value) {
    s.now = value;
    s.number.value = shown(value);
    s.range.value = place(s, value);
    s.row.classList.toggle("moved", value !== s.value);
  }
  function set(s, value) {
    put(s, value);
    at("written").textContent = "";
    showButtons();
    sendPositions();
  }
  function moveTo(found) {
    for (const s of sliders.values()) put(s, found[s.name] ?? s.value);
    showButtons();
  }
  function moved() {
    return Object.fromEntries([...sliders.values()].filter((s) => s.now !== s.value).map((s) => [s.name, s.now]));
  }
  function showButtons() {
    const none = Object.keys(moved()).length === 0;
    at("write").disabled = at("reset").disabled = none;
  }
  function sendPositions() { send({ do: "move", positions: moved() }); }

  at("reset").addEventListener("click", () => { moveTo({}); at("written").textContent = ""; sendPositions(); });
  at("write").addEventListener("click", () => send({ do: "write", name: at("name").value }));
  at("library-script").addEventListener("load", drawChart);
  window.addEventListener("DOMContentLoaded", connect);
})();
