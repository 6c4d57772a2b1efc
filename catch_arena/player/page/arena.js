/** @typedef {import("./replay.js").Replay} Replay */
/** @typedef {import("./replay.js").Body} Body */
/** @typedef {import("./replay.js").Hunter} Hunter */
/** @typedef {import("./replay.js").Target} Target */
/** @typedef {import("./replay.js").Ruling} Ruling */
/** @typedef {import("./replay.js").Contest} Contest */
/** @typedef {{ x: number, y: number }} Point in metres, upwards */
/** @typedef {ReturnType<Replay["pose"]>} Pose */

/**
 * The colours and shapes of render/, as element.py writes them.
 * @typedef {object} Look
 * @property {string} ground
 * @property {string} outside
 * @property {string} grid
 * @property {string} wall
 * @property {string} target
 * @property {string} targetTrail
 * @property {string} ink
 * @property {number[]} gridSteps in metres
 * @property {number} gridGap least distance of two lines, in the page's pixels
 * @property {number} hunterLength in metres
 * @property {number} targetLength in metres
 * @property {number} preyLength in metres
 * @property {number} preyPieces number of arcs of its ring
 * @property {number} margin part of the side
 * @property {[own: number, white: number, points: [number, number][]][]} turtle
 */

/**
 * The instant of a replay that is painted, and the scale from metres to dots of the canvas.
 * @typedef {object} Scene
 * @property {CanvasRenderingContext2D} context
 * @property {Replay} replay
 * @property {number} time in milliseconds
 * @property {number} size of the canvas, in dots
 * @property {number} scale dots per metre
 * @property {number} dots of the canvas per pixel of the page
 * @property {(point: Point) => [number, number]} place
 * @property {number} length of a hunter, in dots
 * @property {number | null} picked
 */

const CLOSE_UP_M = 1.1;
const LASTS_MS = 900;
const TRAIL_MS = 1800;
/** Number of layers, each smaller than the one before, that make a view's edge soft. */
const LAYERS = 8;

/** Paints an instant of a replay, as render/ does: `look` comes from its tables. */
export class Painter {
  /** @param {Look} look */
  constructor(look) {
    this.look = look;
    this.turtle = look.turtle.map(([own, white, points]) => {
      const path = new Path2D();
      points.forEach(([x, y]) => path.lineTo(x, y));
      path.closePath();
      return { own, white, path };
    });
    /** @type {Map<string, string[]>} */
    this.dyes = new Map();
  }

  /**
   * Paint the whole arena.
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {number} time
   * @param {number | null} picked the seat of the selected hunter
   * @param {boolean} calm true to paint nothing that pulses
   * @param {boolean} viewed true to show the view of the selected hunter
   */
  paint(canvas, replay, time, picked, calm, viewed) {
    const margin = this.look.margin * replay.side;
    const view = { x: -margin, y: -margin, side: replay.side + 2 * margin };
    const scene = this.#scene(canvas, replay, time, view, picked);
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
    this.#preyNumbers(scene);
    replay.hunters.forEach((hunter, seat) => this.#number(scene, String(seat), replay.pose(hunter, time), false));
  }

  /**
   * Paint a close-up of a contest: each claimant's distance from the target, and the circles of reach.
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {Contest} contest
   */
  closeUp(canvas, replay, contest) {
    const middle = replay.pose(contest.place, contest.time);
    const view = { x: middle.x - CLOSE_UP_M / 2, y: middle.y - CLOSE_UP_M / 2, side: CLOSE_UP_M };
    const scene = this.#scene(canvas, replay, contest.time, view, null);
    const { context, scale, dots, place, length } = scene;
    this.#ground(scene);
    this.#targets(scene, true);
    context.globalAlpha = 0.35;
    for (const seat of contest.parties) {
      const { color } = replay.hunters[seat];
      this.#turtle(scene, replay.pose(replay.hunters[seat], contest.time), length, color, 1);
    }
    context.globalAlpha = 1;
    const [x, y] = place(middle);
    context.lineWidth = 1.5 * dots;
    context.strokeStyle = "#ffffff";
    context.setLineDash([4 * dots, 4 * dots]);
    for (const reach of new Set(contest.parties.map((seat) => replay.hunters[seat].reach))) {
      context.beginPath();
      context.arc(x, y, reach * scale, 0, 2 * Math.PI);
      context.stroke();
    }
    context.setLineDash([]);
    context.fillStyle = "#ffffff";
    context.beginPath();
    context.arc(x, y, 4 * dots, 0, 2 * Math.PI);
    context.fill();
    for (const seat of [...contest.parties].reverse()) this.#distance(scene, seat, [x, y]);
  }

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {number} time
   * @param {Point & { side: number }} view the lower left corner and the side of the visible square
   * @param {number | null} picked
   * @returns {Scene}
   */
  #scene(canvas, replay, time, view, picked) {
    const context = brush(canvas);
    const size = canvas.width;
    const scale = size / view.side;
    const dots = size / canvas.clientWidth || 1;
    /** @type {Scene["place"]} */
    const place = ({ x, y }) => [(x - view.x) * scale, size - (y - view.y) * scale];
    const smallest = dots * Math.max(18, canvas.clientWidth / 26);
    const length = Math.max(this.look.hunterLength * scale, smallest);
    return { context, replay, time, size, scale, dots, place, length, picked };
  }

