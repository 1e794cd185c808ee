// The panel: what moves, how fast, what is chosen and what is shown; keys and the pointer.

const slider = byId("slider"), output = byId("at"), playButton = byId("play");
let place = 0;              // among the samples, with fractions
let playing = false;
let speed = 1;              // of the duration that Python chose
const backwards = course.values && course.values[count - 1] < course.values[0];

// The state of the mechanism, in words.
const MOST_DRIVES = 4;
let drivesTold = 0, late = false;
const stateRows = told.state.map((row) => {
  const { values } = row, text = make("dd"), word = row.kind[0].toUpperCase() + row.kind.slice(1);
  // Of many drives the first ones are told at once, and the others if someone asks.
  if (row.kind !== "speed") late = row.kind === "drive" && ++drivesTold > MOST_DRIVES;
  byId(late ? "more-state" : "state").append(make("dt", {}, word), text);
  const upTo = toldUpTo(greatest(values), row.unit, 3);
  const name = row.kind === "speed" ? "" : row.name, moves = values.length > 1;
  const full = moves ? upTo.full : (value) => (
    row.kind === "held" && !value ? "at its zero" : measured(value, row.unit));
  return { values, text, moves, told: (value) => `${name} ${full(value)}`.trim() };
});
if (drivesTold > MOST_DRIVES) {
  byId("more").hidden = false;
  byId("more-title").textContent = `${drivesTold - MOST_DRIVES} more drives`;
}
function tellState(all) {
  for (const row of stateRows) {
    if (row.moves || all) row.text.textContent = row.told(valueAt(row.values, place));
  }
}

// Where the course is.
const courseRange = course.values ? extent(course.values) : [0, 1];
const along = toldUpTo(courseRange[1] - courseRange[0], course.unit, 3);
const seconds = course.seconds && course.name !== "time" ? course.seconds : null;
const passing = seconds && toldUpTo(seconds[count - 1], "s", 3);
let toldAt = "";
function tellPlace() {
  if (!course.values) return;
  const value = valueAt(course.values, place), text = along.full(value);
  slider.value = backwards ? -value : value;
  if (toldAt !== text) {
    toldAt = text;
    slider.setAttribute("aria-valuetext", `${course.name} ${text}`);
    output.replaceChildren(make("small", {}, course.name), " ", text);
    if (seconds) {
      output.append(" ", make("small", {}, passing.full(valueAt(seconds, place))));
    }
  }
  tellState(false);
  moveCursors();
}

function goTo(where) {
  place = where;
  tellPlace();
  request();
}

// Moves on by a time in front of the screen.
function step(passed) {
  const share = passed * speed / told.duration;
  if (course.seconds) {
    const whole = course.seconds[count - 1];
    place = placeOf(course.seconds, (valueAt(course.seconds, place) + share * whole) % whole);
  } else {
    const [first, last] = [course.values[0], course.values[count - 1]];
    const now = (valueAt(course.values, place) - first) / (last - first);
    place = placeOf(course.values, first + (now + share) % 1 * (last - first));
  }
  tellPlace();
}

function setPlaying(wished) {
  if (!course.values || playing === wished) return;
  playing = wished;
  lastTime = performance.now();
  playButton.textContent = playing ? "❚❚" : "▶";
  playButton.setAttribute("aria-label", playing ? "Pause" : "Play");
  request();
}
const pause = () => setPlaying(false);

function fillSpeeds() {
  const select = byId("speed"), whole = course.seconds ? course.seconds[count - 1] : 0;
  const real = whole ? told.duration / whole : 0;     // how fast real time is
  const short = (times) => rounded(Number(times.toPrecision(2)));
  const speeds = new Set([0.125, 0.25, 0.5, 1, 2, 4, 8, real || 1]);
  for (const value of [...speeds].sort((a, b) => a - b)) {
    const share = real ? value / real : 0;
    const text = !real ? `× ${value}` : Math.abs(share - 1) < 1e-9 ? "real time"
      : share < 1 ? `${short(1 / share)}× slower` : `${short(share)}× faster`;
    select.append(make("option", { value: String(value), textContent: text }));
  }
  select.value = "1";
  select.addEventListener("change", () => { speed = Number(select.value); });
}

