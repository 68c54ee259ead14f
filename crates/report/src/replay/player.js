// Time, controls and plots of a replay. Needs view3d.js before it.
(function () {
  const find = (id) => document.getElementById(id);
  const root = document.documentElement;
  const data = JSON.parse(find("data").textContent);
  const begin = data.times.length ? data.times[0] : 0;
  const end = data.times.length ? data.times[data.times.length - 1] : 0;
  const canvas = find("view"), slider = find("time"), play = find("play");
  let time = begin, playing = false, before = null, wanted = false;

  // Colours are the page's own, read anew when the theme changes.
  let palette = null;
  const readPalette = () => {
    const probe = document.createElement("span");
    document.body.append(probe);
    const colour = (name) => {
      probe.style.color = "var(--" + name + ")";
      const [r, g, b, a] = getComputedStyle(probe).color.match(/[\d.]+/g).map(Number);
      return [r / 255, g / 255, b / 255, a === undefined ? 1 : a];
    };
    palette = {};
    for (const name of ["robot", "object", "person", "surroundings", "ground", "line", "shadow", "paper"])
      palette[name] = colour("scene-" + name);
    probe.remove();
  };
  readPalette();

  const wantsDark = window.matchMedia("(prefers-color-scheme: dark)");
  const theme = find("theme");
  const isDark = () => (root.dataset.theme || (wantsDark.matches ? "dark" : "light")) === "dark";
  const named = () => {
    theme.textContent = isDark() ? "Light" : "Dark";
    theme.setAttribute("aria-label", "Switch to the " + (isDark() ? "light" : "dark") + " theme");
    readPalette();
    redraw();
  };
  theme.hidden = false;
  theme.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    named();
  });
  wantsDark.addEventListener("change", named);

  const motion = replay.makeMotion(data);
  const view = data.times.length ? replay.makeView(canvas, data, motion, () => palette) : null;
  for (const part of document.querySelectorAll("[data-script]")) part.hidden = false;
  if (!view) {
    find("stage").hidden = true;
    find("no-view").hidden = false;
    for (const part of document.querySelectorAll("[data-camera]")) part.hidden = true;
  } else {
    find("no-view").hidden = true;
  }

  // What each plot shows at a time: the last value at or before it.
  const plots = [...document.querySelectorAll("[data-signal]")].map((row) => ({
    value: row.querySelector(".now"),
    signal: data.signals[Number(row.dataset.signal)],
  }));
  const valueAt = (signal, at) => {
    let low = -1, high = signal.t.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (signal.t[middle] <= at + 1e-9) low = middle; else high = middle - 1;
    }
    const value = low < 0 ? null : signal.v[low];
    if (value === null) return "unknown";
    if (signal.names) return signal.names[value] || String(value);
    return String(Number(value.toPrecision(4))).replace("-", "\u2212") + (signal.unit ? " " + signal.unit : "");
  };
  const passed = (at) => {
    const marks = data.marks.filter((mark) => mark.time <= at + 1e-9);
    return marks.length ? marks[marks.length - 1] : null;
  };
  const clock = (at) => at.toFixed(2) + " s";
  const show = () => {
    const part = end > begin ? (time - begin) / (end - begin) : 0;
    root.style.setProperty("--at", part);
    slider.value = String(time);
    slider.setAttribute("aria-valuetext", clock(time) + " of " + clock(end));
    find("clock").textContent = clock(time);
    const mark = passed(time);
    const state = find("state");
    state.textContent = mark ? mark.text : "";
    state.className = mark ? "state " + mark.tone : "state";
    for (const plot of plots) plot.value.textContent = valueAt(plot.signal, time);
    if (view) view.draw(time);
  };
  function redraw() {
    if (wanted) return;
    wanted = true;
    requestAnimationFrame((now) => {
      wanted = false;
      if (playing) {
        time += before === null ? 0 : ((now - before) / 1000) * Number(find("speed").value);
        before = now;
        if (time >= end) {
          time = end;
          stop();
        } else redraw();
      }
      show();
    });
  }
  const stop = () => {
    playing = false;
    before = null;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  };
  const go = (to) => {
    time = Math.min(Math.max(to, begin), end);
    before = null;
    redraw();
  };
  play.addEventListener("click", () => {
    if (playing) return stop();
    if (time >= end) time = begin;
    playing = true;
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    redraw();
  });
  slider.addEventListener("input", () => go(Number(slider.value)));
  for (const mark of document.querySelectorAll("[data-go]"))
    mark.addEventListener("click", () => {
      stop();
      go(Number(mark.dataset.go));
    });
  for (const strip of document.querySelectorAll(".strip-box"))
    strip.addEventListener("pointerdown", (event) => {
      const frame = strip.getBoundingClientRect();
      go(begin + ((event.clientX - frame.left) / frame.width) * (end - begin));
    });

  if (view) {
    const turns = { left: [-0.15, 0], right: [0.15, 0], up: [0, 0.1], down: [0, -0.1] };
    const act = (name) => {
      if (turns[name]) view.turn(...turns[name]);
      else if (name === "nearer") view.zoom(0.85);
      else if (name === "farther") view.zoom(1 / 0.85);
      else {
        view.fit();
        view.followed = null;
        find("follow").value = "";
      }
      redraw();
    };
    for (const button of document.querySelectorAll("[data-act]"))
      button.addEventListener("click", () => act(button.dataset.act));
    find("follow").addEventListener("change", () => {
      view.followed = find("follow").value === "" ? null : Number(find("follow").value);
      redraw();
    });
    const keys = { ArrowLeft: "left", ArrowRight: "right", ArrowUp: "up", ArrowDown: "down", "+": "nearer", "=": "nearer", "-": "farther", "0": "fit" };
    canvas.addEventListener("keydown", (event) => {
      if (event.key === " ") play.click();
      else if (event.shiftKey && turns[keys[event.key]]) {
        const [right, up] = turns[keys[event.key]];
        view.shift(right / 3, up / 2);
        redraw();
      } else if (keys[event.key] && !event.ctrlKey && !event.metaKey) act(keys[event.key]);
      else return;
      event.preventDefault();
    });
    const held = new Map();
    let apart = 0;
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
      canvas.focus({ preventScroll: true });
      apart = 0;
    });
    const release = (event) => held.delete(event.pointerId);
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", (event) => {
      const last = held.get(event.pointerId);
      if (!last) return;
      const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
      held.set(event.pointerId, [event.clientX, event.clientY]);
      const wide = canvas.clientHeight;
      if (held.size > 1) {
        const [a, b] = [...held.values()];
        const now = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (apart > 0 && now > 0) view.zoom(apart / now);
        apart = now;
        view.shift(-dx / wide / 3, dy / wide / 3);
      } else if (event.shiftKey || event.buttons === 2 || event.buttons === 4) view.shift((-0.7 * dx) / wide, (0.7 * dy) / wide);
      else view.turn((3 * dx) / wide, (2 * dy) / wide);
      redraw();
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    // The page scrolls on until the view is chosen.
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      view.zoom(Math.exp(Math.sign(event.deltaY) * 0.12));
      redraw();
      event.preventDefault();
    }, { passive: false });
    canvas.addEventListener("webglcontextlost", () => {
      find("stage").hidden = true;
      find("no-view").hidden = false;
    });
  }
  new ResizeObserver(redraw).observe(canvas);
  named();
  const start = Number(find("data").dataset.start);
  go(Number.isFinite(start) ? start : begin);
})();
