// A joint of the chosen part: tried by a slider, corrected by fields and buttons.
import { el } from "../dom.js";
import { givenEnds, kindsOf, restOf, saidOf, turnsAt } from "./edits.js";
import { DEGREE } from "./geometry.js";
import { figureOf, takeCandidate } from "./handles.js";
import { six } from "./text.js";

const NAMES = { axis: "axis", pivot: "place", range: "range", rest: "shown at" };

/** Range and rest that make a value the shut pose; all measured from the shown pose. */
export function shutAt(value, [low, high]) {
  const isOutside = value < low - 1e-9 || value > high + 1e-9;
  const far = isOutside ? 0 : high - value >= value - low ? high : low;
  const other = six(far - value);
  return { range: other >= 0 ? [0, other] : [other, 0], rest: six(-value) || null };
}

class Card {
  constructor(desk, kind, k) {
    Object.assign(this, { desk, kind, k, turns: turnsAt(kind) });
    this.unitSize = this.turns ? DEGREE : 0.001;
    this.unit = this.turns ? "°" : "mm";
  }

  get said() {
    return this.desk.part() ? saidOf(this.desk.part(), this.k) : {};
  }

  get rest() {
    return restOf(this.said, this.turns);
  }

  /** The joint in the model, or nothing while nobody knows where it is. */
  get model() {
    const j = this.desk.modelJoint(this.k);
    return j < 0 ? null : j;
  }

  /** Units of the model in radians or metres. */
  get metres() {
    return this.turns ? 1 : this.desk.keeper.scale;
  }

  /** Its ends from the shown pose, radians or metres. */
  ends() {
    if (this.kind === "continuous") return null;
    const given = givenEnds(this.said, this.turns);
    if (given) return given;
    const j = this.model;
    return j === null ? null : this.desk.view.model.ends(j).map((end) => end * this.metres);
  }

  /** Numbers as a person reads them: degrees or millimetres, from the shut pose. */
  shown(value) {
    return value === null || value === undefined ? null : Number(((value + this.rest) / this.unitSize).toFixed(this.turns ? 2 : 2)) || 0;
  }

  correct(words, fields, more) {
    if (this.desk.joint !== this.k) this.desk.choose(this.desk.chosen, this.k);
    this.desk.correct(words, fields, more);
  }

  setEnd(which, shownValue) {
    if (shownValue === null) return this.correct("range as found", { range: null });
    const ends = this.ends() ?? [0, 0];
    ends[which] = shownValue * this.unitSize - this.rest;
    if (ends[0] > ends[1]) return false;
    this.correct("range set", { range: ends.map((end) => six(end + this.rest)) });
    return true;
  }

  shut() {
    const j = this.model;
    const value = this.desk.view.model.value(j) * this.metres;
    const { range, rest } = shutAt(value, this.ends() ?? [0, 0]);
    this.correct("shut is here", { range, rest });
    this.desk.say(`Shut is where it stands now: its range is ${range.map((r) => figureOf(r, this.turns)).join(" to ")}, shown at ${figureOf(rest ?? 0, this.turns)}.`);
  }

  async freeRange(button) {
    const { desk, k } = this;
    const j = this.model;
    const joint = desk.view.model.joints[j];
    const { name } = desk.part();
    button.disabled = true;
    desk.say(`Looking how far ${name} can go…`);
    try {
      await desk.keeper.save();
      const { range } = await desk.api.post("free-range", { revision: desk.keeper.revision, part: name, index: k, axis: joint.axis, pivot: desk.view.scene.homes[joint.child] });
      const at = desk.doc.parts.findIndex((p) => p.name === name);
      if (at < 0) return;
      desk.choose(at, k);
      this.correct("free range", { range: range.map((end) => six(end + this.rest)) });
      desk.say(`${name} is free from ${range.map((r) => figureOf(r + this.rest, this.turns)).join(" to ")}.`);
    } catch (error) {
      desk.say(`The free range is not known: ${error.message}`);
    } finally {
      button.disabled = false;
    }
  }
}

