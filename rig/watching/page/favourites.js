// Channels that a person wants to find first, for each rig, kept by the browser.

export class Favourites {
  constructor(rig) {
    this.key = `rig-favourites:${rig}`;
    try {
      const kept = JSON.parse(localStorage.getItem(this.key));
      this.names = new Set(Array.isArray(kept) ? kept.map(String) : []);
    } catch {
      this.names = new Set(); // of another version
    }
  }

  has(name) {
    return this.names.has(name);
  }

  star(name, changed) {
    const button = document.createElement("button");
    button.type = "button"; // or the dialogue would close
    button.className = "star";
    button.textContent = this.has(name) ? "★" : "☆";
    button.title = "find it first";
    button.ariaPressed = String(this.has(name));
    button.addEventListener("click", () => {
      if (!this.names.delete(name)) this.names.add(name);
      localStorage.setItem(this.key, JSON.stringify([...this.names]));
      changed();
    });
    return button;
  }
}
