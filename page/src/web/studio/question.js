// The one question whose answer would help most: a note with an answer a button.
import { el } from "../dom.js";
import { answer } from "./edits.js";

/** What promises less than this is not worth a person's time; a guess. */
const LEAST_GAIN = 0.1;
const BY_PLACE = "Which part is the surface at the question mark of?";

/** Names, the first few of them. */
const listed = (names) => (names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", "));

const askedKey = (asked) => JSON.stringify([asked.part, asked.words]);

/** Puts a question to the person, or takes back the last one where there is none. What was waved away stays away. */
export function asks(desk, notices, asked) {
  desk.question = null;
  notices.clear("question");
  desk.waved ??= new Set();
  if (!asked || asked.gain < LEAST_GAIN || desk.waved.has(askedKey(asked))) return;
  desk.question = asked;
  const toAll = asked.siblings?.length ? el("input", { type: "checkbox", checked: true }) : null;
  const takes = (choice) => () => {
    const { change, also = [] } = choice;
    const changes = toAll?.checked ? [change, ...also] : [change];
    asks(desk, notices, null);
    desk.store.edit(`${change.part}: a question answered`, (doc) => changes.forEach((one) => answer(doc, one)));
    desk.choose(desk.doc.parts.findIndex((p) => p.name === change.part), change.index ?? 0);
  };
  const waves = () => {
    desk.waved.add(askedKey(asked));
    asks(desk, notices, null);
    desk.view?.changed();
  };
  const actions = asked.answers.map((choice) => [choice.words, takes(choice)]);
  notices.set("question", asked.at ? BY_PLACE : asked.words.replaceAll("`", ""), { actions, kind: "question", gone: waves, more: toAll && el("label", {}, toAll, `so for ${listed(asked.siblings)}`) });
}

/** Where on the object it is about, as a pin. */
export function questionPins(desk) {
  const asked = desk.question;
  if (!asked?.at) return [];
  const part = desk.doc.parts.findIndex((p) => p.name === asked.part);
  const at = desk.view.nowAt(desk.body.objectOf(asked.at), part);
  const make = () => el("div", { className: "pin asked", title: BY_PLACE }, el("span", { className: "dot" }, "?"));
  return [{ key: "question", at, make, update: () => {} }];
}
