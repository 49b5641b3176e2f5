// The web socket: JSON for what is said, packed numbers for what was measured.

const KINDS = { 1: "rows", 2: "frames", 3: "beside", 4: "camera" };
const HEAD = 24;

export class Link {
  // `hear` has a function for each type of message, and `rows`, `frames` and `lost`.
  constructor(token, hear) {
    this.token = token;
    this.hear = hear;
    this.heard = 0;
    this.number = 0;
    this.isOpen = false;
    this.connect();
  }

  connect() {
    this.heard = 0;
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.isOpen = true;
      this.say({ type: "open", token: this.token });
    };
    socket.onmessage = (event) => this.take(event.data);
    socket.onclose = (event) => {
      this.isOpen = false;
      this.hear.lost(event.code);
      if (event.code !== 4401) setTimeout(() => this.connect(), 1000);
    };
    this.socket = socket;
  }

  say(message) {
    if (this.isOpen) this.socket.send(JSON.stringify(message));
  }

  // Ask for something that is answered by numbers; returns the number of the request.
  ask(message) {
    this.number += 1;
    this.say({ ...message, id: this.number });
    return this.number;
  }

  take(data) {
    this.heard += 1;
    if (typeof data === "string") {
      const message = JSON.parse(data);
      // Said at once, and not by a timer: those of a page that is hidden hardly run.
      if (message.type === "status") this.say({ type: "here", heard: this.heard });
      this.hear[message.type]?.(message);
      return;
    }
    const head = new DataView(data);
    const kind = head.getUint32(0, true);
    const count = head.getUint32(8, true);
    const width = head.getUint32(12, true);
    const origin = head.getFloat64(16, true);
    const values = new Float32Array(data, HEAD, count * (width + 1));
    const block = { id: head.getUint32(4, true), count, width, stride: width + 1, origin, values };
    this.hear[KINDS[kind]]?.(block, data);
  }
}
