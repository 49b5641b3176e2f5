// The mechanism in three dimensions: points from the server, lines and balls drawn here.

import { color, prepare, tone, watermark } from "./look.js";

const NEAR = 3.2; // distance of the camera over the size of the scene
const KEPT = 6000;
const APART = 0.5; // s

export class Scene {
  constructor(canvas, legend) {
    this.canvas = canvas;
    this.legend = legend;
    this.frames = [];
    this.mark = "";
    this.describe({ shapes: [] });
    this.listen();
  }

  describe(scene) {
    this.scene = scene;
    this.shapes = scene.shapes ?? [];
    this.centre = scene.centre ?? [0, 0, 0];
    this.size = scene.size ?? 1;
    this.frames = [];
    let at = 0;
    for (const shape of this.shapes) {
      shape.at = at;
      at += 3 * shape.points;
    }
    for (const shape of this.shapes) if (shape.tone) shape.toneAt = at++;
    this.follow = this.shapes.find((shape) => shape.name === scene.follows);
    this.longest = Math.max(0, ...this.shapes.map((shape) => shape.trail));
    this.home();
    this.drawLegend();
  }

  home() {
    this.turn = -0.9;
    this.lift = 0.38;
    this.zoom = 1;
  }

  listen() {
    const fingers = new Map();
    let apart = 0;
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
      apart = 0;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      fingers.set(event.pointerId, event);
      if (fingers.size === 2) {
        const [a, b] = [...fingers.values()];
        const now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        if (apart) this.zoom = Math.min(Math.max(this.zoom * now / apart, 0.3), 6);
        apart = now;
        return;
      }
      this.turn -= (event.clientX - before.clientX) * 0.008;
      this.lift += (event.clientY - before.clientY) * 0.008;
      this.lift = Math.min(Math.max(this.lift, -1.5), 1.5);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
    }
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom = Math.min(Math.max(this.zoom * Math.exp(-event.deltaY * 0.001), 0.3), 6);
    }, { passive: false });
    this.canvas.addEventListener("dblclick", () => this.home());
  }

  drawLegend() {
    const entries = new Map();
    for (const shape of this.shapes) entries.set(shape.name, shape);
    this.legend.replaceChildren(...[...entries.values()].map((shape) => {
      const entry = document.createElement("li");
      const sample = document.createElement("i");
      sample.style.background = shape.tone
        ? `linear-gradient(90deg, ${tone(0)}, ${tone(0.5)}, ${tone(1)})` : `var(--${shape.role})`;
      entry.append(sample, shape.name);
      return entry;
    }));
  }

  // Take a block of frames; `keep` leaves those that are there already.
  take(block, keep) {
    if (!keep) this.frames = [];
    for (let k = 0; k < block.count; k += 1) {
      const from = k * block.stride;
      this.frames.push({
        t: block.origin + block.values[from],
        points: block.values.subarray(from + 1, from + block.stride),
      });
    }
    this.frames.sort((a, b) => a.t - b.t);
    if (this.frames.length > KEPT) this.frames.splice(0, this.frames.length - KEPT);
  }

  frameAt(t) {
    let low = 0;
    let high = this.frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle].t <= t) low = middle;
      else high = middle - 1;
    }
    return this.frames.length ? low : -1;
  }

  // Whether there is what belongs to a moment, and the way of what leaves one.
  holds(t) {
    const [first, last] = [this.frames[0]?.t, this.frames.at(-1)?.t];
    return first <= Math.max(t - this.longest, 0) + APART && last >= t;
  }

  draw(t) {
    const { context, width, height } = prepare(this.canvas);
    watermark(context, width, height, this.mark, Math.min(width / 7, 86));
    const number = this.frameAt(t);
    // What belongs to another moment is not shown: what belongs to this one is still on its way.
    if (number < 0 || Math.abs(this.frames[number].t - t) > APART) return;
    const points = this.frames[number].points;
    const eye = this.eye(points, width, height);
    this.drawGround(context, eye, points);
    const pieces = [];
    for (const shape of this.shapes) {
      if (shape.trail) this.trail(pieces, shape, number, t, eye);
      this.outline(pieces, shape, points, eye);
    }
    pieces.sort((a, b) => b.depth - a.depth);
    for (const piece of pieces) piece.paint(context);
  }

  eye(points, width, height) {
    const [ct, st] = [Math.cos(this.turn), Math.sin(this.turn)];
    const [cl, sl] = [Math.cos(this.lift), Math.sin(this.lift)];
    let [cx, cy] = this.centre;
    const cz = this.centre[2];
    if (this.follow) {
      cx += points[this.follow.at];
      cy += points[this.follow.at + 1];
    }
    const scale = 0.5 * Math.min(width, height) / this.size * this.zoom;
    const far = NEAR * this.size;
    const put = (x, y, z) => {
      const [dx, dy, dz] = [x - cx, y - cy, z - cz];
      const side = -st * dx + ct * dy;
      const out = ct * dx + st * dy;
      const up = -sl * out + cl * dz;
      const depth = far - (cl * out + sl * dz);
      const near = far / Math.max(depth, 0.1 * far);
      return { x: width / 2 + side * scale * near, y: height / 2 - up * scale * near, depth, near };
    };
    return { put, scale, size: this.size, centre: [cx, cy, cz] };
  }

  drawGround(context, eye, points) {
    let floor = Infinity;
    for (const shape of this.shapes) {
      if (shape.role === "limit") continue;
      for (let k = shape.at + 2; k < shape.at + 3 * shape.points; k += 3) {
        floor = Math.min(floor, points[k]);
      }
    }
    if (this.shapes.length === 0 || !Number.isFinite(floor)) return;
    this.floor = Math.min(this.floor ?? floor, floor);
    if (this.shapes.some((shape) => shape.radius)) this.floor = Math.min(this.floor, -0.9 * this.size);
    const step = 10 ** Math.round(Math.log10(this.size / 3));
    const reach = Math.ceil(1.3 * this.size / step) * step;
    const [x0, y0] = eye.centre.map((value) => Math.round(value / step) * step);
    context.strokeStyle = color("grid");
    context.lineWidth = 1;
    context.beginPath();
    for (let k = -reach; k <= reach + step / 2; k += step) {
      for (const [a, b] of [
        [[x0 + k, y0 - reach], [x0 + k, y0 + reach]], [[x0 - reach, y0 + k], [x0 + reach, y0 + k]],
      ]) {
        const from = eye.put(...a, this.floor);
        const to = eye.put(...b, this.floor);
        context.moveTo(from.x, from.y);
        context.lineTo(to.x, to.y);
      }
    }
    context.stroke();
    context.fillStyle = color("quiet");
    context.font = "11px system-ui, sans-serif";
    const told = step >= 1 ? `${step} m` : `${Math.round(step * 1e3)} mm`;
    context.fillText(`grid ${told}`, 12, this.canvas.clientHeight - 10);
  }

  colorOf(shape, points) {
    if (!shape.tone) return color(shape.role);
    const [low, high] = shape.range;
    return tone((points[shape.toneAt] - low) / (high - low));
  }

  outline(pieces, shape, points, eye) {
    const placed = [];
    for (let k = 0; k < shape.points; k += 1) {
      const at = shape.at + 3 * k;
      placed.push(eye.put(points[at], points[at + 1], points[at + 2]));
    }
    const ink = this.colorOf(shape, points);
    const alpha = { ghost: 0.5, limit: 0.55, ground: 0.8 }[shape.role] ?? 1;
    if (shape.kind === "dot") {
      for (const place of placed) pieces.push(dot(shape, place, ink, eye));
      return;
    }
    if (shape.kind === "loop" && shape.points <= 8) pieces.push(face(placed, ink));
    const ends = shape.kind === "loop" ? placed.length : placed.length - 1;
    for (let k = 0; k < ends; k += 1) {
      pieces.push(stroke(placed[k], placed[(k + 1) % placed.length], ink, shape.width, alpha));
    }
  }

  trail(pieces, shape, number, t, eye) {
    const first = this.frameAt(t - shape.trail);
    const step = Math.max(1, Math.floor((number - first) / 300));
    const ink = color(shape.role);
    let before = null;
    for (let k = number; k >= Math.max(first, 0); k -= step) {
      const { points, t: then } = this.frames[k];
      const place = eye.put(points[shape.at], points[shape.at + 1], points[shape.at + 2]);
      if (before) pieces.push(stroke(before, place, ink, 2, 0.85 * (1 - (t - then) / shape.trail)));
      before = place;
    }
  }
}