  /**
   * @param {Scene} scene
   * @param {boolean} [bare] true to paint prey without its ring
   */
  #targets(scene, bare = false) {
    const { replay, time, length } = scene;
    const small = (length * this.look.targetLength) / this.look.hunterLength;
    for (const target of replay.alive(time)) {
      if (target.prey === null) this.#turtle(scene, replay.pose(target, time), small, this.look.target, 0.6);
      else this.#prey(scene, target, target.prey, bare);
    }
  }

  /**
   * Paint a target that an agent plays: larger and darker than others, in a ring that is not a reach.
   * @param {Scene} scene
   * @param {Target} target
   * @param {number} index
   * @param {boolean} bare true to paint it without its ring
   */
  #prey(scene, target, index, bare) {
    const { context, replay, time, place } = scene;
    const length = (scene.length * this.look.preyLength) / this.look.hunterLength;
    const pose = replay.pose(target, time);
    const gone = replay.withdrawn(replay.hunters.length + index, time);
    if (!gone && !bare) {
      const [x, y] = place(pose);
      context.strokeStyle = mixed("#ffffff", "#ffffff", 0, 0.9);
      context.lineWidth = Math.max(1.5 * scene.dots, 0.05 * length);
      this.#ring(scene, x, y, 0.62 * length, this.look.preyPieces);
    }
    context.globalAlpha = gone ? 0.55 : 1;
    this.#turtle(scene, pose, length, gone ? mixed(this.look.target, this.look.ink, 0.5) : this.look.target, 1);
    context.globalAlpha = 1;
  }

  /** @param {Scene} scene */
  #preyNumbers(scene) {
    const { replay, time } = scene;
    for (const target of replay.alive(time)) {
      if (target.prey !== null) this.#number(scene, `P${target.prey}`, replay.pose(target, time), true);
    }
  }

  /**
   * Paint a circle as a number of arcs.
   * @param {Scene} scene
   * @param {number} x
   * @param {number} y
   * @param {number} radius in dots
   * @param {number} pieces
   */
  #ring({ context }, x, y, radius, pieces) {
    const piece = (2 * Math.PI * radius) / pieces;
    const gap = Math.max(3, Math.min(0.3 * piece, 6 * context.lineWidth));
    if (pieces > 1) {
      context.lineCap = "butt";
      context.setLineDash([piece - gap, gap]);
      context.lineDashOffset = (piece - gap) / 2;
    }
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
    context.lineDashOffset = 0;
  }

  /**
   * Paint a claimant's number at its place, and a line to the target.
   * @param {Scene} scene
   * @param {number} seat
   * @param {[number, number]} target in dots
   */
  #distance(scene, seat, target) {
    const { context, replay, time, dots, place } = scene;
    const hunter = replay.hunters[seat];
    const [x, y] = place(replay.pose(hunter, time));
    /** @type {[string, number][]} */
    const strokes = [[this.look.ink, 6], [hunter.color, 3]];
    for (const [color, width] of strokes) {
      context.strokeStyle = color;
      context.lineWidth = width * dots;
      context.lineCap = "round";
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(...target);
      context.stroke();
    }
    context.fillStyle = hunter.color;
    context.lineWidth = 1.5 * dots;
    context.strokeStyle = this.look.ink;
    context.beginPath();
    context.arc(x, y, 10 * dots, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.font = `750 ${12 * dots}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillStyle = readableOn(hunter.color, this.look.ink);
    context.fillText(String(seat), x, y + dots);
  }

  /** @param {Scene} scene */
  #ground({ context, replay, size, scale, dots, place }) {
    const { gridSteps, gridGap } = this.look;
    context.fillStyle = this.look.outside;
    context.fillRect(0, 0, size, size);
    const [left, bottom] = place({ x: 0, y: 0 });
    const side = replay.side * scale;
    context.fillStyle = this.look.ground;
    context.fillRect(left, bottom - side, side, side);
    context.strokeStyle = this.look.grid;
    context.lineWidth = dots;
    context.beginPath();
    const spacing = gridSteps.find((step) => step * scale >= gridGap * dots) ?? replay.side;
    for (let line = spacing; line < replay.side; line += spacing) {
      const [x, y] = place({ x: line, y: line });
      if (x >= 0 && x <= size) {
        context.moveTo(x, bottom);
        context.lineTo(x, bottom - side);
      }
      if (y >= 0 && y <= size) {
        context.moveTo(left, y);
        context.lineTo(left + side, y);
      }
    }
    context.stroke();
    context.strokeStyle = this.look.wall;
    context.strokeRect(left, bottom - side, side, side);
  }

  /**
   * Paint a body's trail, which fades.
   * @param {Scene} scene
   * @param {Body} body
   * @param {string} color
   * @param {number} width in dots
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
    const { context, replay, time, scale, dots, place, length, picked } = scene;
    const hunter = replay.hunters[seat];
    const pose = replay.pose(hunter, time);
    const [x, y] = place(pose);
    const gone = replay.withdrawn(seat, time);
    if (!gone) {
      context.beginPath();
      context.arc(x, y, hunter.reach * scale, 0, 2 * Math.PI);
      context.fillStyle = mixed(hunter.color, "#ffffff", 0.55, 0.14);
      context.fill();
      context.lineWidth = (picked === seat ? 3 : hunter.pieces > 1 ? 2 : 1.3) * dots;
      context.strokeStyle = picked === seat ? "#ffffff" : mixed(hunter.color, "#ffffff", 0.55, 0.85);
      this.#ring(scene, x, y, hunter.reach * scale, hunter.pieces);
      this.#heading(scene, hunter, pose);
    }
    context.globalAlpha = gone ? 0.55 : 1;
    this.#turtle(scene, pose, length, gone ? mixed(hunter.color, this.look.ink, 0.5) : hunter.color, 1);
    context.globalAlpha = 1;
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
   * @param {Scene} scene
   * @param {Pose} pose
   * @param {number} length in dots
   * @param {string} color
   * @param {number} contrast from 0 to 1
   */
  #turtle({ context, place }, pose, length, color, contrast) {
    const [x, y] = place(pose);
    context.save();
    context.translate(x, y);
    context.fillStyle = mixed(this.look.ink, this.look.ink, 0, 0.33);
    context.beginPath();
    context.ellipse(0.05 * length, 0.07 * length, 0.36 * length, 0.3 * length, 0, 0, 2 * Math.PI);
    context.fill();
    context.rotate(-pose.theta);
    context.scale(length, length);
    const inks = this.#dyed(color, contrast);
    for (const [index, { path }] of this.turtle.entries()) {
      context.fillStyle = inks[index];
      context.fill(path);
    }
    context.restore();
  }

  /**
   * Return the colour of each part of a turtle: a mix of its own colour and white; less contrast makes it lighter.
   * @param {string} color
   * @param {number} contrast from 0 to 1
   */
  #dyed(color, contrast) {
    const key = color + contrast;
    let inks = this.dyes.get(key);
    if (!inks) {
      /** @type {(own: number, white: number, channel: number) => number} */
      const part = (own, white, channel) => {
        const lit = channel * (1 - contrast);
        return Math.round(own * channel * contrast + white * (255 - lit) + lit);
      };
      inks = this.turtle.map(({ own, white }) => `rgb(${rgb(color).map((channel) => part(own, white, channel))})`);
      this.dyes.set(key, inks);
    }
    return inks;
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
   * Paint an agent's number: bright with a dark outline on a hunter, the reverse on prey.
   * @param {Scene} scene
   * @param {string} text
   * @param {Pose} pose
   * @param {boolean} hunted
   */
  #number({ context, place, length, dots }, text, pose, hunted) {
    const [x, y] = place(pose);
    context.font = `800 ${Math.max(10 * dots, 0.36 * length)}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineJoin = "round";
    context.lineWidth = 0.11 * length;
    context.strokeStyle = hunted ? "#ffffff" : this.look.ink;
    context.strokeText(text, x, y);
    context.fillStyle = hunted ? this.look.ink : "#ffffff";
    context.fillText(text, x, y);
  }

  /**
   * Paint the timeline: the catches in a lane for each hunter, and the contests as diamonds above.
   * @param {HTMLCanvasElement} canvas
   * @param {Replay} replay
   * @param {number | null} picked
   */
  strip(canvas, replay, picked) {
    const context = brush(canvas);
    const { width, height } = canvas;
    const dots = width / canvas.clientWidth || 1;
    /** @type {(time: number) => number} */
    const across = (time) => (time / replay.duration) * width;
    const top = 12 * dots;
    const lane = (height - top - 3 * dots) / replay.hunters.length;
    context.fillStyle = this.look.ground;
    context.fillRect(0, 0, width, height);
    for (const { time, seat } of replay.catches) {
      context.globalAlpha = picked === null || picked === seat ? 1 : 0.25;
      context.fillStyle = replay.hunters[seat].color;
      context.fillRect(across(time) - 1.5 * dots, top + seat * lane, 3 * dots, Math.max(2 * dots, lane - 2 * dots));
    }
    context.globalAlpha = 1;
    for (const contest of replay.contests) {
      const [x, y, half] = [across(contest.time), 6 * dots, 4 * dots];
      const involved = picked === null || contest.parties.includes(picked);
      context.beginPath();
      [[0, -half], [half, 0], [0, half], [-half, 0]].forEach(([right, down]) => context.lineTo(x + right, y + down));
      context.closePath();
      context.fillStyle = involved ? "#ffffff" : "#ffffff55";
      context.fill();
    }
  }
}

/** @param {HTMLCanvasElement} canvas */
function brush(canvas) {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("This browser does not support canvas.");
  return context;
}

/** @param {string} color #rrggbb */
const rgb = (color) => [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));

/**
 * Mix a colour with a part of another one.
 * @param {string} color
 * @param {string} added
 * @param {number} part
 */
function mixed(color, added, part, opacity = 1) {
  const [from, to] = [rgb(color), rgb(added)];
  const channels = from.map((channel, index) => Math.round(channel + (to[index] - channel) * part));
  return `rgb(${channels.join(" ")} / ${opacity})`;
}

/**
 * Return the dark or the bright text colour, whichever stands out from a colour, as render/hud.py does.
 * @param {string} color
 * @param {string} dark
 */
export function readableOn(color, dark) {
  const [red, green, blue] = rgb(color);
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 120 ? dark : "#ffffff";
}
