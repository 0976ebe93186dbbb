// Builds the asset, tells how far it is, and shows what became of it.
import { byId, el } from "../dom.js";
import { inflated } from "../decode.js";
import { View } from "../view.js";
import { keepLabels } from "../labels.js";
import { jointList } from "../joints.js";
import { findingList } from "../findings.js";
import { partList } from "../parts.js";
import { toolbar } from "../tools.js";
import { aboutList, heading, tabs } from "../overview.js";
import { helpBox, keyboard, pointer } from "../keys.js";
import { amend } from "./edits.js";

const STAGES = {
  "generate-mesh": "Mesh", "render-views": "Views", "propose-condition": "Condition", "select-prompts": "Points", "select-measures": "Sizes", articulate: "Parts and joints", criticise: "Second look",
  "shape-parts": "Shapes, collisions", "build-asset": "Masses", "check-in-sim": "Judging", "transfer-appearance": "Materials", "write-urdf": "URDF", "write-mjcf": "MJCF", "write-usd": "USD", "write-usdz": "USDZ", "write-glb": "GLB", "write-sdf": "SDF", "write-ros": "ROS 2", "write-isaaclab": "Isaac Lab", "write-simready": "SimReady", "write-page": "Page", "write-pictures": "Pictures",
};
const EXPORTS = ["mjcf", "usd", "glb"];

/** What stands for a view where there is no picture: findings are read as words. */
const STILL_VIEW = { listeners: [], found: null, model: null, load: () => {}, find: () => {}, listen: (callback) => callback() };

const wordsOf = (stage) => STAGES[stage] ?? stage.replaceAll("-", " ");

export class Builder {
  constructor(desk, notices, open) {
    Object.assign(this, { desk, notices, open });
    this.running = desk.state.building;
    this.stages = new Map();
    this.built = desk.state.built;
    this.remedied = new Set();
    this.view = null;
    this.card = byId("progress");
  }

  isRunning() {
    return Boolean(this.running);
  }

  async start() {
    const { desk } = this;
    if (this.running || !desk.state.can_build || !desk.doc.parts.length) return;
    this.running = { build: null };
    this.stages.clear();
    this.isCancelled = false;
    this.follow();
    try {
      await desk.keeper.save();
      this.running = await desk.api.post("build", { revision: desk.keeper.revision, export: EXPORTS });
      this.revision = desk.keeper.revision;
    } catch (error) {
      this.running = null;
      const first = error.body?.faults?.[0]?.message;
      this.notices.set("build", `It cannot be built: ${first ?? error.message}${error.hint ? ` ${error.hint}` : ""}`, { kind: "bad" });
    }
    this.follow();
  }

  async cancel() {
    this.isCancelled = true;
    await this.desk.api.post("build/cancel").catch((error) => this.desk.say(error.message));
  }

  /** A stage begins or ends. */
  stage(said) {
    this.running ??= { build: said.build };
    this.running.build ??= said.build;
    if (said.build !== this.running.build) return;
    this.stages.set(said.stage, said);
    this.follow();
  }

  /** The build is over. */
  done(said) {
    this.running = null;
    this.built = { ...said, revision: this.revision ?? this.desk.keeper.revision };
    this.notices.clear("build");
    this.follow();
    if (said.tier !== null && said.tier !== undefined) {
      this.notices.set("place", [`The asset stands in ${said.out}.`, said.message].filter(Boolean).join(" "));
      this.show();
    }
    else if (this.isCancelled) this.desk.say("The build was cancelled.");
    else this.notices.set("build", `Not built: ${said.message}`, { kind: "bad" });
  }

  /** The card of progress; its button stays the same, or a click could fall between two. */
  follow() {
    const { card } = this;
    card.hidden = !this.running;
    this.desk.changed();
    if (!this.running) return;
    if (!card.firstChild) this.makeCard();
    const list = [...this.stages.values()];
    const last = list.at(-1);
    const rows = list.slice(-6).map((s) => el("li", { className: s.state }, el("span", {}, wordsOf(s.stage)), el("span", { className: "dim" }, { running: "…", done: "done", kept: "kept", failed: "failed" }[s.state] ?? s.state)));
    const [count, bar, rest] = this.parts;
    count.textContent = last ? `${last.done} of ${last.of}` : "starting";
    bar.value = last ? last.done / Math.max(last.of, 1) : 0;
    rest.replaceChildren(...rows);
  }

  makeCard() {
    this.parts = [el("span", { className: "dim" }), el("progress", { max: 1, "aria-label": "How far the build is" }), el("ul", {})];
    const [count, bar, rest] = this.parts;
    const cancel = el("button", { type: "button", id: "cancel-build", onclick: () => this.cancel() }, "Cancel");
    this.card.append(el("div", { className: "row" }, el("strong", {}, "Building"), count, cancel), bar, rest);
  }

  /** Shows what was built. */
  async show() {
    let said;
    try {
      said = await this.desk.api.get("built");
      await this.fill(said);
    } catch (error) {
      this.notices.set("build", error.message, { kind: "bad" });
      return;
    }
    this.open("built");
  }

  async fill({ scene, geometry, remedies }) {
    this.remedies = remedies ?? [];
    const bytes = await inflated(geometry);
    const view = this.canvas() ?? STILL_VIEW;
    view.listeners.length = 0;
    view.load(scene, bytes);
    const findings = findingList(view, scene.checks, (check, at) => this.buttons(check, at));
    const urgent = scene.checks.some((c) => c.status === "fail" || c.status === "unknown");
    const lists = view.model ? [["Joints", jointList(view), false], ["Parts", partList(view), false], ["About", aboutList(view, scene), false]] : [];
    byId("verdict").replaceChildren();
    tabs(byId("verdict"), [["Findings", findings, urgent], ...lists])(0);
    heading(scene, byId("built-head"));
    byId("built-tools").replaceChildren();
    byId("built-labels").replaceChildren();
    if (view.model) {
      toolbar(view, byId("built-tools"), this.help);
      keepLabels(view, byId("built-labels"));
    }
    view.listen(() => {
      byId("built").dataset.state = "ready";
    });
  }

  /** The view of what was built; nothing where this browser cannot draw. */
  canvas() {
    if (this.view || !this.desk.view) return this.view;
    this.view = new View(byId("built-canvas"));
    this.help = helpBox(byId("built-help"));
    keyboard(this.view, this.help, () => byId("app").dataset.tab === "built");
    pointer(this.view);
    return this.view;
  }

  /** The remedies of a piece of evidence. */
  buttons(check, at) {
    return this.remedies.filter((r) => r.check === check.id && r.evidence === at).map((remedy) => {
      const button = el("button", { type: "button", className: "remedy", onclick: () => this.remedy(remedy, button) }, remedy.label);
      return button;
    });
  }

  remedy(remedy, button) {
    const { desk } = this;
    if (!desk.store.edit(`remedy: ${remedy.label}`, (doc) => amend(doc, remedy))) return desk.say("The condition says that already.");
    button.classList.add("done");
    const set = Object.entries(remedy.set).map(([field, value]) => (value === null ? `${field} taken away` : `${field} ${JSON.stringify(value)}`)).join(", ");
    desk.say(`Changed ${remedy.part}: ${set}. Build again to judge it anew.`);
  }
}