function slider(card, form) {
  const { desk, k } = card;
  const id = `joint-${k}-slider`;
  const input = el("input", { type: "range", id, step: "any", oninput: () => {
    if (desk.joint !== k) desk.choose(desk.chosen, k);
    desk.view.set(card.model, Number(input.value));
  } });
  const number = el("input", { type: "number", id: `joint-${k}-value`, className: "value", step: card.turns ? 1 : 5, "aria-label": `Try a value, ${card.turns ? "degrees" : "millimetres"}`, onchange: () => {
    desk.view.set(card.model, (Number(number.value) * card.unitSize - card.rest) / card.metres);
  } });
  const follow = () => {
    const j = card.model;
    input.disabled = number.disabled = j === null;
    if (j === null) return;
    const { model } = desk.view;
    const [low, high] = model.reach(j);
    const value = model.value(j);
    Object.assign(input, { min: low, max: high });
    if (Number(input.value) !== value) input.value = value;
    const share = (v) => `${(100 * (v - low)) / (high - low || 1)}%`;
    input.style.setProperty("--fill", share(value));
    input.style.setProperty("--rest", share(0));
    const shown = card.shown(value * card.metres);
    input.setAttribute("aria-valuetext", `${shown} ${card.unit}`);
    if (document.activeElement !== number) number.value = Number(shown.toFixed(1));
  };
  form.add(follow);
  desk.view?.listen(() => input.isConnected && follow());
  return [el("div", { className: "row try" }, el("label", { htmlFor: id, className: "dim" }, "Try"), input, number, el("span", { className: "unit" }, card.unit))];
}

function rangeFields(card, form) {
  const { k } = card;
  const end = (which, id, label) => form.number({ id: `joint-${k}-${id}`, label, bare: true, step: card.turns ? 1 : 5, get: () => {
    const value = card.shown(card.ends()?.[which]);
    return value === null ? "" : Number(value.toFixed(card.turns ? 1 : 1));
  }, set: (value) => card.setEnd(which, value) });
  const shownAt = form.number({ id: `joint-${k}-rest`, label: `Shown at, ${card.unit}`, bare: true, step: card.turns ? 1 : 5, get: () => Number((card.rest / card.unitSize).toFixed(1)),
    set: (value) => card.correct("shown at", { rest: value ? six(value * card.unitSize) : null }) });
  const words = (text, field) => el("label", { className: "dim small" }, text, field);
  return el("div", { className: "row range" }, words("From", end(0, "low", `Lower end, ${card.unit}`)), words("to", end(1, "high", `Upper end, ${card.unit}`)),
    words("shown at", shownAt), el("span", { className: "unit" }, card.unit));
}

/** What a person set, each word to be taken back. */
function chips(card, form) {
  const root = el("div", { className: "chips" });
  form.add(() => {
    const fields = Object.keys(NAMES).filter((f) => card.said[f] !== undefined);
    const key = fields.join();
    if (root.dataset.key === key) return;
    root.dataset.key = key;
    const chip = (f) => el("button", { type: "button", className: "chip", "aria-label": `Take back the given ${NAMES[f]}`, title: "Given by you: click to take it back", onclick: () => card.correct(`${NAMES[f]} as found`, { [f]: null }) }, `${NAMES[f]} given`, el("span", { "aria-hidden": "true" }, "×"));
    const all = fields.length ? el("button", { type: "button", className: "link", id: `joint-${card.k}-as-found`, onclick: () => card.correct("as found", { axis: null, pivot: null, range: null, rest: null }) }, "As found") : null;
    root.replaceChildren(...fields.map(chip), ...(all ? [all] : []));
  });
  return root;
}

function axisFields(card, form) {
  const { desk, k } = card;
  const now = (field) => {
    if (card.said[field]) return card.said[field];
    const j = card.model;
    if (j === null) return null;
    const joint = desk.view.model.joints[j];
    return desk.body.fileOf(field === "axis" ? joint.axis : desk.view.scene.homes[joint.child]);
  };
  const row = (field, words) => el("div", { className: "row three" }, el("span", { className: "dim" }, words), ...["x", "y", "z"].map((letter, i) => form.number({
    id: `joint-${k}-${field}-${letter}`, label: `${words} ${letter}`, bare: true, get: () => now(field)?.[i] ?? "",
    set: (value) => {
      const next = [...(now(field) ?? [0, 0, 0])];
      next[i] = value ?? 0;
      if (field === "axis" && !next.some((x) => x !== 0)) return false;
      card.correct(`${NAMES[field]} set`, { [field]: next });
      return true;
    } })));
  return el("details", { className: "more", id: `joint-${k}-numbers` }, el("summary", {}, "Axis in numbers"), row("axis", "Direction"), card.turns ? row("pivot", "Through") : null, el("p", { className: "dim" }, "In the coordinates of the mesh file."));
}

