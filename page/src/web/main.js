// Puts the page together.
import { counted, el, factList } from "./dom.js";
import { inflated } from "./decode.js";
import { sub } from "./maths.js";
import { View, figure } from "./view.js";
import { keepLabels } from "./labels.js";
import { jointList } from "./joints.js";
import { findingList } from "./findings.js";
import { partList } from "./parts.js";
import { toolbar } from "./tools.js";
import { helpBox, keyboard, pointer } from "./keys.js";

const byId = (id) => document.getElementById(id);

function aboutList(view, scene) {
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
function tabs(root, all) {
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

function heading(scene) {
  const { tier, checks } = scene;
  const [failed, unknown] = ["fail", "unknown"].map((s) => checks.filter((c) => c.status === s).length);
  const badge = tier
    ? el("span", { className: tier.reached[0] >= tier.reached[1] ? "tier good" : tier.reached[0] > 0 ? "tier part" : "tier bad", title: tier.profile }, tier.name === "none" ? "no tier" : `tier ${tier.name}`)
    : null;
  const facts = [counted(scene.links.length, "link"), counted(scene.joints.length, "joint")];
  if (failed) facts.push(`${counted(failed, "check")} failed`);
  if (unknown) facts.push(`${unknown} unknown`);
  if (checks.length && !failed && !unknown) facts.push("all checks hold");
  byId("head").append(el("h1", {}, scene.title || "unnamed"), el("p", {}, badge, el("span", {}, facts.join(" · "))));
}

/** Says that something cannot be shown; what can be read stands in the panel. */
function tell(text) {
  const message = byId("message");
  message.textContent = text;
  message.hidden = false;
}

/** Without a picture there are still words. */
function withoutPicture(scene) {
  const still = { listen: () => {}, find: () => {}, found: null };
  const findings = findingList(still, scene.checks);
  const notes = scene.notes.map((n) => el("p", { className: "dim" }, n));
  findings.body.prepend(...notes);
  tabs(byId("panel"), [["Findings", findings, findings.count > 0], ["About", { count: null, body: factList(scene.about) ?? "" }, false]])(0);
}

async function begin() {
  const scene = JSON.parse(byId("scene").textContent);
  heading(scene);
  let view;
  try {
    const bytes = await inflated(byId("geometry").textContent.trim());
    if (!scene.links.length) throw new Error("nothing to show");
    view = new View(byId("canvas"), scene, bytes);
  } catch (error) {
    byId("app").dataset.state = "still";
    withoutPicture(scene);
    const why = { "no WebGL 2": "This browser offers no WebGL 2, which the picture needs: turn on hardware acceleration, or use a current Firefox, Chrome, Edge or Safari. Everything in words stands beside this.", "nothing to show": "There is no model to show. What could be said about the file stands beside this." };
    tell(why[error.message] ?? `The picture cannot be drawn: ${error.message}`);
    return;
  }
  const help = helpBox(byId("help"));
  const findings = findingList(view, scene.checks);
  const joints = jointList(view);
  if (scene.notes.length) tell(scene.notes.join(" "));
  const open = tabs(byId("panel"), [
    ["Joints", joints, false], ["Findings", findings, scene.checks.some((c) => c.status === "fail" || c.status === "unknown")],
    ["Parts", partList(view), false], ["About", aboutList(view, scene), false],
  ]);
  open(joints.count ? 0 : 1);
  toolbar(view, byId("tools"), help);
  keepLabels(view, byId("labels"));
  keyboard(view, scene.checks, help);
  pointer(view);
  byId("canvas").addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    tell("The graphics card was lost. Load the page again.");
  });
  view.listen(() => {
    byId("app").dataset.state = "ready";
  });
  view.changed();
}

begin();
