// The stage: nodes, objects and their poses, and which of them are shown.

const THREE = MeshCat.THREE;
const world = new THREE.Scene();
const nodes = new Map();        // path → object
const moving = [];              // nodes whose pose changes
const meshes = [];              // drawn objects

function node(path) {
  if (!nodes.has(path)) {
    const at = path.lastIndexOf("/"), parent = at > 0 ? node(path.slice(0, at)) : world;
    const object = new THREE.Group();
    object.userData.path = path;
    nodes.set(path, object);
    parent.add(object);
  }
  return nodes.get(path);
}

function geometryOf([vertices, faces]) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(array(vertices), 3));
  geometry.setIndex(new THREE.BufferAttribute(array(faces), 1));
  geometry.computeVertexNormals();
  return geometry;
}

const materials = new Map();
function materialOf({ color, opacity, layer, path }) {
  // Links have their own ones, as a chosen one glows.
  const key = [color, opacity, layer, ...path.split("/", 3)].join();
  if (!materials.has(key)) {
    const onTop = layer > 0;
    const material = new THREE.MeshLambertMaterial({
      opacity, transparent: opacity < 1 || onTop, depthTest: !onTop,
      depthWrite: opacity === 1 && !onTop,
      // Triangles of meshes may be turned either way.
      side: opacity === 1 && !onTop ? THREE.DoubleSide : THREE.FrontSide,
    });
    material.userData = { css: color, onTop };
    materials.set(key, material);
  }
  return materials.get(key);
}

for (const item of data.scene.nodes) {
  const object = node(item.path), tracks = [];
  for (const [name, width] of [["position", 3], ["quaternion", 4], ["scale", 3]]) {
    if (typeof item[name][2] === "string") {
      tracks.push({ target: object[name], values: array(item[name]), width });
      object[name].fromArray(tracks[tracks.length - 1].values);
    } else {
      object[name].fromArray(item[name]);
    }
  }
  if (tracks.length) moving.push({ object, tracks });
}
{
  const geometries = data.scene.shapes.map(geometryOf);
  for (const item of data.scene.objects) {
    const mesh = new THREE.Mesh(geometries[item.shape], materialOf(item));
    mesh.renderOrder = item.layer;
    mesh.matrixAutoUpdate = false;
    if (item.placement) mesh.matrix.fromArray(item.placement);
    mesh.userData.path = item.path;
    node(item.path).add(mesh);
    meshes.push(mesh);
  }
}

// Coarser meshes, for motion where a machine is too slow: all vertices in a cell are one of them.
const MOST_IN_MOTION = 36000, FINE_ENOUGH = 300;
function coarser(geometry, most) {
  const corners = geometry.index.array, { position } = geometry.attributes;
  const { min, max } = new THREE.Box3().setFromBufferAttribute(position);
  const long = Math.max(...max.sub(min).toArray()) || 1;
  let kept = corners;
  for (let cells = Math.sqrt(most) + 4; kept.length > 3 * most && cells > 2; cells *= 0.8) {
    const first = new Map(), same = new Uint32Array(position.count), at = new THREE.Vector3();
    for (let index = 0; index < position.count; index++) {
      const cell = at.fromBufferAttribute(position, index).sub(min).toArray()
        .reduce((key, along) => key * 1024 + Math.floor(along / long * cells), 0);
      if (!first.has(cell)) first.set(cell, index);
      same[index] = first.get(cell);
    }
    kept = [];
    for (let index = 0; index < corners.length; index += 3) {
      const triangle = [0, 1, 2].map((corner) => same[corners[index + corner]]);
      if (new Set(triangle).size === 3) kept.push(...triangle);
    }
  }
  const result = new THREE.BufferGeometry();
  result.setAttribute("position", position);
  result.setIndex([...kept]);
  result.computeVertexNormals();
  return result;
}

