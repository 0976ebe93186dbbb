// A slider for every joint.
import { css, counted, el, factList, icon } from "./dom.js";
import { figure } from "./view.js";

const WORDS = { revolute: "turns", continuous: "turns freely", prismatic: "slides", free: "moves freely", fixed: "fixed" };

const shownValue = (turns, value) => (turns ? (value * 180) / Math.PI : value * 1000);
const unitOf = (turns) => (turns ? "°" : "mm");
const said = (turns, value) => `${Number(shownValue(turns, value).toFixed(1))}${turns ? "°" : " mm"}`;

function joint(view, j) {
  const { model } = view;
  const { name, kind, child, mimic, facts } = model.joints[j];
  const turns = model.turns(j);
  const [low, high] = model.reach(j);
  const [least, most] = model.ends(j);
  const id = `joint-${j}`;
  const slider = el("input", {
    type: "range", id, min: low, max: high, step: (high - low) / 1000 || 0.001, value: model.value(j),
    disabled: Boolean(mimic), oninput: () => {
      view.stop();
      view.set(j, Number(slider.value));
    },
  });
  const number = el("input", {
    type: "number", className: "value", step: turns ? 1 : 5, disabled: Boolean(mimic), "aria-label": `${name}, ${turns ? "degrees" : "millimetres"}`,
    min: shownValue(turns, low).toFixed(1), max: shownValue(turns, high).toFixed(1),
    onchange: () => {
      view.stop();
      view.set(j, turns ? (Number(number.value) * Math.PI) / 180 : Number(number.value) / 1000);
    },
  });
  const play = el("button", { type: "button", className: "icon", "aria-label": `Play ${name}`, disabled: Boolean(mimic), onclick: () => toggle() }, icon("play"));
  const mine = () => view.playing && view.playing.list.length === 1 && view.playing.list[0] === j;
  const toggle = () => (mine() ? view.stop() : view.play([j]));
  const note = mimic
    ? `follows ${model.joints[mimic.joint].name} (× ${figure(mimic.factor)})`
    : model.joints[j].range || kind === "continuous" ? WORDS[kind] : `${WORDS[kind]}, no limits in the file`;
  const row = el("div", { className: "joint", style: { "--colour": css(model.links[child].colour) } },
    el("div", { className: "row" }, el("label", { htmlFor: id, className: "name" }, name), el("span", { className: "dim" }, note)),
    el("div", { className: "row" }, play, slider, number, el("span", { className: "unit" }, unitOf(turns))),
    el("div", { className: "row ends" }, el("button", { type: "button", className: "end", disabled: Boolean(mimic), onclick: () => end(least) }, said(turns, least)),
      el("button", { type: "button", className: "end", disabled: Boolean(mimic), onclick: () => end(most) }, said(turns, most))),
    facts.length ? el("details", { className: "why" }, el("summary", {}, "where from"), factList(facts)) : null,
  );
  const end = (value) => {
    view.stop();
    view.set(j, value);
  };
  row.addEventListener("pointerenter", () => activate(view, j));
  row.addEventListener("focusin", () => activate(view, j));
  let playing = null;
  const follow = () => {
    const value = model.value(j);
    if (Number(slider.value) !== value) slider.value = value;
    slider.style.setProperty("--fill", `${(100 * (value - low)) / (high - low || 1)}%`);
    slider.style.setProperty("--rest", `${(100 * -low) / (high - low || 1)}%`);
    slider.setAttribute("aria-valuetext", said(turns, value));
    const text = Number(shownValue(turns, value).toFixed(1));
    if (document.activeElement !== number) number.value = text;
    row.classList.toggle("active", view.active === j);
    if (mine() !== playing) {
      playing = mine();
      play.replaceChildren(icon(playing ? "pause" : "play"));
    }
  };
  return { row, follow };
}

function activate(view, j) {
  if (view.active === j || view.playing) return;
  view.active = j;
  view.changed();
}

/** The list of joints. */
export function jointList(view) {
  const { model } = view;
  const shown = model.joints.map((_, j) => j).filter((j) => model.moves(j));
  const rows = shown.map((j) => joint(view, j));
  view.listen(() => rows.forEach((r) => r.follow()));
  const rest = model.joints.length - shown.length;
  const free = model.joints.filter((joint) => joint.kind === "free").length;
  const notes = [];
  if (rest - free > 0) notes.push(counted(rest - free, "fixed joint"));
  if (free > 0) notes.push(`${counted(free, "joint")} with more than one way to move, shown as ${free === 1 ? "it stands" : "they stand"}`);
  const empty = shown.length ? null : el("p", { className: "dim" }, "Nothing here moves.");
  return { count: shown.length, body: el("div", {}, ...rows.map((r) => r.row), empty, notes.length ? el("p", { className: "dim" }, notes.join(" · ")) : null) };
}
