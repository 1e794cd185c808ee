// The camera: it goes around a target, with z upwards, and is drawn only when something changed.

const canvas = byId("canvas");
const view = byId("view");
// Edges are smoothed by drawing more pixels than the window has: unlike by the means of WebGL, that
// can be left out while something moves, where it would halve the rate of frames without a GPU.
const renderer = new THREE.WebGLRenderer({
  canvas, antialias: false, alpha: true, powerPreference: "high-performance",
});
renderer.setClearColor(0, 0);
const size = { width: 1, height: 1 };
const FINE = 2, COARSEST = 0.6, SLOW = 38, MOST_PIXELS = 8e6, REST = 160;
const isSoftware = (() => {
  const context = renderer.getContext(), more = context.getExtension("WEBGL_debug_renderer_info");
  const name = more ? context.getParameter(more.UNMASKED_RENDERER_WEBGL) : "";
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
})();
const fine = () => Math.min(Math.max(window.devicePixelRatio || 1, FINE),
  Math.sqrt(MOST_PIXELS / (size.width * size.height)));
let motionSharpness = isSoftware ? 1 : FINE;    // pixels per pixel of the window while something moves
let drawnWith = 0, isTooSlow = false;
const orbit = { target: new THREE.Vector3(), distance: 1, azimuth: 0, elevation: 0 };
let touched = false, wanted = false, lastTime = 0;

const frames = { count: 0 };
function request() {
  if (!wanted) {
    wanted = true;
    requestAnimationFrame(frame);
  }
}

let rest = 0;
function frame(time) {
  wanted = false;
  setSharpness(Math.min(motionSharpness, fine()));
  useCoarse(isTooSlow);
  clearTimeout(rest);
  if (!playing) rest = setTimeout(settle, REST);
  if (playing) {
    step(Math.min(time - lastTime, 100) / 1000);
    pace(time - lastTime);
  }
  lastTime = time;
  drawNow();
  frames.count += 1;
  if (playing && onScreen) request();
}

// What nobody sees, such as a scene further down in a report, need not move.
let onScreen = true;
new IntersectionObserver((entries) => {
  onScreen = entries[entries.length - 1].isIntersecting;
  if (onScreen) request();
}).observe(canvas);

// Once nothing changes any more, all is drawn as finely as it can be.
function settle() {
  if (playing || drawnWith === fine()) return;
  setSharpness(fine());
  useCoarse(false);
  drawNow();
}

function drawNow() {
  pose(place);
  world.updateMatrixWorld();
  renderer.render(world, camera);
  layoutLabels();
}

// Fewer pixels while a slow machine plays, and fewer triangles if that does not help.
let slowFrames = 0;
function pace(milliseconds) {
  slowFrames = milliseconds > SLOW ? slowFrames + 1 : Math.max(0, slowFrames - 2);
  if (slowFrames <= 6) return;
  slowFrames = 0;
  if (motionSharpness > COARSEST) motionSharpness = Math.max(COARSEST, 0.75 * motionSharpness);
  else isTooSlow = true;
}
function setSharpness(value) {
  if (value === drawnWith) return;
  drawnWith = value;
  renderer.setPixelRatio(value);
  renderer.setSize(size.width, size.height, false);
}

const tangent = Math.tan(OPENING * Math.PI / 360);
function project(lens) {
  camera = lens;
  camera.add(...lights);
  byId("lens").setAttribute("aria-pressed", String(camera === parallel));
}

function towardsEye() {
  const { azimuth, elevation } = orbit, flat = Math.cos(elevation);
  return new THREE.Vector3(flat * Math.cos(azimuth), flat * Math.sin(azimuth), Math.sin(elevation));
}

// To the right and upwards, in the picture.
const axesOfView = () => [0, 1].map(
  (column) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, column));

function placeCamera() {
  const { distance, target } = orbit;
  const high = tangent * distance, wide = high * size.width / size.height;
  perspective.aspect = size.width / size.height;
  Object.assign(parallel, { left: -wide, right: wide, top: high, bottom: -high });
  camera.position.copy(towardsEye()).multiplyScalar(distance).add(target);
  camera.near = distance / 200 - (camera === parallel ? 50 * radius : 0);
  camera.far = distance * 50;
  camera.lookAt(target);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
  drawScales();
  drawTriad();
  request();
}

