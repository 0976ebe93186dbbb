// Keyboard and pointer.
import { el } from "./dom.js";
import { SWITCHES } from "./tools.js";
import { findable } from "./findings.js";

const KEYS = [
  ["space", "play all joints, stop"], ["[  ]", "choose a joint"], [",  .", "move the chosen joint"], ["r", "back to rest"],
  ["n  p", "next and previous finding"], ["c", "part colours, true look"], ["e", "explode"],
  ...SWITCHES.map(([, key, words]) => [key, words.toLowerCase()]),
  ["h", "hide or show the chosen part"], ["f", "fit to view"], ["0 1 2 3 4", "three-quarter, front, right, top, back"],
  ["arrows", "turn (with Shift: move)"], ["+  −", "nearer, farther"], ["esc", "let go of what is chosen"], ["?", "this list"],
];

/** Fills the list of keys; returns what opens and closes it. */
export function helpBox(dialog) {
  const rows = KEYS.flatMap(([key, words]) => [el("dt", {}, ...key.split(/\s\s?/).map((k) => el("kbd", {}, k))), el("dd", {}, words)]);
  const close = el("button", { type: "button", onclick: () => dialog.close() }, "Close");
  const mouse = el("p", { className: "dim" }, "Drag to turn, right drag or two fingers to move, wheel or pinch to zoom, click a part to choose it, double click to go to it.");
  dialog.append(el("h2", {}, "Keys"), el("dl", {}, ...rows), mouse, close);
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  return () => (dialog.open ? dialog.close() : dialog.showModal());
}

function chooseJoint(view, step) {
  const list = view.model.movable();
  if (!list.length) return;
  const at = list.indexOf(view.active);
  view.active = at < 0 ? list[0] : list[(at + step + list.length) % list.length];
  view.changed();
}

function moveJoint(view, step) {
  const j = view.active;
  if (!view.model.movable().includes(j)) return chooseJoint(view, 1);
  const [low, high] = view.model.reach(j);
  view.stop();
  view.set(j, view.model.value(j) + (step * (high - low)) / 40);
}

/** Whether a key is meant for who has the focus, or for a dialog. */
export function isTaken({ key, target }) {
  if (document.querySelector("dialog[open]")) return true;
  const typing = target.matches?.("input, select, textarea");
  if (typing && (target.type !== "range" || key.startsWith("Arrow") || key === " ")) return true;
  return key === " " && Boolean(target.matches?.("button, summary"));
}

/** Turns or moves the view by an arrow key; true if it was one. */
export function turned(view, { key, shiftKey }) {
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key];
  if (!arrow) return false;
  if (shiftKey) view.camera.pan(0.05 * arrow[0], 0.05 * arrow[1]);
  else view.camera.orbit(-0.12 * arrow[0], -0.12 * arrow[1]);
  view.changed();
  return true;
}

/** Sides and nearness by key. */
export const sights = (view) => ({
  f: () => view.look(), 0: () => view.look("three-quarter"), 1: () => view.look("front"), 2: () => view.look("right"),
  3: () => view.look("top"), 4: () => view.look("back"),
  "+": () => zoom(view, 0.85), "=": () => zoom(view, 0.85), "-": () => zoom(view, 1.18),
});

/** Listens to keys, as long as it is `on`. */
export function keyboard(view, help, on = () => true) {
  let at = -1;
  const finding = (step) => {
    const found = findable(view.scene.checks);
    if (!found.length) return;
    at = at < 0 ? (step > 0 ? 0 : found.length - 1) : (at + step + found.length) % found.length;
    view.find(found[at].one, found[at].id);
  };
  const acts = {
    " ": () => (view.playing ? view.stop() : view.play()),
    "[": () => chooseJoint(view, -1), "]": () => chooseJoint(view, 1),
    ",": () => moveJoint(view, -1), ".": () => moveJoint(view, 1),
    r: () => view.rest(), n: () => finding(1), p: () => finding(-1),
    c: () => view.show("look", view.shows.look === "parts" ? "true" : "parts"),
    e: () => view.show("apart", view.shows.apart > 0.5 ? 0 : 1),
    h: () => view.selected >= 0 && view.hide(view.selected, !view.hidden.has(view.selected)), "?": help,
    Escape: () => {
      view.found = null;
      view.select(-1);
    },
    ...sights(view),
  };
  for (const [name, key] of SWITCHES) acts[key] = () => view.show(name, !view.shows[name]);
  addEventListener("keydown", (event) => {
    if (!on() || event.ctrlKey || event.metaKey || event.altKey || isTaken(event)) return;
    if (event.target === view.canvas && turned(view, event)) event.preventDefault();
    else if (Object.hasOwn(acts, event.key)) {
      acts[event.key]();
      event.preventDefault();
    }
  });
}

function zoom(view, factor, at, aspect) {
  view.camera.zoom(factor, at, aspect);
  view.changed();
}

/** A click chooses the link under it. */
function choose(view, at) {
  const link = view.pick(...at)?.link ?? -1;
  view.select(link === view.selected ? -1 : link);
}

/**
 * Listens to the pointer, or to two fingers. `hands` may take part of that: `press` takes a press if it
 * says so, and gets its `drag` and `drop`; `hover` and `click` are told where.
 */
export function pointer(view, hands = {}) {
  const { canvas } = view;
  const down = new Map();
  let far = 0;
  let taken = null;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const ndc = ([x, y]) => [(2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight];
  const spread = () => {
    const [a, b] = [...down.values()];
    return { wide: Math.hypot(a[0] - b[0], a[1] - b[1]), at: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] };
  };
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (!down.size && hands.press?.(place(event), event)) taken = event.pointerId;
    down.set(event.pointerId, place(event));
    far = down.size > 1 ? Infinity : 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return hands.hover?.(place(event), event);
    if (taken === event.pointerId) return hands.drag(place(event), event);
    const two = down.size === 2 ? spread() : null;
    const now = place(event);
    down.set(event.pointerId, now);
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    far += Math.hypot(dx, dy);
    if (two) {
      const next = spread();
      view.camera.zoom(two.wide / Math.max(next.wide, 1), ndc(next.at), view.aspect());
      view.camera.pan((next.at[0] - two.at[0]) / canvas.clientHeight, (next.at[1] - two.at[1]) / canvas.clientHeight);
    } else if (event.buttons & 6 || event.shiftKey) view.camera.pan(dx / canvas.clientHeight, dy / canvas.clientHeight);
    else view.camera.orbit(dx * 0.008, dy * 0.008);
    view.changed();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      const was = down.delete(event.pointerId);
      if (taken === event.pointerId) {
        taken = null;
        return hands.drop(place(event), event);
      }
      if (!was || far > 4 || name === "pointercancel" || event.button !== 0) return;
      if (hands.click) hands.click(place(event), event);
      else choose(view, place(event));
    });
  }
  canvas.addEventListener("dblclick", (event) => {
    if (hands.click) return;
    const link = view.pick(...place(event))?.link;
    if (link === undefined) view.look();
    else view.lookAt(link);
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const step = event.deltaMode === 1 ? 24 : 1;
    zoom(view, Math.exp(clampWheel(event.deltaY * step) * 0.0014), ndc(place(event)), view.aspect());
  }, { passive: false });
}

const clampWheel = (delta) => Math.min(Math.max(delta, -240), 240);
