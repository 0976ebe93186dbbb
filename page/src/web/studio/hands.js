// Pointer and keys on the object under work.
import { TAU, add, aside, cross, rotate, scale } from "../maths.js";
import { el, icon } from "../dom.js";
import { isTaken, pointer, sights, turned } from "../keys.js";
import { Brush, chosenPin } from "./pins.js";

const RING = 48;
/** Two clicks of one place within so many milliseconds are a double one. */
const DOUBLE = 350;
const BRUSH = { least: 6, most: 120 };

/** Listens to the pointer: points, paint, and the camera for the rest. */
export function handsOn(desk, handles) {
  const { view } = desk;
  const brush = new Brush(desk);
  let over = null;
  let space = false;
  let last = { at: [-99, -99], time: 0 };
  /** The second click of a double one says nothing new. */
  const isAgain = (at, time) => {
    const is = time - last.time < DOUBLE && Math.hypot(at[0] - last.at[0], at[1] - last.at[1]) < 5;
    last = { at, time };
    return is;
  };
  const seen = (at) => {
    over = view.hit(at);
    view.changed();
  };
  const press = (at, event) => {
    if (event.button !== 0 || space) return false;
    if (desk.tool === "point") return !event.shiftKey && handles.press(at);
    if (event.shiftKey) return false;
    over = view.hit(at);
    if (!over || desk.chosen < 0) return false;
    view.stop();
    brush.begin(over, event.altKey);
    return true;
  };
  pointer(view, {
    press,
    drag: (at, event) => {
      if (handles.pulled) return handles.move(at, event.altKey);
      seen(at);
      brush.move(over);
    },
    drop: (_, event) => (handles.pulled ? handles.drop(event.type === "pointercancel") : brush.end()),
    hover: (at) => desk.tool === "brush" && seen(at),
    click: (at, event) => {
      const found = view.hit(at);
      if (event.ctrlKey || event.metaKey || event.altKey) return found && found.part >= 0 && desk.choose(found.part);
      if (desk.tool === "point" && !isAgain(at, event.timeStamp)) setPoint(desk, found, event.shiftKey);
    },
  });
  view.extras.push((frame, theme) => desk.tool === "brush" && over && ring(view, frame, theme, over, brush));
  view.canvas.addEventListener("pointerleave", () => {
    over = null;
    view.changed();
  });
  for (const name of ["keydown", "keyup"]) {
    addEventListener(name, (event) => {
      if (event.key !== " " || (name === "keydown" && isTaken(event))) return;
      space = name === "keydown";
      if (event.target === view.canvas || event.target === document.body) event.preventDefault();
    });
  }
}

/** A click says where the chosen part is, or where it is not. */
function setPoint(desk, found, isNot) {
  if (desk.pin) {
    desk.pin = null;
    desk.view.changed();
    desk.changed();
  }
  if (!found) return desk.say("Nothing is there: click on the model.");
  if (desk.chosen < 0) return desk.say("Choose a part first, or add one (a).");
  desk.addPoint(found.point, isNot);
}

/** The brush's reach, as a ring on the surface. */
function ring(view, frame, theme, found, brush) {
  const n = rotate(found.pose.turn, view.body.normal(found.face));
  const x = aside(n);
  const y = cross(n, x);
  const radius = brush.radius(found);
  const point = (i) => add(found.world, add(scale(x, radius * Math.cos((TAU * i) / RING)), scale(y, radius * Math.sin((TAU * i) / RING))));
  const colour = theme.lift > 1 ? [1, 1, 1, 0.95] : [0.05, 0.09, 0.16, 0.9];
  for (let i = 0; i < RING; i++) frame.rings.push([point(i), point(i + 1), colour, 2]);
}

export const widen = (desk, by) => {
  desk.brush = Math.min(Math.max(desk.brush * by, BRUSH.least), BRUSH.most);
  desk.view.changed();
  desk.changed();
};

const LOOKS = [["parts", "Parts", "Part colours"], ["true", "True look", "As the mesh is coloured"], ["sure", "How sure", "The paler a face, the less sure; what is a guess is hatched"]];
const SHOWN = [["axes", "j", "Axes and ranges", "axes"], ["labels", "l", "Names", "labels"], ["xray", "x", "X-ray", "xray"]];

/** The next way to look. */
function nextLook(view) {
  const at = LOOKS.findIndex(([name]) => name === view.shows.look);
  view.show("look", LOOKS[(at + 1) % LOOKS.length][0]);
}

