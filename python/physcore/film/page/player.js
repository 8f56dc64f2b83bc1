// The page: plays, scrubs, turns and zooms. A share of the address such as #frame=12 opens at a frame, paused.
const root = document.getElementById("film"), at = selector => root.querySelector(selector);
const stage = at(".stage"), picture = at(".picture"), texts = at(".texts"), graph = at(".energy canvas");
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const css = ([red, green, blue, alpha = 255]) => `rgb(${red} ${green} ${blue} / ${alpha / 255})`;
const player = {film: null, drawing: null, position: 0, playing: false, speed: 1, way: 1, wait: 0, turned: [0, 0], last: 0, asked: false};

function redraw() { if (!player.asked) { player.asked = true; requestAnimationFrame(show); } }
function show(now) {
  player.asked = false;
  const {film, drawing} = player;
  if (player.playing) advance(Math.min((now - player.last) / 1000, 0.25));
  player.last = now;
  fit();
  drawing.draw(player.position);
  write();
  tell();
  curve();
  root.dataset.frame = Math.floor(player.position + 1e-6);
  root.dataset.drawn = Number(root.dataset.drawn || 0) + 1;
  if (player.playing && !document.hidden) redraw();
}
// A film lasts count / rate: each frame is shown for 1 / rate, and the last one for the hold too.
function advance(seconds) {
  const {film} = player, last = film.count - 1;
  if (last === 0) return;
  if (player.wait > 0) { player.wait -= seconds * player.speed; if (player.wait > 0) return; if (!film.bounce) player.position = 0; }
  player.position += player.way * seconds * player.speed * film.rate;
  if (player.position > last) {
    player.position = last;
    player.wait = film.hold + (film.bounce ? 0 : 1 / film.rate);
    if (film.bounce) player.way = -1;
  } else if (player.position < 0) { player.position = 0; player.way = 1; }
}
function fit() {
  const ratio = Math.min(window.devicePixelRatio || 1, 2), width = Math.max(1, Math.round(stage.clientWidth * ratio));
  const height = Math.max(1, Math.round(width * player.film.size[1] / player.film.size[0]));
  for (const canvas of [picture, texts]) if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
}
function write() {
  const {film, drawing} = player, pen = texts.getContext("2d"), ratio = texts.width / film.size[0], [factor, right, down] = drawing.zoom;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, texts.width, texts.height);
  const moved = factor !== 1 || drawing.turn !== STRAIGHT, deep = !film.panels[0].flat;
  if (deep && moved) return;
  pen.textBaseline = "top";
  for (const [words, x, y, height, color, align, wide] of film.texts[Math.min(Math.floor(player.position + 1e-6), film.texts.length - 1)] || []) {
    pen.font = `${0.74 * height * ratio}px system-ui, sans-serif`;
    pen.textAlign = ["left", "center", "right"][align + 1];
    pen.fillStyle = css(color);
    const place = [x, y].map((each, k) => (each - film.size[k] / 2) * factor + film.size[k] / 2 + [right, down][k]);
    pen.fillText(words, place[0] * ratio, (place[1] + 0.15 * height) * ratio, wide * ratio);
  }
}
function tell() {
  const {film} = player, frame = Math.floor(player.position + 1e-6), scrub = at(".scrub");
  scrub.value = frame;
  const line = film.lines[Math.min(frame, film.lines.length - 1)];
  at(".line").textContent = line;
  scrub.setAttribute("aria-valuetext", line || `frame ${frame + 1} of ${film.count}`);
  root.dataset.playing = player.playing;
  at(".play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
}
function play(on) { player.playing = on && player.film.count > 1; player.last = performance.now(); redraw(); }
function seek(frame) { player.position = clamp(frame, 0, player.film.count - 1); player.wait = 0; player.way = 1; redraw(); }
function step(frames) { play(false); seek(Math.floor(player.position + 1e-6) + frames); }

// The view: in 3D about the vertical of the scene and the horizontal of the picture.
function look(right, up) {
  const {film, drawing} = player;
  const axis = unit(film.panels[0].up), first = rotation(axis, right);
  player.turned = [player.turned[0] + right, player.turned[1] + up];
  drawing.turn = product(rotation([1, 0, 0], player.turned[1]), rotation(axis, player.turned[0]));
  changed();
}
function magnify(factor, x, y) {
  const {film, drawing} = player, [old, right, down] = drawing.zoom, zoom = clamp(old * factor, 1 / 3, 40), by = zoom / old;
  const from = [x - film.size[0] / 2, y - film.size[1] / 2];
  drawing.zoom = [zoom, from[0] - by * (from[0] - right), from[1] - by * (from[1] - down)];
  changed();
}
function shift(right, down) { const {drawing} = player; drawing.zoom = [drawing.zoom[0], drawing.zoom[1] + right, drawing.zoom[2] + down]; changed(); }
function home() { player.drawing.zoom = [1, 0, 0]; player.drawing.turn = STRAIGHT; player.turned = [0, 0]; changed(); }
function changed() {
  const {drawing} = player, moved = drawing.turn !== STRAIGHT || drawing.zoom.some((each, k) => each !== [1, 0, 0][k]);
  at(".home").hidden = !moved;
  stage.classList.toggle("moved", moved);
  redraw();
}
function place(event) { const box = picture.getBoundingClientRect(), ratio = player.film.size[0] / box.width; return [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio]; }
function hands() {
  const fingers = new Map(), turns = !player.film.panels[0].flat;
  stage.classList.toggle("turns", turns);
  picture.addEventListener("pointerdown", event => {
    if (!turns && event.pointerType === "touch" && !stage.classList.contains("moved")) return;
    picture.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, place(event));
    stage.classList.add("held");
    event.preventDefault();
  });
  picture.addEventListener("pointermove", event => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = place(event), way = [now[0] - before[0], now[1] - before[1]];
    fingers.set(event.pointerId, now);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1], length = a => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
      magnify(length(now) / length(before), other[0], other[1]);
    } else if (turns && !event.shiftKey && !(event.buttons & 2)) look(way[0] * 0.008, way[1] * 0.008);
    else shift(way[0], way[1]);
  });
  for (const kind of ["pointerup", "pointercancel"]) picture.addEventListener(kind, event => { fingers.delete(event.pointerId); stage.classList.toggle("held", fingers.size > 0); });
  picture.addEventListener("contextmenu", event => event.preventDefault());
  picture.addEventListener("dblclick", home);
  picture.addEventListener("wheel", event => { event.preventDefault(); magnify(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...place(event)); }, {passive: false});
  at(".hint").textContent = `${turns ? "Drag to turn, shift-drag to shift, scroll to zoom" : "Scroll to zoom, drag to shift"} · space, ← and →`;
}
function keys(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select")) return;
  const middle = player.film.size.map(each => each / 2), far = event.shiftKey ? 10 : 1;
  const act = {
    " ": () => event.target.matches("button") || play(!player.playing), ArrowLeft: () => step(-far), ArrowRight: () => step(far), Home: () => seek(0),
    End: () => seek(player.film.count - 1), "+": () => magnify(1.25, ...middle), "-": () => magnify(0.8, ...middle), 0: home, i: about,
  }[event.key];
  if (act && act() !== true) event.preventDefault();
}

