// Names over the picture.
import { css, el } from "./dom.js";

const MOST = 60;

/** Keeps names where their places are; of two that would overlap, the later one is left out. */
export function keepLabels(view, root) {
  const pool = [];
  view.listen(() => {
    const taken = [];
    let used = 0;
    for (const tag of view.tags.slice(0, MOST)) {
      const at = view.onScreen(tag.at);
      if (!at) continue;
      const width = 7.2 * tag.text.length + 22;
      const box = [at[0] - width / 2, at[1] - 11, at[0] + width / 2, at[1] + 11];
      if (taken.some((t) => box[0] < t[2] && t[0] < box[2] && box[1] < t[3] && t[1] < box[3])) continue;
      taken.push(box);
      const label = (pool[used] ??= root.appendChild(el("span")));
      used += 1;
      label.className = tag.mark ? "tag spot" : tag.strong ? "tag strong" : "tag";
      label.textContent = tag.text;
      label.style.setProperty("--colour", tag.mark ? "" : css(tag.colour));
      const lift = tag.mark ? -30 : 0;
      label.style.transform = `translate(-50%, -50%) translate(${at[0].toFixed(1)}px, ${(at[1] + lift).toFixed(1)}px)`;
      label.hidden = false;
    }
    pool.slice(used).forEach((label) => {
      label.hidden = true;
    });
  });
}
