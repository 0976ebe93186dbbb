// The scene on the screen: what is shown, who turns it, what lies under the pointer.
import { add, clamp, corners, emptyBox, grow, isBox, matrix, middle, outside, scale, size, sub, through } from "./maths.js";
import { unpack } from "./decode.js";
import { shaded } from "./surface.js";
import { Model } from "./model.js";
import { Camera, SIDES } from "./camera.js";
import { Renderer } from "./render.js";
import { Marks } from "./marks.js";

export const THEMES = {
  light: { high: [0.955, 0.965, 0.98], low: [0.845, 0.867, 0.9], ink: [0.1, 0.14, 0.22], chalk: [0.1, 0.14, 0.22], shadow: 0.26, grid: 0.07, lift: 0.62, mark: [0.8, 0.07, 0.12], mass: [0.12, 0.15, 0.2] },
  dark: { high: [0.15, 0.167, 0.195], low: [0.09, 0.1, 0.118], ink: [0, 0, 0], chalk: [1, 1, 1], shadow: 0.5, grid: 0.055, lift: 1.18, mark: [1, 0.33, 0.33], mass: [0.92, 0.94, 0.97] },
};
/** Seconds of one way of a joint that plays. */
const LEG = 1.3;

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new Renderer(canvas);
    this.visuals = [];
    this.pieces = [];
    this.marks = null;
    this.camera = new Camera();
    this.shows = { look: "parts", axes: true, masses: false, collision: false, labels: false, xray: false, apart: 0 };
    this.listeners = [];
    this.calm = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.addEventListener("change", () => this.changed());
    new ResizeObserver(() => this.changed()).observe(canvas);
  }

  /** Takes a scene and the bytes of its surfaces, in place of what there was. */
  load(scene, bytes) {
    const surface = (packed) => shaded(unpack(bytes, packed));
    const seen = scene.links.map((l) => l.visual && surface(l.visual));
    const pieces = scene.links.map((l) => l.collisions.map(surface));
    const boxes = scene.links.map((_, l) => {
      const box = emptyBox();
      const shown = seen[l] ? [seen[l]] : pieces[l];
      shown.forEach((s) => isBox(s.box) && [s.box.low, s.box.high].forEach((p) => grow(box, p)));
      return box;
    });
    [...this.visuals, ...this.pieces.flat()].forEach((mesh) => this.renderer.forget(mesh));
    this.visuals = seen.map((s) => s && this.renderer.mesh(s));
    this.pieces = pieces.map((all) => all.map((s) => this.renderer.mesh(s)));
    this.takes(scene, new Model(scene, boxes));
  }

  /** Shows a scene whose surfaces are on the card. */
  takes(scene, model) {
    this.scene = scene;
    this.model = model;
    if (this.marks) this.marks.of(model);
    else this.marks = new Marks(this.renderer, model);
    this.camera.knows(model.box);
    this.apart = 0;
    this.hidden = new Set();
    this.selected = -1;
    this.active = -1;
    this.found = null;
    this.playing = null;
    this.fresh = true;
    this.changed();
  }

  theme() {
    return this.dark.matches ? THEMES.dark : THEMES.light;
  }

  /** Calls back after every frame. */
  listen(callback) {
    this.listeners.push(callback);
  }

  /** Something is not as it was drawn. */
  changed() {
    this.waiting ??= requestAnimationFrame((now) => this.frame(now));
  }

  show(name, value) {
    this.shows[name] = value;
    this.changed();
  }

  set(j, value) {
    this.model.set(j, value);
    this.active = j;
    this.changed();
  }

  /** Every joint as the file has it. */
  rest() {
    this.model.values.fill(0);
    this.playing = null;
    this.found = null;
    this.changed();
  }

  select(link) {
    this.selected = link;
    this.changed();
  }

  hide(link, is) {
    if (is) this.hidden.add(link);
    else this.hidden.delete(link);
    this.changed();
  }

  /** Goes to what was found: its pose, its place, its links. */
  find(evidence, id) {
    this.playing = null;
    this.model.values.fill(0);
    for (const [j, value] of evidence.pose) {
      this.model.set(j, value);
      this.active = j;
    }
    this.found = { ...evidence, id, since: performance.now() };
    if (evidence.place) {
      const poses = this.model.poses();
      const at = outside(poses[evidence.place[0]], evidence.place[1]);
      const near = this.camera.fitting(this.boxNow(), this.aspect(), this.tall());
      this.camera.go({ target: add(scale(at, 0.65), scale(near.target, 0.35)), distance: 0.75 * near.distance }, this.calm);
    }
    this.changed();
  }

  boxNow() {
    return this.model.boxAt(this.model.poses());
  }

  aspect() {
    return this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
  }

  /** The share of the height that words and tools leave free. */
  tall() {
    return clamp(1 - 150 / Math.max(this.canvas.clientHeight, 1), 0.5, 0.86);
  }

  /** Puts everything into the view, from a side if one is named. */
  look(side) {
    const goal = this.camera.fitting(this.boxNow(), this.aspect(), this.tall(), SIDES[side]);
    this.camera.go(goal, this.calm);
    this.changed();
  }

  /** Puts one part into the view. */
  lookAt(link) {
    const box = emptyBox();
    const own = this.model.boxes[link];
    const pose = this.placed()[link];
    if (!isBox(own)) return;
    corners(own).forEach((p) => grow(box, outside(pose, p)));
    const goal = this.camera.fitting(box, this.aspect());
    this.camera.go({ ...goal, distance: Math.max(1.4 * goal.distance, 0.05 * this.model.diagonal) }, this.calm);
    this.changed();
  }

  /** Where every link is drawn. */
  placed() {
    const poses = this.model.poses();
    const offsets = this.model.apart(poses, this.apart);
    return poses.map((pose, l) => ({ at: add(pose.at, offsets[l]), turn: pose.turn }));
  }

  /** Lets joints go through their ranges, one after the other; all of them if none is named. */
  play(joints) {
    const list = joints ?? this.model.movable();
    this.playing = list.length ? { list, at: 0, seconds: 0 } : null;
    if (this.playing) this.found = null;
    this.changed();
  }

  stop() {
    this.playing = null;
    this.changed();
  }

  /** The stops on the way of a joint that plays. */
  way(j) {
    const [low, high] = this.model.ends(j);
    if (this.model.joints[j].kind === "continuous") return [0, 2 * Math.PI];
    const stops = Math.abs(high) >= Math.abs(low) ? [0, high, low, 0] : [0, low, high, 0];
    return stops.filter((v, i) => i === 0 || Math.abs(v - stops[i - 1]) > 1e-9);
  }

  advance(seconds) {
    const { playing } = this;
    if (!playing) return;
    const j = playing.list[playing.at];
    const stops = this.way(j);
    const length = LEG * (this.model.joints[j].kind === "continuous" ? 2 : 1);
    playing.seconds += seconds;
    const leg = Math.floor(playing.seconds / length);
    if (leg >= stops.length - 1) {
      this.model.values[j] = 0;
      playing.at = (playing.at + 1) % playing.list.length;
      playing.seconds = 0;
      return;
    }
    const k = playing.seconds / length - leg;
    const eased = k * k * (3 - 2 * k);
    this.model.values[j] = stops[leg] + (stops[leg + 1] - stops[leg]) * eased;
    this.active = j;
  }

  frame(now) {
    this.waiting = null;
    if (!this.model) return;
    const seconds = Math.min((now - (this.last ?? now)) / 1000, 0.1);
    this.last = now;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    this.renderer.fit(ratio);
    if (this.fresh && this.canvas.clientWidth > 1) {
      this.camera.go(this.camera.fitting(this.boxOfMotion(), this.aspect(), this.tall()), false);
      this.fresh = false;
    }
    this.advance(seconds);
    let moving = this.camera.step(seconds || 1 / 60);
    const left = this.shows.apart - this.apart;
    this.apart = Math.abs(left) < 0.002 || !this.calm ? this.shows.apart : this.apart + left * Math.min(9 * (seconds || 1 / 60), 1);
    this.camera.spread = 1 + 0.5 * this.apart;
    moving ||= this.apart !== this.shows.apart || this.playing !== null;
    moving ||= this.calm && this.found?.place && now - this.found.since < 2400;
    this.renderer.draw(this.content(now, ratio));
    this.listeners.forEach((callback) => callback());
    if (moving) this.changed();
    else this.last = undefined;
  }

  /** The box of all that is seen, with every joint at either end a little. */
  boxOfMotion() {
    const box = emptyBox();
    [this.model.box.low, this.model.box.high].forEach((p) => grow(box, p));
    for (const j of this.model.movable()) {
      for (const end of this.model.ends(j)) {
        this.model.values[j] = 0.5 * end;
        const moved = this.model.boxAt(this.model.poses());
        [moved.low, moved.high].forEach((p) => grow(box, p));
      }
      this.model.values[j] = 0;
    }
    const rest = this.model.box;
    return { low: box.low.map((v, i) => 0.55 * rest.low[i] + 0.45 * v), high: box.high.map((v, i) => 0.55 * rest.high[i] + 0.45 * v) };
  }

  /** All there is to draw. */
  content(now, ratio) {
    const theme = this.theme();
    const camera = this.camera.matrices(this.aspect());
    this.both = camera.both;
    const poses = this.placed();
    const box = this.model.boxAt(poses);
    const floor = this.model.box.low[2];
    const wide = Math.max(size(sub(box.high, box.low)), this.model.diagonal);
    const step = 10 ** Math.floor(Math.log10(this.model.diagonal / 2.5));
    const frame = {
      camera, theme, ratio, eye: this.camera.eye(), reach: 0.07 * this.model.diagonal,
      box: { low: [box.low[0], box.low[1], Math.min(floor, box.low[2])], high: box.high },
      ground: { centre: [...middle(box).slice(0, 2), floor - 0.0005 * this.model.diagonal], radius: 2.2 * wide, step },
      solid: [], sheer: [], marks: [], lines: [], spots: [], rings: [],
    };
    this.tags = [];
    this.bodies(frame, poses, theme);
    if (this.shows.axes) this.jointMarks(frame, poses, theme);
    if (this.apart > 0) this.threads(frame, poses);
    if (this.shows.masses) this.massMarks(frame, poses, theme, floor);
    if (this.shows.labels) this.names(poses);
    if (this.found?.place) this.spot(frame, poses, theme, now);
    return frame;
  }

  bodies(frame, poses, theme) {
    const about = this.found ? new Set(this.found.links) : null;
    this.touchable = [];
    this.visuals.forEach((mesh, l) => {
      if (this.hidden.has(l)) return;
      const place = matrix(poses[l]);
      const colour = this.scene.links[l].colour.map((c) => c / 255);
      const tint = [...colour, this.shows.look === "parts" ? 1 : 0];
      const lit = l === this.selected ? 1 : 0;
      const aside = about && about.size && !about.has(l);
      if (mesh) {
        const item = { mesh, matrix: place, tint, alpha: 1, glow: lit, link: l };
        this.touchable.push(item);
        if (this.shows.xray || this.shows.collision) frame.sheer.push({ ...item, alpha: this.shows.collision ? 0.18 : 0.3 });
        else if (aside) frame.sheer.push({ ...item, alpha: 0.35 });
        else frame.solid.push(item);
      }
      if (this.shows.collision || !mesh) this.colliders(frame, l, place, colour, lit);
    });
  }

  colliders(frame, l, place, colour, lit) {
    this.pieces[l].forEach((mesh, i) => {
      const shade = 0.72 + 0.28 * (((i * 5) % 7) / 6);
      const item = { mesh, matrix: place, tint: [...colour.map((c) => c * shade), 1], alpha: 1, glow: lit, link: l, ahead: true };
      frame.solid.push(item);
      this.touchable.push(item);
    });
  }

  markColour(l, theme) {
    const lift = theme.lift;
    return this.scene.links[l].colour.map((c) => clamp((c / 255) * lift + (lift > 1 ? 0.12 : 0), 0, 1));
  }

  jointMarks(frame, poses, theme) {
    this.model.joints.forEach((joint, j) => {
      if (!this.model.moves(j) || this.hidden.has(joint.child)) return;
      const colour = this.markColour(joint.child, theme);
      this.marks.joint(frame, j, poses[joint.parent], colour, j === this.active);
    });
  }

  /** Lines from where parts are to where they belong. */
  threads(frame, poses) {
    const home = this.model.poses();
    const offsets = this.model.apart(home, this.apart);
    this.model.joints.forEach(({ parent, child }) => {
      const own = this.model.boxes[child];
      if (!isBox(own) || this.hidden.has(child)) return;
      const to = outside(poses[child], middle(own));
      const from = sub(to, sub(offsets[child], offsets[parent]));
      frame.lines.push([from, to, [...this.scene.links[child].colour.map((c) => c / 255), 0.8], 1.5]);
    });
  }

  massMarks(frame, poses, theme, floor) {
    const heaviest = Math.max(...this.scene.links.map((l) => l.inertial?.mass ?? 0));
    let [sum, moment] = [0, [0, 0, 0]];
    this.scene.links.forEach(({ inertial, colour }, l) => {
      if (!inertial || this.hidden.has(l)) return;
      const at = this.marks.mass(frame, inertial, poses[l], heaviest, this.markColour(l, theme));
      this.tags.push({ text: `${figure(inertial.mass)} kg`, at, colour });
      sum += inertial.mass;
      moment = add(moment, scale(at, inertial.mass));
    });
    if (sum > 0) this.marks.whole(frame, scale(moment, 1 / sum), floor, theme.mass);
  }

  names(poses) {
    this.scene.links.forEach(({ name, colour }, l) => {
      if (this.hidden.has(l)) return;
      const at = isBox(this.model.boxes[l]) ? outside(poses[l], middle(this.model.boxes[l])) : poses[l].at;
      this.tags.push({ text: name, at, colour, strong: l === this.selected });
    });
  }

  spot(frame, poses, theme, now) {
    const [link, point] = this.found.place;
    const at = outside(poses[link], point);
    const pulse = this.calm ? ((now - this.found.since) / 1200) % 1 : 0.5;
    this.marks.spot(frame, at, this.camera, theme.mark, clamp(pulse, 0, 1));
    this.tags.unshift({ text: this.found.id, at, mark: true });
  }

  /** Where a point is on the screen, in CSS pixels; nothing behind the eye. */
  onScreen(p) {
    const [x, y, , w] = through(this.both, p);
    if (w <= 0) return null;
    return [(0.5 + (0.5 * x) / w) * this.canvas.clientWidth, (0.5 - (0.5 * y) / w) * this.canvas.clientHeight];
  }

  /** The link under a place of the canvas, in CSS pixels, and the point of it; nothing if there is none. */
  pick(x, y) {
    if (!this.both) return null;
    const ratio = this.canvas.width / this.canvas.clientWidth;
    const pixel = [x, y].map((v) => Math.floor(v * ratio));
    const found = this.renderer.pick(this.touchable, this.both, pixel);
    return found && { link: found.item.link, depth: found.depth };
  }
}

/** A figure with three digits that count. */
export function figure(value) {
  if (!Number.isFinite(value)) return "?";
  const text = Math.abs(value) >= 1000 ? value.toFixed(0) : value.toPrecision(3);
  return text.includes("e") ? text : String(Number(text));
}