// Looks at a linkage whose joints lie in a plane along its normal, and else across the two longest
// extents of the scene, somewhat from above and from the side.
function bestDirection() {
  if (data.normal !== null) return VIEWS[["side", "front", "top"][data.normal]];
  const { x, y, z } = middle.getSize(new THREE.Vector3());
  if (z < 0.6 * Math.min(x, y)) return [-0.25, -0.55, 1];
  if (x < 0.6 * Math.min(y, z)) return [1, -0.5, 0.45];
  return [-0.35, -1, 0.62];
}
const VIEWS = {
  front: [0, -1, 0], side: [1, 0, 0], top: [0, -1e-4, 1], isometric: [1, -1, 0.8165],
};
function lookFrom(direction, lens) {
  project(lens);
  const at = new THREE.Vector3(...direction).normalize();
  orbit.azimuth = Math.atan2(at.y, at.x);
  orbit.elevation = Math.asin(at.z);
  fit();
}

// Moves the camera so far back that all points lie in the window, with a margin for the names.
function fit() {
  const back = towardsEye();
  const right = new THREE.Vector3(-Math.sin(orbit.azimuth), Math.cos(orbit.azimuth), 0);
  const up = back.clone().cross(right);
  // What buttons and scales cover is left free.
  const covered = byId("transport").offsetHeight + (size.width < 600 ? byId("scales").offsetHeight : 0);
  const top = 44, bottom = covered + 10;
  const high = Math.max(size.height - top - bottom, 60);
  const slopes = [
    tangent * 0.9 * size.width / size.height, tangent * 0.94 * high / size.height];
  // The point nearest to each edge decides; two of them fix shift and distance.
  const span = (axis, slope) => {
    let most = -Infinity, least = -Infinity;
    for (const point of points) {
      const across = point.dot(axis), depth = camera === parallel ? 0 : slope * point.dot(back);
      most = Math.max(most, across + depth);
      least = Math.max(least, -across + depth);
    }
    return { middle: (most - least) / 2, distance: (most + least) / (2 * slope) };
  };
  const [wide, tall] = [span(right, slopes[0]), span(up, slopes[1])];
  const reach = Math.max(wide.distance, tall.distance);
  const depth = middle.getCenter(new THREE.Vector3()).dot(back);
  orbit.distance = Math.max(reach - (camera === parallel ? 0 : depth), 1e-3 * radius);
  orbit.target.copy(right).multiplyScalar(wide.middle).addScaledVector(up, tall.middle)
    .addScaledVector(back, depth);
  // The middle of what is free is not the middle of the window.
  orbit.target.addScaledVector(up, tangent * orbit.distance * (top - bottom) / size.height);
  touched = false;
  placeCamera();
}

function resize() {
  size.width = Math.max(view.clientWidth, 1);
  size.height = Math.max(view.clientHeight, 1);
  drawnWith = 0;
  setSharpness(Math.min(motionSharpness, fine()));
  const covered = byId("transport").offsetHeight;
  byId("scales").style.bottom = `${covered + 6}px`;
  if (touched) placeCamera(); else fit();
  drawNow();
}

// Pixels per metre at the depth of the target.
function pixelsPerMetre() {
  return size.height / (2 * tangent * orbit.distance);
}

function turnBy(dx, dy) {
  touched = true;
  orbit.azimuth -= dx;
  const limit = Math.PI / 2 - 1e-4;
  orbit.elevation = Math.min(Math.max(orbit.elevation + dy, -limit), limit);
  placeCamera();
}
function shiftBy(dx, dy) {
  touched = true;
  const scale = 1 / pixelsPerMetre(), [right, up] = axesOfView();
  orbit.target.addScaledVector(right, -dx * scale).addScaledVector(up, dy * scale);
  placeCamera();
}
function zoomBy(factor) {
  touched = true;
  orbit.distance = Math.min(Math.max(orbit.distance * factor, 0.02 * radius), 100 * radius);
  placeCamera();
}