// The list of joints and links.
const options = [];
function fillList() {
  const list = byId("list");
  for (const [title, items] of [["Joints", told.joints], ["Links", told.links]]) {
    if (!items.length) continue;
    const group = make("ul", { role: "group", "aria-label": title });
    for (const item of items) {
      const joint = title === "Joints";
      const id = `option-${options.length}`;
      const option = make("li", { role: "option", id, "aria-selected": "false" }, item.name);
      const star = joint && item.series.some((series) => !series.unique) ? " *" : "";
      option.append(make("span", {}, joint ? `${item.type}${star}` : "link"));
      const chosen = joint ? { joint: item } : { link: item };
      option.addEventListener("click", () => select(chosen));
      options.push({ option, chosen });
      group.append(option);
    }
    list.append(make("li", { role: "presentation" }, group));
  }
  list.addEventListener("keydown", (event) => {
    const at = options.findIndex(({ option }) => option.getAttribute("aria-selected") === "true");
    const to = { ArrowDown: at + 1, ArrowUp: at < 0 ? 0 : at - 1, Home: 0, End: options.length - 1 };
    if (!(event.key in to)) return;
    event.preventDefault();
    event.stopPropagation();
    select(options[Math.min(Math.max(to[event.key], 0), options.length - 1)].chosen);
  });
}

function select({ joint = null, link = null } = {}) {
  Object.assign(choice, { joint, link });
  for (const item of options) {
    const chosen = [joint, link].includes(item.chosen.joint || item.chosen.link);
    item.option.setAttribute("aria-selected", String(chosen));
    if (chosen) {
      byId("list").setAttribute("aria-activedescendant", item.option.id);
      reveal(item.option);
    }
  }
  if (!joint && !link) byId("list").removeAttribute("aria-activedescendant");
  tellChoice(joint, link);
  applyShown();
  glow();
  request();
}

// Scrolls the list alone, not the panel.
function reveal(option) {
  const list = byId("list"), box = option.getBoundingClientRect(), frame = list.getBoundingClientRect();
  if (box.top < frame.top) list.scrollTop -= frame.top - box.top;
  if (box.bottom > frame.bottom) list.scrollTop += box.bottom - frame.bottom;
}

function tellChoice(joint, link) {
  const details = byId("details"), chosen = joint || link;
  details.replaceChildren();
  byId("chosen-title").textContent = chosen ? chosen.name : "Nothing selected";
  byId("sign").textContent = "";
  if (joint) {
    const stroke = joint.stroke.length ? `, stroke ${spanOf(joint.stroke, "m")}` : "";
    details.append(make("p", {}, `Joint, ${joint.type}${joint.ends}${stroke}.`));
    if (joint.series.length) byId("sign").textContent = told.sign;
    if (joint.series.some((item) => !item.unique)) {
      details.append(make("p", {}, `* ${joint.open}`));
    }
  } else if (link) {
    details.append(make("p", {}, "Link with the joints"));
    for (const item of told.joints) {
      if ([item.parent, item.child].includes(link.body)) {
        const button = make("button", { type: "button" }, item.name);
        button.addEventListener("click", () => select({ joint: item }));
        details.append(button);
      }
    }
  } else {
    details.append(make("p", {}, "Click on a joint or a link, or choose one in the list."));
  }
  drawGraphs(joint);
  byId("told").textContent = chosen ? `${chosen.name} selected` : "";
}

// What is shown.
function fillParts() {
  for (const [name, roots, title] of PARTS) {
    const box = make("input", { type: "checkbox", checked: shown[name] });
    box.dataset.part = name;
    const text = make("span", {}, title);
    for (const item of data.legend.filter(({ part }) => roots.includes(part))) {
      const swatch = ink(make("i", { className: "swatch" }), item.color);
      text.append(make("small", {}, swatch, item.text));
    }
    box.addEventListener("change", () => {
      shown[name] = box.checked;
      applyShown();
      request();
    });
    byId("parts").append(make("li", {}, make("label", {}, box, text)));
  }
  byId("where").addEventListener("change", (event) => {
    choice.where = event.target.value;
    applyShown();
    request();
  });
  const all = told.joints.every((item) => bearings.has(item.name));
  byId("where-label").hidden = all || !told.joints.length;
}

// Light and dark: as the system has it, until someone chooses; pages that keep nothing ask again.
const THEME = "cardan-dyn theme";
function keptTheme(chosen) {
  try {
    if (chosen) localStorage.setItem(THEME, chosen);
    return localStorage.getItem(THEME);
  } catch {
    return chosen;
  }
}
const dark = window.matchMedia("(prefers-color-scheme: dark)");
function setTheme(name) {
  theme = name;
  document.documentElement.dataset.theme = name;
  byId("theme").setAttribute("aria-pressed", String(name === "dark"));
  recolor();
  glow();
  request();
}
let chosenTheme = keptTheme();
byId("theme").addEventListener("click", () => {
  chosenTheme = theme === "dark" ? "light" : "dark";
  keptTheme(chosenTheme);
  setTheme(chosenTheme);
});
const wishedTheme = () => chosenTheme || (dark.matches ? "dark" : "light");
dark.addEventListener("change", () => setTheme(wishedTheme()));

