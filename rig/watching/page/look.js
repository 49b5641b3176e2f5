// Colours of the page as its style has them, light or dark; and the watermark.

const COLOR = new Map();
let scheme = null;

export function color(name) {
  if (!COLOR.has(name)) {
    const style = getComputedStyle(document.documentElement);
    COLOR.set(name, style.getPropertyValue(`--${name}`).trim());
  }
  return COLOR.get(name);
}

export function forget() {
  COLOR.clear();
}

scheme = window.matchMedia("(prefers-color-scheme: dark)");
scheme.addEventListener("change", forget);

// Blue over green and yellow to red, for a value from 0 to 1.
export function tone(share) {
  const at = Math.min(Math.max(share, 0), 1);
  return `hsl(${Math.round(215 - 215 * at)} 80% ${Math.round(46 + 8 * Math.sin(Math.PI * at))}%)`;
}

// Make a canvas as fine as the screen; returns its context and size in CSS pixels.
export function prepare(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

// Every picture says by itself whether it is of a simulation.
export function watermark(context, width, height, text, size, strength = 0.09) {
  context.save();
  context.globalAlpha = strength;
  context.fillStyle = color("kind");
  context.font = `800 ${size}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.translate(width / 2, height / 2);
  context.rotate(-Math.min(0.35, Math.atan2(height, width) / 2));
  context.fillText(text, 0, 0);
  context.restore();
}
