// What was checked, the worst first; a click goes to where it was found.
import { counted, el } from "./dom.js";

const RANK = { fail: 0, unknown: 1, warn: 2, waived: 3, pass: 4 };
const MARKS = { fail: "✕", unknown: "?", warn: "!", waived: "~", pass: "✓" };

function evidence(view, check, one, remedies) {
  const leads = one.pose.length || one.place || one.links.length;
  if (!leads) return el("li", {}, one.text, ...remedies);
  const go = el("button", { type: "button", className: "go", onclick: () => view.find(one, check.id) }, one.text);
  view.listen(() => go.setAttribute("aria-pressed", view.found !== null && view.found.text === one.text && view.found.id === check.id));
  return el("li", {}, go, ...remedies);
}

function entry(view, check, remedies) {
  const figures = [check.figure && `found ${check.figure}`, check.bound && `expected ${check.bound}`].filter(Boolean);
  const list = check.evidence.length ? el("ul", {}, ...check.evidence.map((e, i) => evidence(view, check, e, remedies(check, i)))) : null;
  const head = [
    el("span", { className: `mark ${check.status}`, title: check.status, role: "img", "aria-label": check.status }, MARKS[check.status]),
    el("span", { className: "id" }, check.id), el("span", { className: "rule" }, check.rule),
  ];
  if (check.status === "pass" && !list) return el("div", { className: "check pass" }, el("div", { className: "row" }, ...head));
  const body = el("details", { className: `check ${check.status}`, open: check.status !== "pass" }, el("summary", {}, ...head),
    figures.length ? el("p", { className: "dim" }, figures.join(", ")) : null, list);
  return body;
}

/** All findings that lead somewhere, in order. */
export function findable(checks) {
  const sorted = checks.filter((c) => c.status !== "pass").sort((a, b) => RANK[a.status] - RANK[b.status]);
  return sorted.flatMap((check) => check.evidence.filter((e) => e.pose.length || e.place).map((one) => ({ id: check.id, one })));
}

/** The list of checks; `remedies` gives what stands below a piece of evidence. */
export function findingList(view, checks, remedies = () => []) {
  const count = (status) => checks.filter((c) => c.status === status).length;
  const open = checks.filter((c) => c.status !== "pass").sort((a, b) => RANK[a.status] - RANK[b.status]);
  const passed = checks.filter((c) => c.status === "pass");
  const words = Object.keys(RANK).filter((s) => count(s)).map((s) => `${count(s)} ${s}`);
  const body = el("div", {},
    checks.length ? el("p", { className: "dim" }, words.join(" · ")) : el("p", { className: "dim" }, "Nobody checked this object."),
    ...open.map((c) => entry(view, c, remedies)),
    passed.length ? el("details", { className: "passed", open: !open.length }, el("summary", {}, `${counted(passed.length, "check")} passed`), ...passed.map((c) => entry(view, c, remedies))) : null);
  return { count: open.length, body };
}
