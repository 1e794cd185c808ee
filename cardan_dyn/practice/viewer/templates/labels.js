// Labels: names and numbers that neither cover each other nor are cut, with lines to what they mean.

const PLAIN = "#333333";     // the colour of names, which is that of all text
const LABEL_HEIGHT = 18, PADDING = 3, APART = 2;
const labelHost = byId("labels"), leaderHost = byId("leaders");
const labels = [];
const pen = document.createElement("canvas").getContext("2d");
const widths = new Map();

function widthOf(text) {
  // Digits stand as wide as each other in the page, and may not in the measure.
  const digits = text.replace(/[0-9]/g, "0");
  const font = `600 ${size.width < 600 ? 12 : 13}px system-ui, sans-serif`, key = font + digits;
  if (!widths.has(key)) {
    pen.font = font;
    widths.set(key, Math.ceil(pen.measureText(digits).width) + 2 * PADDING + 1);
  }
  return widths.get(key);
}

function addLabel(item) {
  const element = make("div"), line = draw("line", {}, leaderHost);
  if (item.color !== PLAIN) ink(element, item.color, TEXT);
  labelHost.append(element);
  labels.push({ ...item, element, line, box: null, last: 0 });
}

for (const { path, text, color } of data.scene.labels) {
  const joint = jointByNode.get(path.split("/")[2]) || null;
  addLabel({ joint, node: node(path), kind: "name", text, color });
}
for (const joint of told.joints) {
  // What is next to nothing beside the whole has no number.
  const whole = {};
  for (const { unit, greatest } of joint.series) {
    whole[unit] = Math.max(whole[unit] || 0, greatest);
  }
  for (const { name, values, unit, unique } of joint.series) {
    // Of joints without an axis, the whole moment is drawn as bending.
    const root = name === "moment" ? "bending" : name;
    if (!BY_JOINT.includes(root)) continue;
    const least = 0.004 * whole[unit], moment = unit !== "N";
    addNumber(`/${root}/${joint.node}`, values, unit, {
      joint, kind: "number", root, moment, unique, least,
    });
  }
}
for (const row of loads) {
  const joint = jointNamed(row.joint);
  addNumber(`/loads/${row.node}`, row.values, row.unit, { joint, kind: "load", unique: true, least: 0 });
}
function addNumber(path, values, unit, more) {
  const arrow = nodes.get(path), most = greatest(values);
  if (!arrow || !most) return;
  const color = arrow.children[0].material.userData.css;
  addLabel({ node: arrow, color, values, told: toldUpTo(most, unit, 3), ...more });
}

// Boxes of the window in which no label may be: buttons and scales.
let obstacles = null;
function measureObstacles() {
  const frame = view.getBoundingClientRect();
  obstacles = ["views", "triad", "scales", "transport"].map((id) => {
    const box = byId(id).getBoundingClientRect();
    return [box.left - frame.left, box.top - frame.top, box.right - frame.left,
      box.bottom - frame.top];
  });
}

// Where a label may stand about what it means: direction, and distance from it in pixels.
const DIRECTIONS = [[1, -1], [1, 1], [-1, -1], [-1, 1], [1, 0], [-1, 0], [0, -1], [0, 1]];
const DISTANCES = [5, 16, 30, 48, 70];
const CANDIDATES = DISTANCES.flatMap((far) => DIRECTIONS.map(([x, y]) => {
  const long = Math.hypot(x, y);
  return { x: far * x / long, y: far * y / long, sideX: x, sideY: y, far };
}));
const NEAR = { name: 16, number: 5, load: 5 };
const FAR = { name: 70, number: 30, load: 48 };

function boxAt(anchor, width, candidate) {
  const x = anchor.x + candidate.x, y = anchor.y + candidate.y;
  const left = Math.round(x + (candidate.sideX - 1) / 2 * width);
  const top = Math.round(y + (candidate.sideY - 1) / 2 * LABEL_HEIGHT);
  return [left, top, left + width, top + LABEL_HEIGHT];
}

function meets(first, second) {
  return first[0] < second[2] + APART && second[0] < first[2] + APART
    && first[1] < second[3] + APART && second[1] < first[3] + APART;
}