// The curve of energy, with a line at the present frame.
const CURVES = [["kinetic", "--kinetic", 1.5], ["potential", "--potential", 1.5], ["internal", "--internal", 1.5], ["total", "--total", 2.25]];
const digits = value => { const size = Math.abs(value); return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : String(Number(value.toPrecision(3))); };
function curve() {
  const {film} = player;
  if (!film.energy.length) return;
  const ratio = window.devicePixelRatio || 1, width = graph.clientWidth, height = graph.clientHeight, style = getComputedStyle(root);
  if (graph.width !== Math.round(width * ratio)) { graph.width = Math.round(width * ratio); graph.height = Math.round(height * ratio); }
  const pen = graph.getContext("2d"), shown = curves(), values = shown.flatMap(([, , , row]) => row).filter(Number.isFinite);
  let low = Math.min(...values), high = Math.max(...values);
  if (!(high > low)) { high += 0.5 * (Math.abs(high) || 1); low -= 0.5 * (Math.abs(low) || 1); }
  const top = 16, foot = 16, x = frame => 1 + frame / Math.max(film.count - 1, 1) * (width - 2), y = value => top + (high - value) / (high - low) * (height - top - foot);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "11px system-ui, sans-serif";
  pen.fillStyle = style.getPropertyValue("--label");
  pen.strokeStyle = style.getPropertyValue("--line");
  pen.lineWidth = 1;
  for (const level of [low, high, ...(low < 0 && high > 0 ? [0] : [])]) { pen.beginPath(); pen.moveTo(0, y(level)); pen.lineTo(width, y(level)); pen.stroke(); }
  const unit = film.energy[0].unit ? ` ${film.energy[0].unit}` : "";
  pen.textBaseline = "bottom"; pen.fillText(digits(high) + unit, 0, top - 2);
  pen.textBaseline = "top"; pen.fillText(digits(low) + unit, 0, height - foot + 3);
  for (const [, color, wide, row, frames] of shown) {
    pen.beginPath();
    pen.strokeStyle = color.startsWith("--") ? style.getPropertyValue(color) : color; pen.lineWidth = wide; pen.lineJoin = "round";
    row.forEach((value, k) => k ? pen.lineTo(x(frames[k]), y(value)) : pen.moveTo(x(frames[k]), y(value)));
    pen.stroke();
  }
  pen.strokeStyle = style.getPropertyValue("--accent");
  pen.lineWidth = 1.5;
  pen.beginPath(); pen.moveTo(x(player.position), 0); pen.lineTo(x(player.position), height); pen.stroke();
}
// Of one panel all energies that are not always zero; of several the totals.
function curves() {
  const {energy} = player.film, hues = ["--kinetic", "--potential", "--internal", "--total"];
  if (energy.length > 1) return energy.map((panel, k) => [`total, ${player.film.names[k] || `panel ${k + 1}`}`, hues[k % 4], 1.75, panel.total, panel.frames]);
  return CURVES.filter(([name]) => energy[0][name].some(value => value !== 0)).map(([name, color, wide]) => [name, color, wide, energy[0][name], energy[0].frames]);
}
function surroundings() {
  const {film} = player;
  for (const [name, low, high, colors] of film.bars) {
    const part = document.createElement("span"), ramp = document.createElement("i");
    part.className = "bar";
    ramp.style.background = `linear-gradient(to right, ${colors.map(css).join(", ")})`;
    part.append(`${name} ${low}`, ramp, high);
    at(".bars").append(part);
  }
  for (const [name, color] of film.legend) {
    const entry = document.createElement("li"), mark = document.createElement("i");
    mark.style.background = css(color);
    entry.append(mark, name);
    at(".legend").append(entry);
  }
  at(".energy").hidden = film.energy.length === 0;
  if (film.energy.length) for (const [name, color] of curves()) {
    const key = document.createElement("span");
    key.textContent = `― ${name}`;
    key.style.color = `var(${color})`;
    at(".energy figcaption").append(key);
  }
  const drag = event => { if (event.buttons & 1) { const box = graph.getBoundingClientRect(); seek(Math.round((event.clientX - box.left - 1) / (box.width - 2) * (film.count - 1))); } };
  graph.addEventListener("pointerdown", event => { graph.setPointerCapture(event.pointerId); drag(event); });
  graph.addEventListener("pointermove", drag);
}
// A value of JSON in words: "kind AutoStep; safety 0.5".
function plain(value) {
  if (value === null || typeof value !== "object") return String(value);
  if (Array.isArray(value)) return value.map(plain).join(", ");
  return Object.entries(value).map(([name, each]) => [name.replaceAll("_", " "), plain(each)]).filter(([, words]) => words).map(parts => parts.join(" ")).join("; ");
}
function about() {
  const record = at(".record");
  record.hidden = !record.hidden;
  at(".about").setAttribute("aria-expanded", !record.hidden);
  if (record.children.length) return;
  for (const panel of JSON.parse(document.getElementById("provenance").textContent)) {
    const list = document.createElement("dl");
    for (const [name, value] of Object.entries(panel)) {
      const term = document.createElement("dt"), words = document.createElement("dd");
      term.textContent = name.replaceAll("_", " ");
      words.textContent = plain(value);
      list.append(term, words);
    }
    record.append(list);
  }
}
async function open() {
  at(".about").addEventListener("click", about);
  try {
    const [film, bytes] = await unpacked(document.getElementById("data").textContent);
    player.film = film;
    player.drawing = new Drawing(picture, film, bytes);
  } catch (error) {
    root.dataset.state = "gif";
    at(".trouble").hidden = false;
    at(".trouble").textContent = "This browser has no WebGL 2: some frames of the film are shown as a GIF.";
    console.warn(error);
    return;
  }
  stage.style.background = css(player.film.background);
  at(".scrub").max = player.film.count - 1;
  surroundings();
  hands();
  at(".play").addEventListener("click", () => play(!player.playing));
  at(".home").addEventListener("click", home);
  at(".scrub").addEventListener("input", event => { play(false); seek(Number(event.target.value)); });
  at(".speed").addEventListener("change", event => { player.speed = Number(event.target.value); });
  document.addEventListener("keydown", keys);
  document.addEventListener("visibilitychange", () => { player.last = performance.now(); redraw(); });
  new ResizeObserver(redraw).observe(stage);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  picture.addEventListener("webglcontextlost", () => location.reload());
  const chosen = /(?:^#|&)frame=(\d+)/.exec(location.hash), quiet = matchMedia("(prefers-reduced-motion: reduce)").matches;
  root.dataset.state = "ready";
  if (chosen) seek(Number(chosen[1])); else play(!quiet);
}
open();