const pointers = new Map();
let travelled = 0;
canvas.addEventListener("pointerdown", (event) => {
  if (!pointers.size) travelled = 0;
  pointers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
  canvas.setPointerCapture(event.pointerId);
});
canvas.addEventListener("pointermove", (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const now = { x: event.offsetX, y: event.offsetY }, dx = now.x - before.x, dy = now.y - before.y;
  travelled += Math.hypot(dx, dy);
  if (pointers.size === 1) {
    if (travelled > 3) {
      if (event.buttons & 6 || event.shiftKey) shiftBy(dx, dy); else turnBy(dx * 0.008, dy * 0.008);
    }
  } else {
    const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const far = Math.hypot(before.x - other.x, before.y - other.y);
    zoomBy(far / Math.max(Math.hypot(now.x - other.x, now.y - other.y), 1));
    shiftBy(dx / 2, dy / 2);
  }
  pointers.set(event.pointerId, now);
});
canvas.addEventListener("pointerup", (event) => {
  if (pointers.size === 1 && travelled < 4 && event.button === 0) {
    const label = labelAt(event.offsetX, event.offsetY);
    select(label ? { joint: label.joint } : under(event.offsetX, event.offsetY));
  }
  pointers.delete(event.pointerId);
});
canvas.addEventListener("pointercancel", (event) => pointers.delete(event.pointerId));
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoomBy(Math.exp(Math.min(Math.max(event.deltaY, -200), 200) * 0.0015));
}, { passive: false });

// How long lengths and arrows are.
const scaleRows = [
  { unit: "m", per_metre: 1 }, ...data.scales,
].map((scale) => {
  const line = draw("svg", { width: 10, height: 10 }), text = make("span");
  const element = make("div", {}, line, text), { longest, unit } = scale;
  byId("scales").append(element);
  const cut = longest
    ? `; beyond ${toldUpTo(longest, unit, 3).full(longest)} arrows are cut` : "";
  return { ...scale, line, text, element, cut };
});
function drawScales() {
  const widest = Math.min(120, 0.28 * size.width), scale = pixelsPerMetre();
  for (const row of scaleRows) {
    const value = roundStep(widest / scale * row.per_metre, row.unit);
    const long = value / row.per_metre * scale;
    row.line.setAttribute("width", long.toFixed(1));
    row.line.replaceChildren();
    const path = row.kind
      ? `M0 5H${long}M${long - 6} 1.5L${long} 5L${long - 6} 8.5`
      : `M1 1V9M1 5H${long - 1}M${long - 1} 1V9`;
    draw("path", { d: path }, row.line);
    row.text.textContent = measured(value, row.unit) + row.cut;
    obstacles = null;
    row.element.hidden = row.kind && !ARROWS[row.kind].some((root) => {
      const arrows = nodes.get("/" + root);
      return arrows && arrows.visible && arrows.children.some(({ visible }) => visible);
    });
  }
}

// Where the axes of the world point.
const triadLines = ["x", "y", "z"].map((name, index) => {
  const parent = byId("triad");
  const color = ["#c62828", "#2e7d32", "#1565c0"][index];
  const line = ink(draw("line", { x1: 0, y1: 0 }, parent), color), text = draw("text", {}, parent);
  text.textContent = name;
  return { line, text, axis: new THREE.Vector3().setComponent(index, 1) };
});
function drawTriad() {
  const [right, up] = axesOfView();
  for (const { line, text, axis } of triadLines) {
    const x = 20 * axis.dot(right), y = -20 * axis.dot(up);
    line.setAttribute("x2", x.toFixed(1));
    line.setAttribute("y2", y.toFixed(1));
    const far = Math.hypot(x, y) || 1, beyond = (Math.max(far, 6) + 8) / far;
    text.setAttribute("x", (x * beyond).toFixed(1));
    text.setAttribute("y", (y * beyond + 4).toFixed(1));
    text.style.opacity = far < 3 ? 0 : 1;
  }
}