const tip = new THREE.Vector3(0, 0, 1);
const projected = new THREE.Vector3();
function anchorOf(label) {
  if (label.kind === "name") projected.setFromMatrixPosition(label.node.matrixWorld);
  else projected.copy(tip).applyMatrix4(label.node.matrixWorld);
  projected.project(camera);
  return {
    x: (projected.x + 1) * size.width / 2, y: (1 - projected.y) * size.height / 2,
    ahead: projected.z < 1,
  };
}

// Greater ones are placed first; the others make room, or are left out.
function rank(label) {
  const chosen = label.joint && choice.joint === label.joint ? 100 : 0;
  return chosen + { load: 40, name: 30, number: 20 }[label.kind]
    + (label.joint && bearings.has(label.joint.name) ? 5 : 0);
}

function isWanted(label) {
  if (label.kind === "name") return shown.names && (!label.joint || isShown(label.joint));
  if (label.kind === "load") return shown.loads && shown.numbers;
  if (!isShown(label.joint) || Math.abs(label.now) < label.least) return false;
  const chosen = choice.joint === label.joint;
  // Where there is little room, numbers are those of what is chosen.
  if (!(chosen || shown.numbers && size.width >= 600)) return false;
  return label.moment ? shown.moments : shown.forces;
}

function textOf(label) {
  if (label.kind === "name") return label.text;
  const text = label.told.full(label.now);
  const said = `${label.kind === "load" ? "load" : label.root} ${text}`;
  return label.unique ? said : `${said} *`;
}

function layoutLabels() {
  if (!obstacles) measureObstacles();
  const taken = obstacles.slice(), narrow = size.width < 600;
  for (const label of labels) {
    label.box = null;
    if (label.kind !== "name") label.now = valueAt(label.values, place);
  }
  for (const label of labels.filter(isWanted).sort((a, b) => rank(b) - rank(a))) {
    const anchor = anchorOf(label);
    if (!anchor.ahead || anchor.x < 0 || anchor.y < 0 || anchor.x > size.width
      || anchor.y > size.height) continue;
    const text = textOf(label), width = widthOf(text);
    const reach = FAR[label.kind] * (narrow ? 0.6 : 1);
    const free = (index) => {
      const candidate = CANDIDATES[index];
      if (candidate.far > reach || candidate.far < NEAR[label.kind]) return null;
      const box = boxAt(anchor, width, candidate);
      if (box[0] < 2 || box[1] < 2 || box[2] > size.width - 2 || box[3] > size.height - 2) return null;
      return taken.some((other) => meets(box, other)) ? null : box;
    };
    // Where it stood before, as long as it can: labels do not jump without need.
    let box = free(label.last);
    for (let index = 0; !box && index < CANDIDATES.length; index++) {
      box = free(index);
      if (box) label.last = index;
    }
    if (!box) continue;
    taken.push(box);
    show(label, text, width, box, anchor);
  }
  for (const { box, element, line } of labels) {
    element.hidden = !box;
    if (!box) line.style.display = "none";
  }
}

function show(label, text, width, box, anchor) {
  const { element, line } = label;
  if (label.written !== text) element.textContent = label.written = text;
  if (label.wide !== width) element.style.width = `${label.wide = width}px`;
  const chosen = label.joint && choice.joint === label.joint && label.kind === "name";
  element.classList.toggle("chosen", Boolean(chosen));
  element.style.transform = `translate(${box[0]}px, ${box[1]}px)`;
  label.box = box;
  const x = Math.min(Math.max(anchor.x, box[0]), box[2]);
  const y = Math.min(Math.max(anchor.y, box[1]), box[3]);
  const far = Math.hypot(x - anchor.x, y - anchor.y) > 9;
  line.style.display = far ? "" : "none";
  if (far) {
    line.setAttribute("x1", anchor.x.toFixed(1));
    line.setAttribute("y1", anchor.y.toFixed(1));
    line.setAttribute("x2", x.toFixed(1));
    line.setAttribute("y2", y.toFixed(1));
  }
}

function labelAt(x, y) {
  return labels.find(({ box, joint }) => box && joint
    && x >= box[0] && x <= box[2] && y >= box[1] && y <= box[3]);
}