function stroke(a, b, ink, width, alpha) {
  return {
    depth: 0.5 * (a.depth + b.depth),
    paint(context) {
      context.globalAlpha = Math.max(alpha, 0.05);
      context.strokeStyle = ink;
      context.lineWidth = width * 0.5 * (a.near + b.near);
      context.lineCap = "round";
      context.beginPath();
      context.moveTo(a.x, a.y);
      context.lineTo(b.x, b.y);
      context.stroke();
      context.globalAlpha = 1;
    },
  };
}

function face(placed, ink) {
  return {
    depth: placed.reduce((sum, place) => sum + place.depth, 0) / placed.length + 1e-6,
    paint(context) {
      context.globalAlpha = 0.14;
      context.fillStyle = ink;
      context.beginPath();
      for (const place of placed) context.lineTo(place.x, place.y);
      context.fill();
      context.globalAlpha = 1;
    },
  };
}

function dot(shape, place, ink, eye) {
  const radius = shape.radius ? shape.radius * eye.scale * place.near : 0.5 * shape.width * place.near;
  return {
    // A ball is where its centre is; a mark lies before the line that it is on.
    depth: shape.radius ? place.depth : place.depth - 0.05 * eye.size,
    paint(context) {
      context.beginPath();
      context.arc(place.x, place.y, radius, 0, 2 * Math.PI);
      if (shape.radius) {
        const light = context.createRadialGradient(
          place.x - 0.4 * radius, place.y - 0.45 * radius, 0.1 * radius, place.x, place.y, radius,
        );
        light.addColorStop(0, color("ball-light"));
        light.addColorStop(1, color("ball-dark"));
        context.fillStyle = light;
      } else {
        context.fillStyle = ink;
      }
      context.fill();
    },
  };
}
