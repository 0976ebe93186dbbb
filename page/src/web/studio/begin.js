// Puts the studio together.
import { byId, el } from "../dom.js";
import { keepLabels } from "../labels.js";
import { Api } from "./api.js";
import { openTab, topBar } from "./bar.js";
import { Bench } from "./bench.js";
import { Body } from "./body.js";
import { Builder } from "./build.js";
import { Desk } from "./desk.js";
import { differences } from "./edits.js";
import { firstSteps } from "./first.js";
import { Floats } from "./floats.js";
import { Handles } from "./handles.js";
import { editHelp, editKeys, editTools, handsOn } from "./hands.js";
import { Keeper } from "./keeper.js";
import { Notices, askPerson, differenceTable } from "./notices.js";
import { partPanel } from "./panel.js";
import { photoPanel } from "./photo.js";
import { pinSource } from "./pins.js";
import { asks } from "./question.js";
import { sidePanel } from "./side.js";
import { Store } from "./store.js";
import { written } from "./text.js";

const NO_PICTURE = "This browser offers no WebGL 2, which the picture needs: turn on hardware acceleration, or use a current Firefox, Chrome, Edge or Safari. The parts can be edited as a form; points and axes need the picture.";
const WRONG_TOKEN = "This address does not open the studio any more: its token is of an earlier start. Open the address that the studio printed last. What was saved stands in the file.";
const EMPTY = { schema: "kinfold-condition/2", category: "", parts: [] };

/** Whether every part is one that this page can edit without losing a word of it. */
const isSound = (doc) => Array.isArray(doc?.parts) && doc.parts.every((p) => p && typeof p === "object" && typeof p.name === "string");

/** A document that has what the page counts on. */
const sound = (doc) => (isSound(doc) ? doc : structuredClone(EMPTY));

/** Whether a file says something that this page cannot show: saving would lose it. */
function isForeign({ text, document: doc }) {
  if (!text?.trim()) return false;
  return !isSound(doc) || (doc.parts.length === 0 && written(doc) !== text);
}

/** Numbers of parts, a byte or two each. */
function unpackLabels({ parts, width, faces, confidence }) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const raw = bytes(faces);
  return { parts, faces: width === 2 ? new Uint16Array(raw.buffer) : raw, confidence: bytes(confidence) };
}

/** The view, or nothing where this browser cannot draw. */
async function viewOf(api, state, palette, notices) {
  try {
    const body = new Body(await api.bytes("mesh"), state);
    return { body, view: new Bench(byId("canvas"), body, palette) };
  } catch (error) {
    notices.set("picture", error.message === "no WebGL 2" ? NO_PICTURE : `The picture cannot be drawn: ${error.message}`, { kind: "bad", stays: true });
    return { body: null, view: null };
  }
}

/** What is written on the picture for who does not know what to do next. */
function hint(desk) {
  const part = desk.part();
  if (desk.pulling) return desk.said;
  if (!part) return "";
  if (desk.keeper.work) return desk.keeper.work === "labelling" ? "Finding parts…" : "Finding joints…";
  if (desk.tool === "brush") return `Paint ${part.name}. Alt takes paint off, right drag turns.`;
  if (!part.point && !part.faces) return `Click on ${part.name} on the model.`;
  if (desk.doc.parts.length === 1) return "Add the parts that move: press a.";
  return "";
}

function follows(desk, builder) {
  const app = byId("app");
  desk.listen(() => {
    const { keeper, view } = desk;
    if (!view) app.dataset.state = "still";
    else if (keeper.work) app.dataset.state = keeper.work;
    else if (keeper.phase === "saving" || keeper.phase === "unsaved") app.dataset.state = "saving";
    else app.dataset.state = builder.isRunning() ? "building" : "ready";
    byId("hint").textContent = hint(desk);
    byId("said").textContent = desk.pulling ? "" : desk.said;
    byId("legend").hidden = view?.shows.look !== "sure";
  });
  desk.view?.listen(() => {
    byId("legend").hidden = desk.view.shows.look !== "sure";
  });
}

/** The document as it is now, in the picture. */
function shows(desk) {
  desk.view?.takesDoc(desk.doc, desk.found, desk.keeper.scale);
  if (desk.chosen >= desk.doc.parts.length) desk.chosen = desk.doc.parts.length - 1;
  desk.view?.chooses(desk.chosen, desk.joint);
  desk.changed();
}

function answers(desk, notices) {
  const { keeper, view } = desk;
  keeper.listen((name, what) => {
    if (name === "labels") {
      view?.label(unpackLabels(what));
      desk.notes = what.notes ?? [];
      shows(desk);
    } else if (name === "joints") {
      desk.found = what.joints;
      desk.notes = what.notes ?? [];
      shows(desk);
      asks(desk, notices, what.question);
    } else if (name === "conflict") conflict(desk, what);
    else if (name === "trouble") trouble(notices, what);
    else if (name === "phase" && what !== "saving" && what !== "unsaved") lost(notices, "file", what === "offline");
    desk.changed();
  });
}

function trouble(notices, error) {
  if (error.status === 401) notices.set("token", WRONG_TOKEN, { kind: "bad", stays: true });
  else notices.set("trouble", [error.message, error.hint].filter(Boolean).join(" "), { kind: "bad" });
}