byId("fold").addEventListener("click", () => {
  const folded = document.body.classList.toggle("folded");
  byId("fold").setAttribute("aria-expanded", String(!folded));
  resize();
  if (!folded) select(choice);
});

byId("lens").addEventListener("click", () => {
  project(camera === parallel ? perspective : parallel);
  placeCamera();
});
for (const button of document.querySelectorAll("#views [data-view]")) {
  const direction = VIEWS[button.dataset.view];
  button.addEventListener("click", () => { if (direction) lookFrom(direction, parallel); else fit(); });
}

playButton.addEventListener("click", () => setPlaying(!playing));
slider.addEventListener("input", () => {
  pause();
  const value = Number(slider.value);
  goTo(placeOf(course.values, backwards ? -value : value));
});

// One hundredth of the course, or a degree of a turn.
function stepBy(steps) {
  if (!course.values) return;
  pause();
  const range = courseRange[1] - courseRange[0];
  const small = course.unit === "°" && range <= 720 ? 1 : range / 200;
  const now = valueAt(course.values, place) + (backwards ? -1 : 1) * steps * small;
  goTo(placeOf(course.values, now));
}

function nextJoint(by) {
  if (!told.joints.length) return;
  // Before the first one, or after the last one, where none is selected.
  const at = Math.max(told.joints.indexOf(choice.joint), by > 0 ? -1 : 0);
  select({ joint: told.joints.at((at + by) % told.joints.length) });
}

const KEYS = {
  ArrowRight: (many) => stepBy(many), ArrowLeft: (many) => stepBy(-many),
  Home: () => { pause(); goTo(0); }, End: () => { pause(); goTo(count - 1); },
  "+": () => zoomBy(0.85), "=": () => zoomBy(0.85), "-": () => zoomBy(1 / 0.85),
  n: () => nextJoint(1), p: () => nextJoint(-1), Escape: () => select(),
};
for (const button of document.querySelectorAll("[data-key]")) {
  KEYS[button.dataset.key] = () => button.click();
}
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const own = event.target.closest("button, select, input[type=checkbox], summary");
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  // A focused control keeps the keys that it understands itself.
  if (own && (key === " " || own.tagName === "SELECT")) return;
  if (!KEYS[key]) return;
  event.preventDefault();
  KEYS[key](event.shiftKey ? 10 : 1);
});

function start() {
  canvas.setAttribute("aria-label", `${data.title}, drawn in space`);
  byId("mode").textContent = told.mode;
  for (const note of data.notes) byId("notes").append(make("li", {}, note));
  fillParts();
  fillList();
  if (course.values) {
    const [least, most] = courseRange;
    slider.min = backwards ? -most : least;
    slider.max = backwards ? -least : most;
    slider.setAttribute("aria-label", `${course.name} in ${along.unit === "°" ? "degrees"
      : along.unit}`);
    slider.title = course.name;
    fillSpeeds();
  } else {
    for (const id of ["play", "slider", "at", "pace"]) byId(id).hidden = true;
  }
  if (!told.joints.length) byId("list").closest("section").hidden = byId("chosen").hidden = true;
  tellState(true);
  const load = ({ series }) => Math.max(
    ...series.map(({ greatest, unit }) => greatest / (unit === "N" ? 1 : radius)));
  const [joint = null] = told.joints.filter(({ series }) => series.length)
    .sort((one, other) => load(other) - load(one));
  select({ joint });
  setTheme(wishedTheme());
  tellPlace();
  lookFrom(bestDirection(), perspective);
  resize();
  new ResizeObserver(() => {
    if (view.clientWidth !== size.width || view.clientHeight !== size.height) resize();
  }).observe(view);
  if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) setPlaying(true);
}

// What tests and other scripts can ask of the page.
window.scene = {
  pause, frames,
  get playing() { return playing; },
  get place() { return place; },
  // Whether all is drawn as finely as it can be.
  get settled() { return !playing && !wanted && drawnWith === fine(); },
  // Shows the moment at a share of the course, at once, whatever was shown before.
  seek(share) {
    pause();
    for (const label of labels) label.last = 0;
    goTo(course.values ? placeOf(course.values,
      course.values[0] + share * (course.values[count - 1] - course.values[0])) : 0);
    drawNow();
  },
  labels: () => labels.filter(({ box }) => box)
    .map(({ box, element, kind }) => ({ box, text: element.textContent, kind })),
  node: (path) => nodes.get(path),
};
start();
