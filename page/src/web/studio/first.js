// The first step of an object that has no parts yet.
import { byId, el } from "../dom.js";
import { newPart } from "./side.js";

function draftButton(desk) {
  if (!desk.state.can_draft) return null;
  const button = el("button", { type: "button", id: "draft", onclick: async () => {
    button.disabled = true;
    button.textContent = "Asking the model…";
    try {
      const { document: drafted } = await desk.api.post("draft");
      desk.store.edit("drafted from the photo", (doc) => Object.assign(doc, drafted));
      desk.choose(0);
    } catch (error) {
      desk.say(`No draft: ${error.message}`);
    }
    button.disabled = false;
    button.textContent = "Draft it from the photo";
  } }, "Draft it from the photo");
  return el("p", {}, el("span", { className: "dim" }, "or "), button);
}

/** A card with the three steps; it goes when there is a part. */
export function firstSteps(desk) {
  const root = byId("first");
  const input = el("input", { type: "text", id: "base-name", placeholder: "body", autocomplete: "off", spellcheck: false, "aria-label": "Name of the base" });
  const form = el("form", { className: "row", onsubmit: (event) => {
    event.preventDefault();
    newPart(desk, input.value.trim() || "body");
    byId("new-part")?.focus();
  } }, input, el("button", { type: "submit", className: "main plain", id: "base-add" }, "Start"));
  const step = (number, title, words, more) => el("li", {}, el("span", { className: "number", "aria-hidden": "true" }, number), el("div", {}, el("strong", {}, title), el("p", { className: "dim" }, words), more));
  root.append(el("h2", {}, "Say what the parts are"), el("ol", {},
    step("1", "Name the base", "What all the rest hangs on, like a body or a frame.", form),
    step("2", "Add parts, click on each", "Press a, type a name, then click on it on the model."),
    step("3", "Build", "Masses, collision shapes and the verdict follow.")), draftButton(desk) ?? "");
  let shown = null;
  desk.listen(() => {
    const isEmpty = desk.doc.parts.length === 0;
    if (isEmpty === shown) return;
    shown = isEmpty;
    root.hidden = !isEmpty;
    if (isEmpty) input.focus();
  });
}
