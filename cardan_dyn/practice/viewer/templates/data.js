// The data of the page: what Python wrote, and numbers as people read them.

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);

const bytes = (() => {
  const text = atob(byId("arrays").textContent);
  const result = new Uint8Array(text.length);
  for (let index = 0; index < text.length; index++) result[index] = text.charCodeAt(index);
  return result.buffer;
})();

const KINDS = { f4: Float32Array, f8: Float64Array, u2: Uint16Array, u4: Uint32Array };

function array([at, count, kind]) {
  return new KINDS[kind](bytes, at, count);
}

const { told } = data, { course } = told;
for (const row of told.state) row.values = row.values ? array(row.values) : [row.value];
for (const name of ["values", "seconds"]) course[name] = course[name] && array(course[name]);
for (const { series } of told.joints) {
  for (const item of series) {
    item.values = array(item.values);
    [item.least, item.most] = extent(item.values);
    item.greatest = greatest(item.values);
  }
}
const count = course.values ? course.values.length : 1;

// The place in increasing or decreasing values at which they pass a value, as a fraction of samples;
// an end beyond them.
function placeOf(values, value) {
  const rises = values[values.length - 1] >= values[0];
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value === rises) low = middle; else high = middle;
  }
  const step = values[high] - values[low];
  return step ? Math.min(Math.max(low + (value - values[low]) / step, low), high) : low;
}

// The value at such a place; one alone is everywhere.
function valueAt(values, place) {
  if (values.length === 1) return values[0];
  const low = Math.min(Math.floor(place), values.length - 1), share = place - low;
  return share ? values[low] * (1 - share) + values[low + 1] * share : values[low];
}

function extent(values) {
  let least = Infinity, most = -Infinity;
  for (const value of values) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  return least <= most ? [least, most] : [0, 0];
}

// The greatest size of values.
function greatest(values) {
  return Math.max(...extent(values).map(Math.abs));
}

// A number with so many decimals; a true minus sign, and none before zero.
function written(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  let text = size >= 1e6 || (size > 0 && size < 1e-6 && decimals > 6)
    ? size.toExponential(3) : size.toFixed(decimals);
  if (value < 0 && Number(text) !== 0) text = "−" + text;
  return text;
}

function rounded(value) {
  const short = Number(value.toPrecision(4));
  return written(short, (String(short).split(".")[1] || "").length);
}

// By what numbers up to a size are divided to be short, and the unit of what comes out: kN, mm.
// The page tells some units otherwise than Python does: a factor, and the unit of what comes out.
const UNITS = { "rad/s": ["1/min", 30 / Math.PI], ...told.units };
const PREFIXES = { "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T" };
function prefixOf(size, given) {
  const [unit, factor] = UNITS[given] || [given, 1];
  if (!["N·m", "N", "m", "m/s", "s"].includes(unit) || !(size > 0)) return { scale: 1 / factor, unit };
  const digits = Math.floor(Math.log10(Number((size * factor).toPrecision(4))));
  const power = digits === -1 && !unit.startsWith("m") ? 0 : 3 * Math.floor(digits / 3);
  const within = Math.min(Math.max(power, -12), 12);
  return { scale: 10 ** within / factor, unit: PREFIXES[within] + unit };
}

// How numbers up to a greatest one are told: divided, with decimals for about so many digits.
function toldUpTo(greatest, given, digits = 4) {
  const { scale, unit } = prefixOf(greatest, given);
  const decimals = greatest > 0
    ? Math.min(Math.max(digits - 1 - Math.floor(Math.log10(greatest / scale)), 0), 9) : 0;
  const text = (value) => written(value / scale, decimals);
  return { scale, unit, text, full: (value) => withUnit(text(value), unit) };
}

// "12.3 N·m", "12.3°": no space before a degree sign.
function withUnit(text, unit) {
  return unit === "°" ? text + unit : unit ? `${text} ${unit}` : text;
}

// Two numbers in one unit.
function spanOf([low, high], given) {
  const told = toldUpTo(Math.max(-low, high), given);
  return `${told.text(low)} … ${told.full(high)}`;
}

// A number of four digits with the prefix of its unit.
function measured(value, unit) {
  const told = prefixOf(Math.abs(value), unit);
  return withUnit(rounded(value / told.scale), told.unit);
}

// The greatest of what is told as 1, 2, 5, 10, … that does not exceed a value.
function roundStep(value, unit) {
  const { scale } = prefixOf(value, unit), power = 10 ** Math.floor(Math.log10(value / scale) + 1e-9);
  return scale * power * [5, 2, 1].find((step) => step * power <= value / scale * (1 + 1e-9));
}

function make(kind, properties = {}, ...children) {
  const element = document.createElement(kind);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value; else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function draw(kind, properties = {}, parent = null) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
  for (const [name, value] of Object.entries(properties)) element.setAttribute(name, value);
  if (parent) parent.append(element);
  return element;
}
