// The object in words: its name, its figures, and the lists in their tabs.
import { counted, el, factList } from "./dom.js";
import { sub } from "./maths.js";
import { figure } from "./view.js";

/** What is known of the whole. */
export function aboutList(view, scene) {
  const box = view.model.box;
  const [x, y, z] = sub(box.high, box.low).map((v) => figure(v));
  const moving = view.model.joints.filter((_, j) => view.model.moves(j)).length;
  const said = [
    ["Links", String(scene.links.length)], ["Moving joints", String(moving)], ["Mass", `${figure(view.model.mass())} kg`],
    ["Size (x, y, z)", `${x} × ${y} × ${z} m`],
  ];
  return { count: null, body: factList([...said.map(([label, text]) => ({ label, text })), ...scene.about]) };
}

/** Tabs with their panels; the first that has something to say is open. */
export function tabs(root, all) {
  const list = el("div", { role: "tablist", "aria-label": "About the object" });
  const made = all.map(([name, { count, body }, urgent], i) => {
    const id = name.toLowerCase();
    const tab = el("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `panel-${id}`, onclick: () => open(i) },
      name, count === null ? null : el("span", { className: urgent ? "count urgent" : "count" }, String(count)));
    const panel = el("section", { role: "tabpanel", id: `panel-${id}`, "aria-labelledby": `tab-${id}`, tabIndex: 0 }, body);
    return { tab, panel };
  });
  const open = (i) => {
    made.forEach(({ tab, panel }, k) => {
      tab.setAttribute("aria-selected", k === i);
      tab.tabIndex = k === i ? 0 : -1;
      panel.hidden = k !== i;
    });
  };
  list.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    const at = (made.findIndex(({ tab }) => tab === document.activeElement) + step + made.length) % made.length;
    open(at);
    made[at].tab.focus();
  });
  list.append(...made.map((m) => m.tab));
  root.append(list, ...made.map((m) => m.panel));
  return open;
}

/** The object's name and how far it gets. */
export function heading(scene, root) {
  const { tier, checks } = scene;
  const [failed, unknown] = ["fail", "unknown"].map((s) => checks.filter((c) => c.status === s).length);
  const badge = tier
    ? el("span", { className: tier.reached[0] >= tier.reached[1] ? "tier good" : tier.reached[0] > 0 ? "tier part" : "tier bad", title: tier.profile }, tier.name === "none" ? "no tier" : `tier ${tier.name}`)
    : null;
  const facts = [counted(scene.links.length, "link"), counted(scene.joints.length, "joint")];
  if (failed) facts.push(`${counted(failed, "check")} failed`);
  if (unknown) facts.push(`${unknown} unknown`);
  if (checks.length && !failed && !unknown) facts.push("all checks hold");
  root.replaceChildren(el("h1", {}, scene.title || "unnamed"), el("p", {}, badge, el("span", {}, facts.join(" · "))));
}
