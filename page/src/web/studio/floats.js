// Buttons that stand where places of the object are on the screen.

export class Floats {
  constructor(view, root) {
    this.view = view;
    this.root = root;
    this.known = new Map();
    this.sources = [];
    view.listen(() => this.place());
  }

  /** A source gives what there is: { key, at (in the picture's space), make, update }. */
  from(source) {
    this.sources.push(source);
  }

  place() {
    const gone = new Set(this.known.keys());
    for (const item of this.sources.flatMap((source) => source())) {
      const at = this.view.onScreen(item.at);
      if (!at) continue;
      gone.delete(item.key);
      if (!this.known.has(item.key)) this.known.set(item.key, this.root.appendChild(item.make()));
      const button = this.known.get(item.key);
      item.update?.(button, item);
      button.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px) translate(-50%, -50%)`;
    }
    for (const key of gone) {
      const button = this.known.get(key);
      // What has the focus hands it on, or keys would go nowhere.
      if (button === document.activeElement) this.view.canvas.focus();
      button.remove();
      this.known.delete(key);
    }
  }
}
