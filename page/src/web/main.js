// Puts the page together.
import { byId, el, factList } from "./dom.js";
import { inflated } from "./decode.js";
import { View } from "./view.js";
import { keepLabels } from "./labels.js";
import { jointList } from "./joints.js";
import { findingList } from "./findings.js";
import { partList } from "./parts.js";
import { toolbar } from "./tools.js";
import { aboutList, heading, tabs } from "./overview.js";
import { helpBox, keyboard, pointer } from "./keys.js";

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
  heading(scene, byId("head"));
  let view;
  try {
    const bytes = await inflated(byId("geometry").textContent.trim());
    if (!scene.links.length) throw new Error("nothing to show");
    view = new View(byId("canvas"));
    view.load(scene, bytes);
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
  keyboard(view, help);
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