let isCoarse = false;
const fullOf = new Map();       // mesh → what is drawn at rest
const coarse = new Map();       // that → what is drawn in motion
function useCoarse(wished) {
  if (wished === isCoarse) return;
  isCoarse = wished;
  for (const mesh of meshes) fullOf.set(mesh, fullOf.get(mesh) || mesh.geometry);
  const all = [...fullOf.values()].reduce((sum, { index }) => sum + index.count / 3, 0);
  for (const [mesh, full] of fullOf) {
    if (!mesh.userData.path.startsWith("/mechanism/")) continue;
    const most = Math.max(MOST_IN_MOTION / all * full.index.count / 3, FINE_ENOUGH);
    if (!coarse.has(full)) coarse.set(full, coarser(full, most));
    mesh.geometry = wished ? coarse.get(full) : full;
  }
}

const WAYS = { 3: [new THREE.Vector3(), new THREE.Vector3()],
  4: [new THREE.Quaternion(), new THREE.Quaternion()] };
function pose(place) {
  const low = Math.min(Math.floor(place), Math.max(count - 2, 0)), share = place - low;
  for (const { tracks } of moving) {
    for (const { target, values, width } of tracks) {
      const start = low * width, [from, to] = WAYS[width];
      target.copy(from.fromArray(values, start));
      if (share) target[width === 4 ? "slerp" : "lerp"](to.fromArray(values, start + width), share);
    }
  }
}

// Light comes with the camera, so that what is looked at is lit, however great the scene is.
const OPENING = 32;     // angle of the view [°]; drawings, without it, are as large in the middle
const perspective = new THREE.PerspectiveCamera(OPENING, 1, 0.01, 100);
const parallel = new THREE.OrthographicCamera();
let camera = perspective;
const above = new THREE.DirectionalLight(0xffffff, 0.62);
const beside = new THREE.DirectionalLight(0xffffff, 0.2);
above.position.set(-0.4, 0.9, 1);
beside.position.set(1, -0.2, 0.5);
const lights = [above, above.target, beside, beside.target];
for (const lens of [perspective, parallel]) lens.up.set(0, 0, 1);
world.add(perspective, parallel, new THREE.HemisphereLight(0xffffff, 0xb9bec6, 0.52));

const radius = data.radius || 1;
const points = [], seen = array(data.points);
for (let at = 0; at < seen.length; at += 3) points.push(new THREE.Vector3().fromArray(seen, at));
const middle = new THREE.Box3().setFromPoints(points);
const grid = new THREE.Group();
world.add(grid);
const gridStep = roundStep(radius / 3, "m");
{
  const ends = [];
  const low = middle.min, high = middle.max, floor = low.z - 0.02 * radius;
  const start = (value) => Math.floor(value / gridStep) * gridStep;
  const end = (value) => Math.ceil(value / gridStep) * gridStep;
  const [left, right, near, far] = [start(low.x), end(high.x), start(low.y), end(high.y)];
  for (let x = left; x <= right + gridStep / 2; x += gridStep) ends.push(x, near, floor, x, far, floor);
  for (let y = near; y <= far + gridStep / 2; y += gridStep) ends.push(left, y, floor, right, y, floor);
  const lines = new THREE.BufferGeometry();
  lines.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
  grid.add(new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ transparent: true })));
}

function recolor() {
  for (const material of materials.values()) {
    const { css, onTop } = material.userData;
    material.color.set(legible(css, onTop ? INK : material.opacity < 1 ? GLASS : BODY));
    // Arrows shine by themselves, so that they have the colour that the panel tells.
    if (onTop) {
      material.emissive.copy(material.color).multiplyScalar(0.4);
      material.color.multiplyScalar(0.7);
    }
  }
  grid.children[0].material.color.set(theme === "dark" ? 0x4b5663 : 0xb4bec9);
}

