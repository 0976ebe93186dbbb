// Elements, made of names, texts and other elements. Texts are only ever texts.

export const byId = (id) => document.getElementById(id);

/** An element: `properties` are set as they are, `on…` are listened to, `aria-…` and `data-…` written. */
export function el(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "style") Object.entries(value).forEach(([k, v]) => made.style.setProperty(k, v));
    else if (name.includes("-") || name === "role" || name === "for") made.setAttribute(name, value);
    else made[name] = value;
  }
  made.append(...children.filter((c) => c !== undefined && c !== null));
  return made;
}

const SVG = "http://www.w3.org/2000/svg";

/** Small pictures, as paths in a square of 24. */
const ICONS = {
  play: "M8 5v14l11-7z",
  pause: "M7 5h4v14H7zM13 5h4v14h-4z",
  eye: "M12 5C6 5 2.5 12 2.5 12S6 19 12 19s9.500-7 9.500-7S18 5 12 5zm0 11.200a4.200 4.200 0 1 1 0-8.400 4.200 4.200 0 0 1 0 8.400z",
  axes: "M11 3h2v9l7.500 4.300-1 1.800L12 13.800l-7.500 4.300-1-1.800L11 12z",
  mass: "M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zm0 2v7h7a7 7 0 0 1-7 7v-7H5a7 7 0 0 1 7-7z",
  hull: "M12 2 3 7v10l9 5 9-5V7zm0 2.300L18.200 7.700 12 11.200 5.800 7.700zM5 9.500l6 3.300v6.500l-6-3.300zm8 9.800v-6.500l6-3.300V16z",
  labels: "M4 4h9l7 8-7 8H4zm2 2v12h6.100l5.300-6-5.300-6z",
  xray: "M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4zM9 9h6v6H9z",
  fit: "M4 9V4h5v2H6v3zm11-5h5v5h-2V6h-3zM4 15h2v3h3v2H4zm14 0h2v5h-5v-2h3z",
  reset: "M12 5V1L7 6l5 5V7a5 5 0 1 1-5 5H5a7 7 0 1 0 7-7z",
  undo: "M9 5 4 10l5 5v-3.500h4.500a3 3 0 0 1 0 6H9V20h4.500a5.500 5.500 0 0 0 0-11H9z",
  redo: "m15 5 5 5-5 5v-3.500h-4.500a3 3 0 0 0 0 6H15V20h-4.500a5.500 5.500 0 0 1 0-11H15z",
  close: "m6.400 5 5.600 5.600L17.600 5 19 6.400 13.400 12l5.600 5.600-1.400 1.400-5.600-5.600L6.400 19 5 17.600l5.600-5.600L5 6.400z",
  bin: "M9 3h6l1 2h4v2H4V5h4zM6 8h12l-1 13H7zm3 2 .4 9h1.600l-.300-9zm4 0-.300 9h1.600l.4-9z",
  plus: "M11 4h2v7h7v2h-7v7h-2v-7H4v-2h7z",
  point: "M12 2a7 7 0 0 0-7 7c0 5 7 13 7 13s7-8 7-13a7 7 0 0 0-7-7zm0 4.500a2.500 2.500 0 1 1 0 5 2.500 2.500 0 0 1 0-5z",
  brush: "M20.700 3.300a2 2 0 0 0-2.800 0L9 12.200l2.800 2.800 8.900-8.900a2 2 0 0 0 0-2.800zM7.600 13.600a3.500 3.500 0 0 0-3.500 3.500c0 1.500-1 2.400-2.100 2.700C3.200 21.200 5 22 7 22a4.200 4.200 0 0 0 3.500-6.200z",
  photo: "M3 5h18v14H3zm2 2v8.500l4-4 4 4 3-3 3 3V7zm10 1.500a1.500 1.500 0 1 1 0 3 1.500 1.500 0 0 1 0-3z",
  larger: "M14 4h6v6h-2V7.400l-4.300 4.300-1.400-1.400L16.600 6H14zM4 14h2v2.600l4.300-4.300 1.400 1.400L7.400 18H10v2H4z",
  help: "M11 17h2v2h-2zm1-12a4 4 0 0 0-4 4h2a2 2 0 1 1 3.200 1.600C11.800 11.700 11 12.600 11 15h2c0-1.500.700-2 1.600-2.800A4 4 0 0 0 12 5z",
};

/** A picture that says nothing to who cannot see it: the button around it has a name. */
export function icon(name) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", ICONS[name]);
  path.setAttribute("fill-rule", "evenodd");
  svg.append(path);
  return svg;
}

/** What is known and where from: labels and words. */
export function factList(lines) {
  if (!lines.length) return null;
  return el("dl", { className: "about" }, ...lines.flatMap(({ label, text }) => [el("dt", {}, label), el("dd", {}, text)]));
}

export const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;

/** `1 link`, `2 links`. */
export const counted = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;
