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

const STAGES = { "segment": "Finding parts", "articulate": "Finding joints", "shape-parts": "Shapes and collisions", "build-asset": "Masses and materials", "check": "Judging", "export": "Writing files" };
const EXPORTS = ["mjcf", "usd", "glb"];

const wordsOf = (stage) => STAGES[stage] ?? stage.replaceAll("-", " ");

export class Builder {
  constructor(desk, notices, open) {
    Object.assign(this, { desk, notices, open });
    this.running = desk.state.building;
    this.stages = new Map();
    this.built = desk.state.built;
    this.remedied = new Set();
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
    if (said.tier !== null && said.tier !== undefined) this.show();
    else this.notices.set("build", `Not built: ${said.message}`, { kind: "bad" });
  }

  /** The card of progress. */
  follow() {
    const { card } = this;
    card.hidden = !this.running;
    this.desk.changed();
    if (!this.running) return;
    const list = [...this.stages.values()];
    const last = list.at(-1);
    const share = last ? last.done / Math.max(last.of, 1) : 0;
    const rows = list.slice(-5).map((s) => el("li", { className: s.state }, el("span", {}, wordsOf(s.stage)), el("span", { className: "dim" }, { running: "…", done: "done", kept: "kept", failed: "failed" }[s.state] ?? s.state)));
    card.replaceChildren(
      el("div", { className: "row" }, el("strong", {}, "Building"), el("span", { className: "dim" }, last ? `${last.done} of ${last.of}` : "starting"), el("button", { type: "button", id: "cancel-build", onclick: () => this.cancel() }, "Cancel")),
      el("progress", { max: 1, value: share, "aria-label": "How far the build is" }), el("ul", {}, ...rows));
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
    if (!this.view) this.begin();
    const { view } = this;
    view.listeners.length = 0;
    view.load(scene, bytes);
    const findings = findingList(view, scene.checks, (check, at) => this.buttons(check, at));
    const urgent = scene.checks.some((c) => c.status === "fail" || c.status === "unknown");
    byId("verdict").replaceChildren();
    const open = tabs(byId("verdict"), [["Findings", findings, urgent], ["Joints", jointList(view), false], ["Parts", partList(view), false], ["About", aboutList(view, scene), false]]);
    open(0);
    heading(scene, byId("built-head"));
    byId("built-tools").replaceChildren();
    toolbar(view, byId("built-tools"), this.help);
    byId("built-labels").replaceChildren();
    keepLabels(view, byId("built-labels"));
    view.listen(() => {
      byId("built").dataset.state = "ready";
    });
  }

  begin() {
    this.view = new View(byId("built-canvas"));
    this.help = helpBox(byId("built-help"));
    keyboard(this.view, this.help, () => byId("app").dataset.tab === "built");
    pointer(this.view);
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
