"use strict";

/** Puts the page together: data and sound out of the file, controls, and the loop that draws. */
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);

function bytes(id) {
  const text = atob($(id).textContent);
  const out = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) out[k] = text.charCodeAt(k);
  $(id).textContent = "";
  return out;
}

async function unzipped(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

const player = new Player(new Blob([bytes("sound")], { type: $("sound").dataset.type }), data.start_s, data.end_s);
const tab = new Tab($("tab"), data, player);
let stage = null;

function element(name, text, parent) {
  const item = document.createElement(name);
  item.textContent = text;
  parent.append(item);
  return item;
}

function clock(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

// --- What the page says ---------------------------------------------------------------------
function fillDetails() {
  $("title").textContent = data.title;
  $("byline").textContent = data.byline;
  $("details-button").textContent = data.score;
  for (const [name, value] of data.metrics) {
    const row = element("tr", "", $("metrics"));
    element("td", name, row);
    element("td", value, row);
  }
  $("misses-title").textContent = data.misses.length ? "Missed" : "Nothing was missed";
  for (const [index, text] of data.misses) {
    const button = element("button", text, element("li", "", $("misses")));
    button.addEventListener("click", () => player.seek(data.notes[index][0] - 1));
  }
  data.fingers.names.forEach((name, k) => {
    const item = element("li", "", $("legend"));
    element("i", "", item).style.background = data.fingers.colours[k];
    item.append(name);
  });
  $("licences").textContent = $("licence-text").textContent;
}

// --- Controls -------------------------------------------------------------------------------
function barOptions() {
  const seen = {};
  data.bars.forEach(([, number], index) => {
    seen[number] = (seen[number] ?? 0) + 1;
    const label = seen[number] > 1 ? `${number} (again)` : String(number);
    for (const id of ["loop-from", "loop-to"]) element("option", label, $(id)).value = index;
  });
  $("loop-to").value = Math.min(3, data.bars.length - 1);
}

function setLoop(changed) {
  let from = Number($("loop-from").value), to = Number($("loop-to").value);
  if (to < from) {
    if (changed === "loop-to") from = to;
    else to = from;
    $("loop-from").value = from;
    $("loop-to").value = to;
  }
  const toS = to + 1 < data.bars.length ? data.bars[to + 1][0] : data.length_s;
  player.setLoop($("loop").checked ? { fromS: data.bars[from][0], toS } : null);
  drawMarks();
}

function step(bars) {
  const now = player.time + (bars < 0 ? -0.3 : 0.01);
  const at = data.bars.findLastIndex(([onset]) => onset <= now);
  const next = Math.min(Math.max(bars < 0 ? at : at + 1, 0), data.bars.length - 1);
  player.seek(data.bars[next][0]);
}

function faster(by) {
  const options = [...$("speed").options], now = $("speed").selectedIndex;
  $("speed").selectedIndex = Math.min(Math.max(now + by, 0), options.length - 1);
  player.speed = Number($("speed").value);
}

function toggleDetails() {
  $("details").hidden = !$("details").hidden;
  $("details-button").setAttribute("aria-expanded", String(!$("details").hidden));
}

function listen() {
  for (const id of ["play", "big-play"]) $(id).addEventListener("click", () => player.toggle());
  $("seek").min = data.start_s;
  $("seek").max = data.end_s;
  $("seek").addEventListener("input", () => player.seek(Number($("seek").value)));
  $("speed").addEventListener("change", () => (player.speed = Number($("speed").value)));
  $("volume").addEventListener("input", () => (player.audio.volume = Number($("volume").value)));
  for (const id of ["loop", "loop-from", "loop-to"]) $(id).addEventListener("change", () => setLoop(id));
  $("details-button").addEventListener("click", toggleDetails);
  window.addEventListener("resize", drawMarks);
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
    const onButton = event.target.tagName === "BUTTON" && event.key === " ";
    const actions = {
      " ": () => player.toggle(), ArrowLeft: () => step(-1), ArrowRight: () => step(1),
      "-": () => faster(-1), "+": () => faster(1), "=": () => faster(1), l: () => $("loop").click(),
    };
    stage?.views.forEach((name, k) => (actions[k + 1] = () => stage.view(name)));
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action || onButton) return;
    event.preventDefault();
    action();
  });
}

function addViews() {
  const show = (name) => {
    for (const button of $("views").children) button.setAttribute("aria-pressed", String(button.dataset.view === name));
  };
  for (const name of stage.views) {
    const button = element("button", name, $("views"));
    button.dataset.view = name;
    button.addEventListener("click", () => stage.view(name));
  }
  stage.onview = show;
  show(stage.viewName);
}

/** Misses and the loop under the slider. */
function drawMarks() {
  const canvas = $("marks"), pen = canvas.getContext("2d"), length = data.end_s - data.start_s;
  canvas.width = canvas.clientWidth;
  canvas.height = canvas.clientHeight;
  const x = (time) => ((time - data.start_s) / length) * canvas.width;
  pen.fillStyle = "#24272d";
  pen.fillRect(0, 6, canvas.width, 8);
  if (player.loop) {
    pen.fillStyle = "#e6c07b66";
    pen.fillRect(x(player.loop.fromS), 6, x(player.loop.toS) - x(player.loop.fromS), 8);
  }
  pen.fillStyle = "#f05c54";
  for (const [index] of data.misses) pen.fillRect(x(data.notes[index][0]) - 1, 4, 2, 12);
}

// --- Drawing --------------------------------------------------------------------------------
let before = 0;

function draw(now) {
  if (before) stage?.pace(now - before);
  before = now;
  player.tick();
  const time = player.time;
  tab.draw(time);
  if (document.activeElement !== $("seek") || player.playing) $("seek").value = time;
  $("time").textContent = `${clock(time)} / ${clock(data.length_s)}`;
  for (const id of ["play", "big-play"]) {
    $(id).textContent = player.playing ? "\u23F8\uFE0E" : "\u25B6\uFE0E";
    $(id).setAttribute("aria-label", player.playing ? "Pause" : "Play");
  }
  $("big-play").hidden = player.playing || player.audio.currentTime > 0;
  if (stage) {
    stage.setTime(time);
    stage.render();
  }
  window.requestAnimationFrame(draw);
}

async function open() {
  fillDetails();
  barOptions();
  listen();
  drawMarks();
  try {
    stage = await Stage.create($("stage"), await unzipped(bytes("scene")), data);
    addViews();
  } catch (error) {
    $("trouble").hidden = false;
    $("trouble").textContent = `The hands cannot be drawn in this browser (${error.message}). Sound and tablature work.`;
  }
  window.requestAnimationFrame(draw);
  window.roboguitarist = { data, player, stage, tab };
}

open();
