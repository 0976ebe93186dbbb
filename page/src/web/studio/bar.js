// The bar at the top: what it is, whether it is saved, back and forth, build.
import { byId, el, icon } from "../dom.js";

const PHASES = { unsaved: "not saved yet", saving: "saving…", offline: "not saved: the studio does not answer", conflict: "not saved: the file changed on disk", held: "not saved: see the note", refused: "not saved: see the note" };

/** Opens the page for editing or what was built. */
export function openTab(desk, name) {
  byId("app").dataset.tab = name;
  desk.view?.changed();
  desk.changed();
}

function savedWords(desk) {
  const { keeper, state } = desk;
  const name = state.path.split(/[\\/]/).at(-1);
  if (keeper.phase === "saved") return keeper.hasFile ? `saved in ${name}` : `nothing to save yet: ${name}`;
  return PHASES[keeper.phase];
}

/** Fills the bar and keeps it. */
export function topBar(desk, root, builder) {
  const { store, state } = desk;
  const saved = el("span", { id: "saved", role: "status" });
  const step = (name, words, list, act) => {
    const button = el("button", { type: "button", className: "icon", id: name, onclick: act }, icon(name));
    desk.listen(() => {
      const last = store[list].at(-1);
      button.disabled = !last;
      const title = last ? `${words}: ${last.words}` : words;
      button.title = title;
      button.setAttribute("aria-label", title);
    });
    return button;
  };
  const tab = (name, words) => {
    const button = el("button", { type: "button", id: `mode-${name}`, className: "mode", onclick: () => (name === "built" && !builder.view ? builder.show() : openTab(desk, name)) }, words);
    desk.listen(() => {
      button.setAttribute("aria-pressed", byId("app").dataset.tab === name);
      button.disabled = name === "built" && !builder.built?.tier;
    });
    return button;
  };
  const old = el("span", { className: "dim", id: "outdated" }, "changed since");
  const build = el("button", { type: "button", className: "main plain", id: "build", onclick: () => builder.start() }, "Build");
  desk.listen(() => {
    saved.textContent = savedWords(desk);
    saved.title = state.path;
    saved.dataset.phase = desk.keeper.phase;
    build.disabled = builder.isRunning() || !state.can_build || !desk.doc.parts.length || desk.keeper.faults.length > 0;
    const ready = desk.keeper.faults.length ? "Something is not right yet: see below the parts" : "Build the asset and judge it (Ctrl+Enter)";
    build.title = state.can_build ? ready : state.why_not ?? "It cannot be built here";
    old.hidden = !builder.built?.tier || !builder.built.revision || builder.built.revision === desk.keeper.revision;
  });
  root.append(el("div", { className: "brand" }, el("strong", {}, state.title), saved),
    el("div", { className: "modes" }, step("undo", "Undo", "past", () => store.undo()), step("redo", "Redo", "future", () => store.redo()), el("span", { className: "switch", role: "group", "aria-label": "Page" }, tab("edit", "Edit"), tab("built", "Built")), old),
    el("div", { className: "acts" }, build));
}
