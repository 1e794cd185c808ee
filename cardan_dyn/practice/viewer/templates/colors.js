// Colours with enough contrast, in the light and in the dark.

const BACKGROUNDS = { light: "#f0f4f9", dark: "#191e25" };
let theme = "light";

function channels(css) {
  return [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16) / 255);
}

function luminance(rgb) {
  const [red, green, blue] = rgb.map((value) =>
    value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

function contrast(first, second) {
  const [low, high] = [luminance(first), luminance(second)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
}

// The colour, moved to white or black as far as it takes to stand out from the background.
const known = new Map();
function legible(css, ratio, name = theme) {
  const key = `${css} ${ratio} ${name}`;
  if (!known.has(key)) {
    const ground = channels(BACKGROUNDS[name]), aim = name === "dark" ? 1 : 0;
    let rgb = channels(css);
    for (let step = 0; step < 40 && contrast(rgb, ground) < ratio; step++) {
      rgb = rgb.map((value) => value + 0.06 * (aim - value));
    }
    known.set(key, "#" + rgb.map((value) =>
      Math.round(255 * value).toString(16).padStart(2, "0")).join(""));
  }
  return known.get(key);
}

const TEXT = 4.7, INK = 3.2, BODY = 1.35, GLASS = 2.2;

// Gives an element its colour in the light and in the dark, of which the style sheet takes one.
function ink(element, css, ratio = INK) {
  for (const name of Object.keys(BACKGROUNDS)) {
    element.style.setProperty(`--${name}`, legible(css, ratio, name));
  }
  element.classList.add("inked");
  return element;
}
