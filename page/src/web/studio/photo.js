// The photo beside the model.
import { el, icon } from "../dom.js";

const SIZES = ["small", "large", "hidden"];

/** Puts the photo in its place; returns what shows and hides it. */
export function photoPanel(root, address) {
  const image = el("img", { alt: "The photo of the object", draggable: false, src: address });
  const become = (size) => {
    root.dataset.size = size;
    larger.setAttribute("aria-pressed", size === "large");
    larger.setAttribute("aria-label", size === "large" ? "Smaller photo" : "Larger photo");
  };
  const larger = el("button", { type: "button", className: "icon", title: "Larger or smaller", onclick: () => become(root.dataset.size === "large" ? "small" : "large") }, icon("larger"));
  const close = el("button", { type: "button", className: "icon", title: "Hide the photo (i)", "aria-label": "Hide the photo", onclick: () => become("hidden") }, icon("close"));
  image.addEventListener("error", () => become("hidden"));
  image.addEventListener("click", () => larger.click());
  root.append(image, el("div", { className: "row" }, larger, close));
  root.hidden = false;
  become(SIZES[0]);
  return () => become(root.dataset.size === "hidden" ? "small" : "hidden");
}
