import { drawCaptionLens, drawGhost, drawLens, drawNames, drawNumbers, drawPanel, drawPodium } from "./overlays.js";
import { mixed, Pen, Turtle } from "./shapes.js";

/** @typedef {import("./shapes.js").Look} Look */
/** @typedef {import("./replay.js").Replay} Replay */
/** @typedef {import("./replay.js").Body} Body */
/** @typedef {import("./replay.js").Hunter} Hunter */
/** @typedef {import("./replay.js").Target} Target */
/** @typedef {import("./replay.js").Ruling} Ruling */
/** @typedef {import("./replay.js").Contest} Contest */
/** @typedef {{ x: number, y: number }} Point in metres, upwards */
/** @typedef {ReturnType<Replay["pose"]>} Pose */

/**
 * What is painted besides the match.
 * @typedef {object} Manner
 * @property {number | null} picked the seat of the selected hunter
 * @property {boolean} viewed true to show the view of the selected hunter
 * @property {boolean} calm true to paint nothing that pulses
 * @property {number} grows match time in which a lens grows, in milliseconds; 0 to show it in full
 * @property {boolean} over true to show the podium
 * @property {boolean} asked true to show what would have won a contest
 */

/**
 * The instant of a replay that is painted, and the scale from metres to pixels of the page.
 * @typedef {object} Scene
 * @property {Pen} pen
 * @property {CanvasRenderingContext2D} context
 * @property {Replay} replay
 * @property {number} time in milliseconds
 * @property {number} side of the picture
 * @property {number} scale pixels per metre
 * @property {(point: Point) => [number, number]} place
 * @property {number} length of a hunter
 * @property {number | null} picked
 */

const LASTS_MS = 900;
const TRAIL_MS = 1800;
/** Number of layers, each smaller than the one before, that make a view's edge soft. */
const LAYERS = 8;

/** Paints an instant of a replay, as render/ does: `look` comes from its tables. */
export class Painter {
  /** @param {Look} look */
  constructor(look) {
    this.look = look;
    this.turtle = new Turtle(look);
  }

  /**
   * Paint the whole arena.
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {number} time
   * @param {Manner} manner
   */
  paint(canvas, replay, time, { picked, viewed, calm, grows, over, asked }) {
    const pen = new Pen(canvas, this.turtle);
    const side = canvas.clientWidth;
    const scale = side / (replay.side * (1 + 2 * this.look.margin));
    const margin = this.look.margin * replay.side * scale;
    /** @type {Scene["place"]} */
    const place = ({ x, y }) => [margin + x * scale, side - margin - y * scale];
    const length = Math.max(this.look.hunterLength * scale, 18, side / 26);
    /** @type {Scene} */
    const scene = { pen, context: pen.context, replay, time, side, scale, place, length, picked };
    this.#ground(scene);
    if (viewed && picked !== null && !replay.withdrawn(picked, time)) this.#view(scene, picked);
    for (const target of replay.alive(time)) {
      if (target.prey !== null) this.#trail(scene, target, this.look.target, 0.1 * scene.length, 1);
      else if (target.moves) this.#trail(scene, target, this.look.targetTrail, 0.06 * scene.length, 1);
    }
    replay.hunters.forEach((hunter, seat) => {
      this.#trail(scene, hunter, hunter.color, 0.1 * scene.length, picked === null || picked === seat ? 1 : 4);
    });
    this.#targets(scene);
    replay.hunters.forEach((_, seat) => this.#hunter(scene, seat));
    const recent = replay.rulings.filter((ruling) => ruling.time < time && time - ruling.time < LASTS_MS);
    for (const ruling of recent) this.#ruling(scene, ruling, calm);
    const agents = this.#agents(scene);
    drawNames(pen, this.look, agents, side, length);
    drawNumbers(pen, this.look, agents, length);
    const caption = replay.captionAt(time, this.look.captionMs);
    if (over) {
      drawPodium(pen, this.look, replay, side);
      return;
    }
    if (caption) drawCaptionLens(pen, this.look, replay, caption, side, time - caption.time, grows);
    const answer = asked ? replay.answerAt(time, this.look.answerMs) : null;
    if (answer) {
      drawGhost(pen, replay, answer, time, place, length);
      drawPanel(pen, this.look, replay, answer, side, true);
    } else if (caption) drawPanel(pen, this.look, replay, caption, side);
  }

  /**
   * Paint the lens of a contest on a canvas of its own.
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {Contest} contest
   */
  closeUp(canvas, replay, contest) {
    const pen = new Pen(canvas, this.turtle);
    const side = canvas.clientWidth;
    pen.context.clearRect(0, 0, side, side);
    drawLens(pen, this.look, replay, contest, 0, 0, side);
  }

  /**
   * Return the hunters and the prey that are alive, with their places in the picture.
   * @param {Scene} scene
   */
  #agents({ replay, time, scale, place }) {
    const hunters = replay.hunters.map((hunter, seat) => ({
      ...hunter,
      reach: hunter.reach * scale,
      number: String(seat),
      hunted: false,
      body: hunter,
    }));
    const prey = replay.alive(time).flatMap((body) =>
      body.prey === null ? [] : {
        name: replay.prey[body.prey].name,
        color: this.look.target,
        reach: 0,
        number: `P${body.prey}`,
        hunted: true,
        body,
      }
    );
    return [...hunters, ...prey].map(({ body, ...agent }) => {
      const [x, y] = place(replay.pose(body, time));
      return { ...agent, x, y };
    });
  }