// What of a scene can be switched: name, first steps of its paths, what it is called.
const PARTS = [
  ["shapes", ["mechanism", "bearings"], "Shapes"],
  ["moments", ["torsion", "bending"], "Moments"],
  ["forces", ["force", "axial", "shear"], "Forces"],
  ["loads", ["loads"], "Loads"],
  ["drive", ["drive"], "Drive"],
  ["axes", ["axes"], "Axes"],
  ["paths", ["paths"], "Paths of points"],
  ["traces", ["moment", "traces"], "Whole moments and their traces"],
  ["elements", ["elements"], "Force elements"],
  ["names", [], "Names"],
  ["numbers", [], "Numbers at arrows"],
  ["grid", [], `Grid of ${measured(gridStep, "m")}`],
].filter(([, roots]) => !roots.length || roots.some((root) => nodes.has("/" + root)));
const shown = Object.fromEntries(
  PARTS.map(([name]) => [name, !["traces", "grid"].includes(name)]));
// Arrows of one scale.
const ARROWS = { moment: ["torsion", "bending", "moment"], force: ["force", "axial", "shear"] };
const BY_JOINT = [...ARROWS.moment, ...ARROWS.force, "traces", "axes"];
const jointByNode = new Map(told.joints.map((item) => [item.node, item]));
const bearings = new Set(data.bearings);

const choice = { where: "bearings", joint: null, link: null };

// Whether the wrench and the name of a joint are shown.
function isShown(joint) {
  if (choice.joint === joint) return true;
  if (choice.link && [joint.parent, joint.child].includes(choice.link.body)) return true;
  if (choice.where === "all") return true;
  return choice.where === "bearings" && (bearings.has(joint.name) || loaded.has(joint.name));
}
const loads = told.state.filter((row) => row.kind === "load");
const loaded = new Set(loads.map((row) => row.joint));
const jointOfLoad = new Map(loads.map((row) => [row.node, row.joint]));
function jointNamed(name) {
  return told.joints.find((item) => item.name === name) || null;
}

function applyShown() {
  for (const [name, roots] of PARTS) {
    for (const root of roots) {
      const object = nodes.get("/" + root);
      if (!object) continue;
      object.visible = shown[name];
      if (!BY_JOINT.includes(root)) continue;
      for (const child of object.children) {
        const joint = jointByNode.get(child.userData.path.split("/")[2]);
        child.visible = !joint || isShown(joint);
      }
    }
  }
  grid.visible = shown.grid;
  drawScales();
}

// A chosen link glows.
function glow() {
  for (const { material, userData } of meshes) {
    const [, root, body] = userData.path.split("/");
    if (root !== "mechanism") continue;
    const chosen = choice.link && choice.link.body === body;
    material.emissive.set(!chosen ? 0 : theme === "dark" ? 0x2a5b9c : 0x4d86d6);
  }
}

// What is under a point of the window: a joint by one of its arrows or its axis, or else a link.
const ray = new THREE.Raycaster();
function under(x, y) {
  const seen = meshes.filter((mesh) => {
    for (let item = mesh; item; item = item.parent) if (!item.visible) return false;
    return true;
  });
  for (const [dx, dy] of [[0, 0], [4, 0], [-4, 0], [0, 4], [0, -4]]) {
    ray.setFromCamera(
      { x: 2 * (x + dx) / size.width - 1, y: 1 - 2 * (y + dy) / size.height }, camera);
    const hits = ray.intersectObjects(seen);
    hits.sort((a, b) => b.object.renderOrder - a.object.renderOrder || a.distance - b.distance);
    for (const { object } of hits) {
      const [, root, name] = object.userData.path.split("/");
      if (root === "mechanism") {
        if (dx || dy) break;
        const link = told.links.find((item) => item.body === name);
        if (link) return { link };
      }
      const joint = root === "loads" ? jointNamed(jointOfLoad.get(name)) : jointByNode.get(name);
      if (joint) return { joint };
    }
  }
  return {};
}