/** One note for a studio that does not answer, whoever noticed. */
function lost(notices, what, is) {
  if (is) notices.lost.add(what);
  else notices.lost.delete(what);
  if (!notices.lost.size) notices.clear("gone");
  else if (!byId("notice-gone")) notices.set("gone", "The studio does not answer: is it still running? What you change is kept on this page and saved when it is back.", { kind: "bad", stays: true });
}

function conflict(desk, theirs) {
  const doc = sound(theirs.document);
  askPerson(byId("ask"), "The file changed on disk", [
    el("p", {}, `${desk.state.path} was written by somebody else while you were editing. Nothing was overwritten.`),
    differenceTable(differences(desk.doc, doc)),
  ], [["Keep mine", () => desk.keeper.keepMine(theirs)], ["Take theirs", () => desk.keeper.takeTheirs(theirs), true]]);
}

/** What the server tells on its own account. */
function events(desk, builder, notices) {
  const source = new EventSource(desk.api.address("events"));
  const on = (name, act) => source.addEventListener(name, (event) => act(JSON.parse(event.data)));
  let wasLost = false;
  on("stage", (said) => builder.stage(said));
  on("built", (said) => builder.done(said));
  on("condition", ({ revision }) => revision !== desk.keeper.revision && desk.keeper.looksAgain());
  on("tabs", ({ count }) => {
    if (count > 1) notices.set("tabs", `This studio is open in ${count} tabs. What one saves, the others take over.`);
    else notices.clear("tabs");
  });
  on("lost", () => desk.keeper.looksAgain());
  source.addEventListener("open", () => {
    lost(notices, "events", false);
    if (wasLost) desk.keeper.looksAgain();
    wasLost = false;
  });
  source.addEventListener("error", () => {
    wasLost = true;
    lost(notices, "events", true);
    if (source.readyState === EventSource.CLOSED) {
      setTimeout(() => {
        desk.keeper.looksAgain();
        events(desk, builder, notices);
      }, 3000);
    }
  });
}

function starts(desk, notices) {
  const { state } = desk;
  const { notes } = state.mesh;
  if (notes.length) notices.set("mesh", notes.join(" "));
  if (state.mesh.shown_faces < state.mesh.faces && !notes.length) notices.set("mesh", `The mesh has ${state.mesh.faces} faces; ${state.mesh.shown_faces} are shown here.`);
  desk.keeper.listen((name, phase) => {
    if (name !== "phase") return;
    if (phase !== "held" || !desk.keeper.comments) notices.clear("comments");
    else if (!byId("notice-comments")) notices.set("comments", `${state.path} has comments, which this page cannot keep. They stay in a copy beside it, whose name ends in .commented.`, { kind: "bad", stays: true, actions: [["Save", () => desk.keeper.agree()]] });
  });
}

/** Says what of a file can be edited here, now and whenever it changes on disk. */
function guards(keeper, notices, state) {
  keeper.guard = (now) => {
    const foreign = isForeign(now);
    if (foreign) notices.set("form", `${state.path} is no condition that this page can edit. It is left as it is.`, { kind: "bad", stays: true, actions: [["Start anew and replace it", () => keeper.agree()]] });
    else notices.clear("form");
    return { document: sound(now.document), isForeign: foreign };
  };
  keeper.guards(state);
}

async function open() {
  const notices = new Notices(byId("notices"));
  const api = new Api(new URLSearchParams(location.search).get("token") ?? "");
  const palette = JSON.parse(byId("palette").textContent);
  let state;
  try {
    state = await api.get("state");
  } catch (error) {
    byId("app").dataset.state = "still";
    return trouble(notices, error);
  }
  const store = new Store(sound(state.document));
  const keeper = new Keeper(api, store, state);
  guards(keeper, notices, state);
  const { body, view } = await viewOf(api, state, palette, notices);
  const desk = new Desk({ api, store, keeper, state, body, view });
  desk.palette = palette;
  const builder = new Builder(desk, notices, (tab) => openTab(desk, tab));
  const help = editHelp(byId("help"));
  const photo = state.photo && view ? photoPanel(byId("photo"), api.address("photo")) : null;
  store.listen(({ words }) => {
    if (words.startsWith("Undone") || words.startsWith("Done again")) desk.say(words);
    shows(desk);
  });
  answers(desk, notices);
  topBar(desk, byId("bar"), builder);
  sidePanel(desk, byId("side"));
  if (view) withPicture(desk, { help, photo });
  partPanel(desk, byId("panel"));
  firstSteps(desk);
  editKeys(desk, { help, photo, build: () => builder.start(), isOn: () => byId("app").dataset.tab === "edit" });
  starts(desk, notices);
  follows(desk, builder);
  shows(desk);
  events(desk, builder, notices);
  keeper.ask();
  builder.follow();
}

function withPicture(desk, { help, photo }) {
  const { view } = desk;
  const handles = new Handles(desk);
  const floats = new Floats(view, byId("pins"));
  view.takesDoc(desk.doc, desk.found, desk.keeper.scale);
  floats.from(pinSource(desk));
  floats.from(() => handles.source());
  handsOn(desk, handles);
  editTools(desk, byId("tools"), { help, photo });
  keepLabels(view, byId("labels"));
  byId("canvas").addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    desk.say("The graphics card was lost. Load the page again: everything is saved.");
  });
}

addEventListener("beforeunload", (event) => {
  if (/^not saved/.test(byId("saved")?.textContent ?? "")) event.preventDefault();
});

open();