  /** @param {Scene} scene */
  #targets(scene) {
    const { pen, replay, time, place, length } = scene;
    const small = (length * this.look.targetLength) / this.look.hunterLength;
    for (const target of replay.alive(time)) {
      const pose = replay.pose(target, time);
      if (target.prey === null) pen.turtle(...place(pose), pose.theta, small, this.look.target, 0.6);
      else this.#prey(scene, pose, target.prey);
    }
  }

  /**
   * Paint a target that an agent plays: larger and darker than others, in a ring that is not a reach.
   * @param {Scene} scene
   * @param {Pose} pose
   * @param {number} index
   */
  #prey(scene, pose, index) {
    const { replay, time, pen, place } = scene;
    const length = (scene.length * this.look.preyLength) / this.look.hunterLength;
    const gone = replay.withdrawn(replay.hunters.length + index, time);
    if (!gone) {
      const color = mixed("#ffffff", "#ffffff", 0, 0.9);
      pen.ring(...place(pose), 0.62 * length, Math.max(1.5, 0.05 * length), color, this.look.preyPieces);
    }
    pen.turtle(...place(pose), pose.theta, length, this.look.target, 1, gone);
  }

  /** @param {Scene} scene */
  #ground({ pen, context, replay, side, scale, place }) {
    const { gridSteps, gridGap } = this.look;
    const [left, bottom] = place({ x: 0, y: 0 });
    const [right, top] = place({ x: replay.side, y: replay.side });
    pen.box(0, 0, side, side, this.look.outside);
    pen.box(left, top, right - left, bottom - top, this.look.ground);
    context.strokeStyle = this.look.grid;
    context.lineWidth = 1;
    context.beginPath();
    const spacing = gridSteps.find((step) => step * scale >= gridGap) ?? replay.side;
    for (let line = spacing; line < replay.side; line += spacing) {
      const [x, y] = place({ x: line, y: line });
      context.moveTo(x, bottom);
      context.lineTo(x, top);
      context.moveTo(left, y);
      context.lineTo(right, y);
    }
    context.stroke();
    context.strokeStyle = this.look.wall;
    context.strokeRect(left, top, right - left, bottom - top);
  }

  /**
   * Paint a body's trail, which fades.
   * @param {Scene} scene
   * @param {Body} body
   * @param {string} color
   * @param {number} width
   * @param {number} fainter the divisor of the opacity
   */
  #trail({ context, replay, time, place }, body, color, width, fainter) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.lineCap = "butt";
    for (let from = Math.max(body.first * replay.period, time - TRAIL_MS); from < time; from += replay.period) {
      context.globalAlpha = (0.65 * (from + TRAIL_MS - time)) / TRAIL_MS / fainter;
      context.beginPath();
      context.moveTo(...place(replay.pose(body, from)));
      context.lineTo(...place(replay.pose(body, Math.min(from + replay.period, time))));
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  /**
   * Paint a hunter's view: a cone or circle with a soft edge.
   * @param {Scene} scene
   * @param {number} seat
   */
  #view({ context, replay, time, scale, place, length }, seat) {
    if (!replay.view) return;
    const hunter = replay.hunters[seat];
    const pose = replay.pose(hunter, time);
    const [x, y] = place(pose);
    const farthest = Math.SQRT2 * replay.side;
    const radius = Math.min(replay.view.radius ?? farthest, farthest) * scale;
    const half = (replay.view.angle * Math.PI) / 360;
    const [left, bottom] = place({ x: 0, y: 0 });
    context.save();
    context.beginPath();
    context.rect(left, bottom, replay.side * scale, -replay.side * scale);
    context.clip();
    context.translate(x, y);
    context.rotate(-pose.theta);
    context.fillStyle = mixed(hunter.color, "#ffffff", 0.6, 0.25 / LAYERS);
    for (let layer = 0; layer < LAYERS; layer++) {
      const less = (0.25 * length * layer) / LAYERS;
      context.beginPath();
      if (half < Math.PI) context.moveTo(Math.min(less, radius), 0);
      context.arc(0, 0, Math.max(0, radius - less), -half, half);
      context.fill();
    }
    context.restore();
  }

  /**
   * @param {Scene} scene
   * @param {number} seat
   */
  #hunter(scene, seat) {
    const { pen, context, replay, time, scale, place, length, picked } = scene;
    const hunter = replay.hunters[seat];
    const pose = replay.pose(hunter, time);
    const [x, y] = place(pose);
    const gone = replay.withdrawn(seat, time);
    if (!gone) {
      context.beginPath();
      context.arc(x, y, hunter.reach * scale, 0, 2 * Math.PI);
      context.fillStyle = mixed(hunter.color, "#ffffff", 0.55, 0.14);
      context.fill();
      const color = picked === seat ? "#ffffff" : mixed(hunter.color, "#ffffff", 0.55, 0.85);
      pen.ring(x, y, hunter.reach * scale, picked === seat ? 3 : hunter.pieces > 1 ? 2 : 1.3, color, hunter.pieces);
      this.#heading(scene, hunter, pose);
    }
    pen.turtle(x, y, pose.theta, length, hunter.color, 1, gone);
  }

  /**
   * @param {Scene} scene
   * @param {Hunter} hunter
   * @param {Pose} pose
   */
  #heading({ context, scale, place, length }, hunter, pose) {
    const [x, y] = place(pose);
    const base = Math.max(hunter.reach * scale, 0.55 * length) + 1.5;
    const size = 0.16 * length;
    context.save();
    context.translate(x, y);
    context.rotate(-pose.theta);
    context.fillStyle = mixed(hunter.color, "#ffffff", 0.45);
    context.beginPath();
    context.moveTo(base + size, 0);
    context.lineTo(base, 0.62 * size);
    context.lineTo(base, -0.62 * size);
    context.fill();
    context.restore();
  }

  /**
   * Paint a ruling: a ring around the target for a catch, a dashed line to it for a lost contest.
   * @param {Scene} scene
   * @param {Ruling} ruling
   * @param {boolean} calm
   */
  #ruling({ context, replay, time, place, length }, { time: judged, seat, verdict, target }, calm) {
    if (!target) return;
    const part = (time - judged) / LASTS_MS;
    const [x, y] = place(replay.pose(target, judged));
    context.globalAlpha = 1 - part;
    if (verdict === "GRANTED") {
      const eased = calm ? 0.5 : 1 - (1 - part) ** 3;
      context.strokeStyle = "#ffffff";
      context.lineWidth = 0.11 * length * (1 - part) + 1;
      context.beginPath();
      context.arc(x, y, length * (0.3 + 0.75 * eased), 0, 2 * Math.PI);
      context.stroke();
    } else if (verdict === "LOST_CONTEST") {
      context.strokeStyle = replay.hunters[seat].color;
      context.lineWidth = 0.1 * length;
      context.setLineDash([0.2 * length, 0.14 * length]);
      context.beginPath();
      context.moveTo(...place(replay.pose(replay.hunters[seat], time)));
      context.lineTo(x, y);
      context.stroke();
      context.setLineDash([]);
    }
    context.globalAlpha = 1;
  }

  /**
   * Paint the timeline: the catches in a lane for each hunter, and the contests as diamonds above.
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {number | null} picked
   */
  strip(canvas, replay, picked) {
    const { context } = new Pen(canvas, this.turtle);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    /** @type {(time: number) => number} */
    const across = (time) => (time / replay.duration) * width;
    const top = 12;
    const lane = (height - top - 3) / replay.hunters.length;
    context.fillStyle = this.look.ground;
    context.fillRect(0, 0, width, height);
    for (const { time, seat } of replay.catches) {
      context.globalAlpha = picked === null || picked === seat ? 1 : 0.25;
      context.fillStyle = replay.hunters[seat].color;
      context.fillRect(across(time) - 1.5, top + seat * lane, 3, Math.max(2, lane - 2));
    }
    context.globalAlpha = 1;
    for (const contest of replay.contests) {
      const [x, y, half] = [across(contest.time), 6, 4];
      const involved = picked === null || contest.parties.includes(picked);
      context.beginPath();
      [[0, -half], [half, 0], [0, half], [-half, 0]].forEach(([right, down]) => context.lineTo(x + right, y + down));
      context.closePath();
      context.fillStyle = involved ? "#ffffff" : "#ffffff55";
      context.fill();
    }
  }
}
