// Buttons under the picture.
import { el, icon } from "./dom.js";

/** What is switched on and off: name in `view.shows`, key, words, picture. */
export const SWITCHES = [
  ["axes", "a", "Axes and limits", "axes"],
  ["collision", "k", "Collision pieces", "hull"],
  ["masses", "m", "Masses and centres", "mass"],
  ["labels", "l", "Names", "labels"],
  ["xray", "x", "X-ray", "xray"],
];

/** Fills the toolbar. */
export function toolbar(view, root, help) {
  const play = el("button", { type: "button", className: "main", title: "Play all joints (space)", onclick: () => (view.playing ? view.stop() : view.play()) });
  let playing = null;
  view.listen(() => {
    if (Boolean(view.playing) === playing) return;
    playing = Boolean(view.playing);
    play.replaceChildren(icon(playing ? "pause" : "play"), el("span", {}, playing ? "Stop" : "Play"));
  });
  play.disabled = !view.model.movable().length;
  const look = (name, words) => {
    const button = el("button", { type: "button", onclick: () => view.show("look", name) }, words);
    view.listen(() => button.setAttribute("aria-pressed", view.shows.look === name));
    return button;
  };
  const switches = SWITCHES.map(([name, key, words, picture]) => {
    const button = el("button", { type: "button", className: "icon", title: `${words} (${key})`, "aria-label": words, onclick: () => view.show(name, !view.shows[name]) }, icon(picture));
    view.listen(() => button.setAttribute("aria-pressed", view.shows[name]));
    return button;
  });
  const apart = el("input", { type: "range", id: "apart", min: 0, max: 1, step: 0.01, value: 0, oninput: () => view.show("apart", Number(apart.value)) });
  view.listen(() => {
    if (Number(apart.value) !== view.shows.apart) apart.value = view.shows.apart;
    apart.style.setProperty("--fill", `${100 * view.shows.apart}%`);
    apart.style.setProperty("--rest", "0%");
  });
  const button = (name, words, act) => el("button", { type: "button", className: "icon", title: words, "aria-label": words, onclick: act }, icon(name));
  root.append(
    play,
    el("span", { className: "group", role: "group", "aria-label": "Colours" }, look("parts", "Parts"), look("true", "True look")),
    el("span", { className: "group", role: "group", "aria-label": "Show" }, ...switches),
    el("span", { className: "group slide" }, el("label", { htmlFor: "apart" }, "Explode"), apart),
    el("span", { className: "group" }, button("reset", "Back to rest (r)", () => view.rest()), button("fit", "Fit to view (f)", () => view.look()), button("help", "Keyboard shortcuts (?)", help)),
  );
}