/** The lines that were found, best first. */
function lineList(card, form) {
  const { desk, k } = card;
  const root = el("details", { className: "more", id: `joint-${k}-lines` });
  form.add(() => {
    const list = desk.foundJoint(k)?.candidates ?? [];
    const key = JSON.stringify(list);
    root.hidden = list.length === 0;
    if (root.dataset.key === key) return;
    root.dataset.key = key;
    const one = ({ score }, i) => el("button", { type: "button", className: "line", "aria-label": `Take found line ${i + 1}, score ${score.toFixed(2)}`, onclick: () => {
      if (desk.joint !== k) desk.choose(desk.chosen, k);
      takeCandidate(desk, i);
    }, onpointerenter: () => points(i), onfocus: () => points(i), onpointerleave: () => points(-1), onblur: () => points(-1) },
    el("span", { className: "number" }, String(i + 1)), el("span", { className: "bar", style: { "--score": score } }), el("span", { className: "figures" }, score.toFixed(2)));
    const points = (i) => {
      desk.candidate = i;
      desk.view.changed();
    };
    root.replaceChildren(el("summary", {}, `Found lines (${list.length})`), el("div", { className: "lines" }, ...list.map(one)));
  });
  return root;
}

function buttons(card, form) {
  const { desk, k } = card;
  const free = () => desk.view?.model.free;
  const key = () => `${desk.part()?.name} ${k}`;
  const past = el("button", { type: "button", id: `joint-${k}-past`, title: "Let the slider go past the ends", onclick: () => {
    const set = free();
    if (set.has(key())) set.delete(key());
    else set.add(key());
    if (card.model !== null) desk.view.set(card.model, desk.view.model.value(card.model));
    desk.changed();
  } }, "Past the ends");
  const shut = el("button", { type: "button", id: `joint-${k}-shut`, title: "Where it stands now is shut", onclick: () => card.shut() }, "Shut is here");
  const sweep = el("button", { type: "button", id: `joint-${k}-free`, title: "How far it can go before it meets something", onclick: () => card.freeRange(sweep) }, "Free range");
  form.add(() => {
    [past, shut, sweep].forEach((b) => {
      b.disabled = card.model === null;
    });
    past.setAttribute("aria-pressed", Boolean(free()?.has(key())));
  });
  return el("div", { className: "row buttons" }, shut, sweep, past);
}

function titleOf(desk, kind, k) {
  const moves = kind === "prismatic" ? "slides" : "turns";
  return kindsOf(desk.part()).length > 1 ? `${k ? "Second" : "First"} joint: it ${moves}` : `How it ${moves}`;
}

/** A card for a joint of the chosen part. */
export function jointCard(desk, form, kind, k) {
  const card = new Card(desk, kind, k);
  const unknown = el("p", { className: "dim" });
  form.add(() => {
    unknown.hidden = card.model !== null || !desk.view;
    unknown.textContent = desk.keeper.work ? "Looking for its axis…" : "Its axis is found once the object knows where the part is.";
  });
  const hasEnds = kind !== "continuous";
  const body = desk.view ? [unknown, ...slider(card, form)] : [];
  const root = el("section", { className: "jointcard", id: `card-${k}`, "aria-label": `Joint ${k + 1}, ${kind}` }, el("h3", {}, titleOf(desk, kind, k)),
    ...body, hasEnds ? rangeFields(card, form) : null, hasEnds && desk.view ? buttons(card, form) : null, chips(card, form), axisFields(card, form), desk.view ? lineList(card, form) : null);
  root.addEventListener("focusin", () => desk.joint !== k && desk.choose(desk.chosen, k));
  return root;
}