/** The toolbar under the picture. */
export function editTools(desk, root, { help, photo }) {
  const { view } = desk;
  const follows = [];
  const pressed = (button, is) => {
    follows.push(() => button.setAttribute("aria-pressed", is()));
    return button;
  };
  const tool = (name, words, title, picture) => pressed(el("button", { type: "button", id: `tool-${name}`, className: "tool", title, onclick: () => desk.takes(name) }, icon(picture), words), () => desk.tool === name);
  const size = el("input", { type: "range", id: "brush-size", min: BRUSH.least, max: BRUSH.most, value: desk.brush, "aria-label": "Size of the brush", oninput: () => {
    desk.brush = Number(size.value);
    view.changed();
  } });
  const sizes = el("label", { id: "brush" }, "Brush", size);
  root.before(sizes);
  follows.push(() => {
    sizes.hidden = desk.tool !== "brush";
    if (Number(size.value) !== desk.brush) size.value = desk.brush;
    size.style.setProperty("--rest", "0%");
    size.style.setProperty("--fill", `${(100 * (desk.brush - BRUSH.least)) / (BRUSH.most - BRUSH.least)}%`);
  });
  const look = ([name, words, title]) => pressed(el("button", { type: "button", id: `look-${name}`, title: `${title} (c)`, onclick: () => view.show("look", name) }, words), () => view.shows.look === name);
  const shown = ([name, key, words, picture]) => pressed(el("button", { type: "button", className: "icon", title: `${words} (${key})`, "aria-label": words, onclick: () => view.show(name, !view.shows[name]) }, icon(picture)), () => view.shows[name]);
  const plain = (name, words, act) => el("button", { type: "button", className: "icon", title: words, "aria-label": words, onclick: act }, icon(name));
  root.append(el("span", { className: "group", role: "group", "aria-label": "Tool" }, tool("point", "Points", "Click says where the part is, Shift-click where it is not (v)", "point"), tool("brush", "Brush", "Paints faces as the part's; Alt takes the paint off (b)", "brush")),
    el("span", { className: "group", role: "group", "aria-label": "Colours" }, ...LOOKS.map(look)),
    el("span", { className: "group", role: "group", "aria-label": "Show" }, ...SHOWN.map(shown), photo ? plain("photo", "Photo (i)", photo) : null),
    el("span", { className: "group" }, plain("reset", "Back to rest (r)", () => view.rest()), plain("fit", "Fit to view (f)", () => view.look()), plain("help", "Keyboard shortcuts (?)", help)));
  const follow = () => follows.forEach((callback) => callback());
  view.listen(follow);
  desk.listen(follow);
}

/** What keys do while editing. */
export function editKeys(desk, { help, photo, build, isOn }) {
  const { view } = desk;
  const focus = (id) => document.getElementById(id)?.focus();
  const acts = view ? { ...sights(view), c: () => nextLook(view), r: () => view.rest(), v: () => desk.takes("point"), b: () => desk.takes(desk.tool === "brush" ? "point" : "brush"), "[": () => widen(desk, 1 / 1.2), "]": () => widen(desk, 1.2) } : {};
  Object.assign(acts, { a: () => focus("new-part"), e: () => focus("part-name"), n: () => desk.chooseNext(1), p: () => desk.chooseNext(-1), "?": help, i: () => photo?.() });
  if (view) for (const [name, key] of SHOWN) acts[key] = () => view.show(name, !view.shows[name]);
  const away = () => {
    const pin = chosenPin(desk);
    if (pin) desk.removePoint(pin);
  };
  Object.assign(acts, { Delete: away, Backspace: away, Escape: () => {
    desk.pin = null;
    desk.takes("point");
  } });
  addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]")) return;
    const isCommand = event.ctrlKey || event.metaKey;
    if (isCommand && event.key === "Enter") {
      build();
      return event.preventDefault();
    }
    if (isCommand && /^[zy]$/i.test(event.key)) {
      if (event.shiftKey || event.key.toLowerCase() === "y") desk.store.redo();
      else desk.store.undo();
      return event.preventDefault();
    }
    if (!isOn() || isCommand || event.altKey || isTaken(event)) return;
    if (view && event.target === view.canvas && turned(view, event)) event.preventDefault();
    else if (Object.hasOwn(acts, event.key)) {
      acts[event.key]();
      event.preventDefault();
    }
  });
}

const KEYS_OF_EDIT = [
  ["a", "add a part"], ["n  p", "next and previous part"], ["e", "name of the chosen part"], ["v", "points: click says where it is"], ["b", "brush: paint faces, Alt takes paint off"], ["[  ]", "smaller and larger brush"],
  ["Del", "delete the chosen point"], ["c", "part colours, true look, how sure"], ["j  l  x", "axes, names, X-ray"], ["i", "photo"], ["r", "everything back to rest"], ["f", "fit to view"], ["0 1 2 3 4", "three-quarter, front, right, top, back"],
  ["arrows", "turn (with Shift: move)"], ["+  −", "nearer, farther"], ["Ctrl+Z", "undo"], ["Ctrl+Shift+Z", "redo"], ["Ctrl+Enter", "build"], ["?", "this list"],
];

/** Fills the list of keys; returns what opens and closes it. */
export function editHelp(dialog) {
  const rows = KEYS_OF_EDIT.flatMap(([key, words]) => [el("dt", {}, ...key.split(/\s\s?/).map((k) => el("kbd", {}, k))), el("dd", {}, words)]);
  const mouse = [
    "Click: this is the chosen part. Shift-click: this is not. Ctrl-click: choose the part under it. Drag to turn, right drag to move, wheel to zoom.",
    "The axis: pull its middle to move it, its ends to turn it. It snaps to found lines and to edges; Alt lets it go freely. The round ends of the arc are the range.",
    "With the brush: drag paints, right drag or Space and drag turns.",
  ].map((words) => el("p", { className: "dim" }, words));
  dialog.append(el("h2", {}, "Keys"), el("dl", {}, ...rows), ...mouse, el("button", { type: "button", onclick: () => dialog.close() }, "Close"));
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  return () => (dialog.open ? dialog.close() : dialog.showModal());
}
