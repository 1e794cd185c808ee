// Graphs: what the chosen joint carries over the course, with a cursor at what the scene shows.

const DASHES = ["none", "7 3", "3 3", "10 3 2 3"];
const HIGH = 118, LEFT = 46, RIGHT = 8, TOP = 8, BOTTOM = 20;
let graphs = [], rows = [];

// Round ticks in a range, about so many.
function ticks(low, high, about, unit) {
  const span = high - low || 1;
  const steps = unit === "°" ? [1, 2, 5, 10, 15, 30, 45, 90, 180, 360, 720, 1440, 3600] : null;
  const step = steps && span > 4 && span < 14400 ? steps.find((item) => span / item <= about)
    : [1, 2, 5, 10].map((item) => item * 10 ** Math.floor(Math.log10(span / about)))
      .find((item) => span / item <= about + 1e-9);
  const found = [];
  for (let value = Math.ceil(low / step - 1e-9) * step; value <= high + 1e-9 * span; value += step) {
    found.push(Math.abs(value) < 1e-9 * span ? 0 : value);
  }
  const decimals = Math.max(0, Math.min(9, -Math.floor(Math.log10(step) + 1e-9)));
  // Room is for some six signs: of 1.500e+9 it is 1.5e9.
  const short = (text) => text.replace(/\.?0*e\+?/, "e");
  return found.map((value) => ({ value, text: short(written(value, decimals)) }));
}

function drawGraphs(joint) {
  const host = byId("graphs");
  host.replaceChildren();
  graphs = [];
  rows = [];
  if (!joint) return;
  for (const unit of ["N·m", "N"]) {
    const drawn = merged(joint.series.filter((item) => item.unit === unit && item.greatest));
    if (!drawn.length) continue;
    const told = toldUpTo(Math.max(...drawn.map((item) => item.greatest)), unit);
    if (course.values) host.append(graphOf(joint, told, drawn));
    host.append(tableOf(unit, told, drawn));
  }
  if (!rows.length && joint.series.length) {
    host.append(make("p", {}, "This joint carries nothing."));
  }
  moveCursors();
}

// Curves that cover each other are one with both names, as the drive and the torsion of its joint.
function merged(series) {
  const kept = [];
  for (const item of series) {
    const same = kept.find(({ values }) => values.every(
      (value, index) => !(Math.abs(value - item.values[index]) > 1e-5 * item.greatest)));
    if (same) same.others.push(item); else kept.push({ ...item, others: [] });
  }
  return kept;
}

function nameOf(item) {
  return [item, ...item.others].map(({ name, unique }) => unique ? name : `${name} *`).join(", ");
}

function graphOf(joint, { scale, unit }, drawn) {
  const wide = Math.max(byId("graphs").clientWidth, 200), floor = HIGH - BOTTOM;
  const low = Math.min(0, ...drawn.map((item) => item.least));
  const high = Math.max(0, ...drawn.map((item) => item.most));
  const [first, last] = courseRange;
  const x = (value) => LEFT + (value - first) / (last - first) * (wide - LEFT - RIGHT);
  const y = (value) => floor - (value - low) / (high - low || 1) * (floor - TOP);
  const title = `${drawn.map(nameOf).join(", ")} of ${joint.name} in ${unit} over `
    + `${course.name} in ${along.unit}`;
  const svg = draw("svg", { viewBox: `0 0 ${wide} ${HIGH}`, height: HIGH, role: "img",
    "aria-label": title });
  draw("path", { class: "frame", d: `M${LEFT} ${TOP}V${floor}H${wide - RIGHT}` }, svg);
  for (const { value, text } of ticks(low / scale, high / scale, 5, unit)) {
    draw("text", { x: LEFT - 5, y: y(value * scale) + 4, "text-anchor": "end" }, svg).textContent = text;
    if (value === 0) draw("line", { class: "zero", x1: LEFT, x2: wide - RIGHT, y1: y(0), y2: y(0) }, svg);
  }
  const ends = [first, last].map((value) => value / along.scale);
  const letters = 2 + Math.max(...ends.map((value) => String(Math.round(value)).length));
  const below = ticks(...ends, Math.min(5, (wide - LEFT) / (8 * letters)), along.unit);
  below.forEach(({ value, text }, index) => {
    const unit = along.unit === "°" || index === below.length - 1 ? along.unit : "";
    const at = x(value * along.scale), anchor = at > wide - RIGHT - 16 ? "end" : "middle";
    draw("text", { x: anchor === "end" ? wide - 2 : at, y: HIGH - 6, "text-anchor": anchor },
      svg).textContent = withUnit(text, unit);
  });
  drawn.forEach((item, index) => {
    const dashes = DASHES[index % DASHES.length], d = curveOf(item.values, x, y);
    ink(draw("path", { class: "curve", d, "stroke-dasharray": dashes }, svg), item.color);
  });
  const cursor = draw("line", { class: "cursor", y1: TOP, y2: floor }, svg);
  const dots = drawn.map((item) => (
    { item, dot: ink(draw("circle", { r: 3.2 }, svg), item.color) }));
  const seek = (event) => {
    const box = svg.getBoundingClientRect();
    const share = ((event.clientX - box.left) * wide / box.width - LEFT) / (wide - LEFT - RIGHT);
    pause();
    goTo(placeOf(course.values, first + share * (last - first)));
  };
  svg.addEventListener("pointerdown", (event) => {
    svg.setPointerCapture(event.pointerId);
    seek(event);
  });
  svg.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) seek(event);
  });
  graphs.push({ cursor, dots, x, y });
  return svg;
}

// All samples that are shown, so that no peak is lost.
function curveOf(values, x, y) {
  const points = [];
  values.forEach((value, index) => {
    if (Number.isFinite(value)) {
      points.push(`${x(course.values[index]).toFixed(1)} ${y(value).toFixed(1)}`);
    }
  });
  return points.length ? "M" + points.join("L") : "";
}

function tableOf(unit, told, drawn) {
  const body = make("tbody");
  for (const item of drawn) {
    const value = make("td"), swatch = ink(make("i", { className: "swatch" }), item.color);
    const name = make("th", { scope: "row", title: item.means }, swatch, nameOf(item));
    const range = `${told.text(item.least)} … ${told.text(item.most)}`;
    body.append(make("tr", {}, name, value, make("td", {}, course.values ? range : "")));
    rows.push({ item, value, told });
  }
  const head = make("tr", {}, make("th", { scope: "col" }, unit === "N" ? "Force" : "Moment"),
    make("th", { scope: "col" }, told.unit), make("th", { scope: "col" }, course.values ? "range" : ""));
  return make("table", {}, make("thead", {}, head), body);
}

function moveCursors() {
  for (const { cursor, dots, x, y } of graphs) {
    const at = x(valueAt(course.values, place)).toFixed(1);
    cursor.setAttribute("x1", at);
    cursor.setAttribute("x2", at);
    for (const { item, dot } of dots) {
      const value = valueAt(item.values, place);
      dot.style.display = Number.isFinite(value) ? "" : "none";
      if (Number.isFinite(value)) {
        dot.setAttribute("cx", at);
        dot.setAttribute("cy", y(value).toFixed(1));
      }
    }
  }
  for (const { item, value, told } of rows) {
    value.textContent = told.text(valueAt(item.values, place));
  }
}
