// What the cameras see, with the markers that were found; a click makes a picture large.

import { color, prepare, watermark } from "./look.js";

const FACTS = 28; // bytes: width and height of the image, and a word on it
const RING = 13; // pixels of the screen

export class Cameras {
  constructor(board, place) {
    this.board = board;
    this.place = place;
    this.names = [];
    this.shown = new Map();
  }

  describe(names) {
    this.names = names;
  }

  // One message: marks as pairs of numbers, then facts, then the picture.
  async take(block, data) {
    const at = block.values.byteOffset + 8 * block.count;
    const head = new DataView(data, at, FACTS);
    const word = new TextDecoder().decode(new Uint8Array(data, at + 4, FACTS - 4)).replaceAll("\0", "");
    const told = {
      frame: block.origin, marks: block.values, count: block.count, word,
      width: head.getUint16(0, true), height: head.getUint16(2, true), at: performance.now(),
    };
    try {
      told.image = await createImageBitmap(new Blob([data.slice(at + FACTS)], { type: "image/jpeg" }));
    } catch {
      return; // it is none
    }
    const view = this.shown.get(block.id) ?? this.open(block.id);
    if (view.told && view.told.frame > told.frame) { // a later one was quicker
      told.image.close();
      return;
    }
    view.told?.image.close();
    view.told = told;
  }

  open(number) {
    const figure = document.createElement("figure");
    figure.className = "camera";
    figure.title = "larger, smaller";
    const canvas = document.createElement("canvas");
    const caption = document.createElement("figcaption");
    figure.append(canvas, caption);
    figure.addEventListener("click", () => figure.classList.toggle("large"));
    this.place.append(figure);
    const view = { figure, canvas, caption, name: this.names[number] ?? `camera ${number + 1}` };
    this.shown.set(number, view);
    return view;
  }

  draw(now) {
    for (const view of this.shown.values()) this.drawOne(view, now);
  }

  // There are no pictures of the past: what is shown is what is seen now.
  age(passed) {
    if (!this.board.status?.live) return "the last one";
    if (passed > 1000) return `${(passed / 1000).toFixed(1)} s old`;
    return this.board.moment.isLive ? "" : "now";
  }

  drawOne({ figure, canvas, caption, name, told }, now) {
    if (!told) return;
    figure.style.aspectRatio = `${told.width} / ${told.height}`;
    const { context, width, height } = prepare(canvas);
    const scale = Math.min(width / told.width, height / told.height);
    const [w, h] = [told.width * scale, told.height * scale];
    const [x0, y0] = [0.5 * (width - w), 0.5 * (height - h)];
    context.drawImage(told.image, x0, y0, w, h);
    watermark(context, width, height, this.board.mark, width / 8, 0.35);
    context.lineWidth = 2;
    context.strokeStyle = color("found");
    for (let k = 0; k < told.count; k += 1) {
      const [x, y] = [x0 + (told.marks[2 * k] + 0.5) * scale, y0 + (told.marks[2 * k + 1] + 0.5) * scale];
      context.beginPath();
      context.arc(x, y, RING, 0, 2 * Math.PI);
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        context.moveTo(x + RING * dx, y + RING * dy);
        context.lineTo(x + (RING + 7) * dx, y + (RING + 7) * dy);
      }
      context.stroke();
    }
    caption.textContent = [name, told.word, this.age(now - told.at)].filter(Boolean).join(" · ");
    caption.classList.toggle("bad", told.word !== "seen");
  }
}
