import { legible, mixed, readableOn } from "./shapes.js";

/** @typedef {import("./shapes.js").Look} Look */
/** @typedef {import("./shapes.js").Pen} Pen */
/** @typedef {import("./replay.js").Replay} Replay */
/** @typedef {import("./replay.js").Contest} Contest */
/** @typedef {import("./replay.js").Moment} Moment */
/** @typedef {import("./replay.js").Answer} Answer */

const WHITE = "#ffffff";

/**
 * Return a text's size in whole pixels, large enough to be read.
 * @param {number} pixels
 * @param {number} smallest
 */
const fontSize = (pixels, smallest) => Math.max(smallest, Math.round(pixels));

/**
 * Return a length in millimetres as text, with at least two digits.
 * @param {number} micrometres
 */
const millimetres = (micrometres) => {
  const decimals = micrometres < 100 ? 3 : micrometres < 995 ? 2 : micrometres < 9950 ? 1 : 0;
  return `${(micrometres / 1000).toFixed(decimals)} mm`;
};

/**
 * An agent in the picture; reach, x and y are in pixels.
 * @typedef {{ name: string, number: string, hunted: boolean, color: string, reach: number, x: number, y: number }} Agent
 */

/**
 * Draw the agents' numbers, bright with a dark outline on hunters, the reverse on prey; they are moved apart.
 * @param {Pen} pen
 * @param {Look} look
 * @param {Agent[]} agents
 * @param {number} length of a hunter
 */
export function drawNumbers(pen, look, agents, length) {
  const size = fontSize(0.34 * length, 10);
  const places = spreadApart(agents, (agents.length <= 10 ? 1.1 : 1.55) * size);
  agents.forEach(({ number, hunted }, index) => {
    const [color, outline] = hunted ? [look.ink, WHITE] : [WHITE, look.ink];
    const { x, y } = places[index];
    pen.label(x, y, number, size, { color, outline, weight: 800, align: "center" });
  });
}

/**
 * Return the points, with those closer than `room` moved apart, by two rooms at most, as render/annotations.py does.
 * @param {{ x: number, y: number }[]} points
 * @param {number} room
 */
function spreadApart(points, room) {
  let moved = points.map(({ x, y }, index) => ({
    x: x + 1e-3 * Math.cos(2.4 * index),
    y: y + 1e-3 * Math.sin(2.4 * index),
  }));
  for (let round = 0; round < 8; round++) {
    moved = moved.map((one) => {
      const { ...place } = one;
      for (const other of moved) {
        const [right, down] = [one.x - other.x, one.y - other.y];
        const distance = Math.hypot(right, down);
        if (other === one || distance >= room) continue;
        place.x += (0.5 * (room - distance) * right) / distance;
        place.y += (0.5 * (room - distance) * down) / distance;
      }
      return place;
    });
  }
  return moved.map((place, index) => {
    const { x, y } = points[index];
    const [right, down] = [place.x - x, place.y - y];
    const kept = Math.min(1, (2 * room) / Math.max(Math.hypot(right, down), 1e-9));
    return { x: x + kept * right, y: y + kept * down };
  });
}

/**
 * Draw the agents' names below their turtles, or else above: those that cover no other turtle and no name.
 * @param {Pen} pen
 * @param {Look} look
 * @param {Agent[]} agents
 * @param {number} side of the picture
 * @param {number} length of a hunter
 */
export function drawNames(pen, look, agents, side, length) {
  if (agents.length > look.mostNames || side < look.leastNamed) return;
  const size = fontSize(0.3 * length, 11);
  /** @type {{ x: number, y: number, halfWidth: number, halfHeight: number }[]} */
  const taken = [];
  for (const agent of agents) {
    const { x } = agent;
    const name = pen.truncated(agent.name, size, 600, look.longestName * size);
    const halfWidth = 0.5 * pen.width(name, size, 600);
    const away = Math.max(agent.reach, 0.5 * length) + 0.85 * size;
    const half = 0.45 * length;
    const others = agents.filter((other) => other !== agent).map((other) => ({
      x: other.x,
      y: other.y,
      halfWidth: half,
      halfHeight: half,
    }));
    if (x <= halfWidth || x >= side - halfWidth) continue;
    const y = [agent.y + away, agent.y - away].find((middle) =>
      middle > size && middle < side - size &&
      ![...others, ...taken].some((other) =>
        Math.abs(x - other.x) < halfWidth + other.halfWidth &&
        Math.abs(middle - other.y) < 0.5 * size + other.halfHeight
      )
    );
    if (y === undefined) continue;
    taken.push({ x, y, halfWidth, halfHeight: 0.5 * size });
    pen.label(x, y, name, size, { color: mixed(agent.color, WHITE, 0.5), align: "center", outline: look.ink });
  }
}

/**
 * Draw the lens of a caption's contest over the arena.
 * @param {Pen} pen
 * @param {Look} look
 * @param {Replay} replay
 * @param {Moment} moment
 * @param {number} side of the picture
 * @param {number} age of the caption, in milliseconds
 * @param {number} grows time in which a lens grows and shrinks, in milliseconds; 0 to show it in full
 */
export function drawCaptionLens(pen, look, replay, { contest }, side, age, grows) {
  if (side < look.leastArena || !contest?.lens) return;
  const [right, top] = contest.lens.corner;
  const part = grows ? Math.min(1, (age + 20) / grows, (look.captionMs - age) / grows) : 1;
  const size = look.lens * side * part * (2 - part);
  const gap = 0.025 * side;
  const away = gap + look.caption * side; // a caption may stand there
  drawLens(pen, look, replay, contest, right ? side - gap - size : gap, top ? away : side - away - size, size);
}

/**
 * Draw a text in a panel over the arena, after a dot in its agent's colour, as panel_shapes in render/captions.py does.
 * @param {Pen} pen
 * @param {Look} look
 * @param {Replay} replay
 * @param {{ agent: number, text: string, atTop: boolean }} caption
 * @param {number} side of the picture
 * @param {boolean} [whole] true for smaller letters in as many lines as the text needs
 */
export function drawPanel(pen, look, replay, { agent, text, atTop }, side, whole = false) {
  if (side < look.leastArena) return;
  const height = 0.78 * look.caption * side;
  const [dot, around, weight] = [0.5 * height, 2.2 * height, whole ? 600 : 700];
  const size = fontSize((whole ? 0.43 : 0.5) * height, 11);
  const most = side - dot;
  const lines = whole ? pen.wrapped(text, size, weight, most - around) : [text];
  const width = Math.min(most, Math.max(...lines.map((line) => pen.width(line, size, weight))) + around);
  const [left, gap, spacing] = [(side - width) / 2, 0.12 * height, 1.35 * size];
  const tall = height + spacing * (lines.length - 1);
  const top = atTop ? gap : side - gap - tall;
  const middle = top + 0.5 * height;
  pen.box(left, top, width, tall, look.panel, 0.5 * height);
  pen.box(left + 0.4 * height, middle - 0.5 * dot, dot, dot, replay.hunters[agent].color, 0.5 * dot);
  const style = { color: look.bright, weight, most: width - 1.7 * height };
  lines.forEach((line, row) => pen.label(left + 1.15 * height, middle + spacing * row, line, size, style));
}

/**
 * Draw a ghost, as render/ghost.py does: its way up to an instant, and a faded turtle, which stays at its end.
 * @param {Pen} pen
 * @param {Replay} replay
 * @param {Answer} answer
 * @param {number} time
 * @param {(pose: { x: number, y: number }) => [number, number]} place
 * @param {number} length of a hunter
 */
export function drawGhost(pen, replay, { agent, ghost }, time, place, length) {
  if (!ghost || time < ghost.first * replay.period) return;
  const { color } = replay.hunters[agent];
  const pose = replay.pose(ghost, time);
  /** @type {[x: number, y: number][]} */
  const points = [];
  for (let state = ghost.first; state <= ghost.last && state * replay.period <= time; state++) {
    points.push(place(replay.pose(ghost, state * replay.period)));
  }
  pen.path([...points, place(pose)], Math.max(1.6, 0.1 * length), mixed(color, WHITE, 0.5));
  pen.turtle(...place(pose), pose.theta, length, color, 1, true);
}

/**
 * Draw the lens of a contest: the hunters spread around their target, with their distances as lines.
 * @param {Pen} pen
 * @param {Look} look
 * @param {Replay} replay
 * @param {Contest} contest
 * @param {number} left
 * @param {number} top
 * @param {number} size
 */
export function drawLens(pen, look, replay, contest, left, top, size) {
  const { hunters, prey } = replay;
  if (!contest.lens) return;
  const claimants = contest.lens.directions.map((direction, index) => {
    const [seat, , distance] = contest.claims[index];
    const { name, color } = hunters[seat];
    return {
      seat,
      name,
      color,
      direction,
      distance: distance ?? 0,
      theta: replay.pose(hunters[seat], contest.time).theta,
    };
  });
  const [edge, unit] = [Math.max(1.5, 0.012 * size), size / 240];
  const [x, y] = [left + 0.5 * size, top + 0.345 * size];
  const scale = (0.25 * size) / Math.max(1, ...claimants.map(({ distance }) => distance));
  const text = fontSize(15 * unit, 7);
  const [winner] = claimants;
  pen.box(left, top, size, size, WHITE, 0.07 * size);
  pen.box(left + edge, top + edge, size - 2 * edge, size - 2 * edge, look.ground, 0.06 * size);
  pen.ring(x, y, winner.distance * scale, Math.max(1, 0.008 * size), mixed(WHITE, WHITE, 0, 0.6), 24);
  for (const { seat, color, direction, distance, theta } of [...claimants].reverse()) {
    const away = distance * scale;
    const [endX, endY] = [x + Math.cos(direction) * away, y - Math.sin(direction) * away];
    /** @type {[number, number][]} */
    const line = [[x, y], [endX, endY]];
    pen.path(line, 7 * unit, look.ink);
    pen.path(line, 4 * unit, color);
    pen.turtle(endX, endY, theta, 46 * unit, color);
    const style = { color: WHITE, weight: 800, outline: look.ink };
    pen.label(endX, endY, String(seat), text, { ...style, align: "center" });
  }
  pen.turtle(x, y, 0.5 * Math.PI, 28 * unit, look.target, 0.6);
  const panel = top + 0.68 * size;
  pen.box(left + edge, panel, size - 2 * edge, 0.32 * size - edge, look.panel, 0.055 * size);
  const digits = Math.max(String(hunters.length - 1).length, prey.length && `P${prey.length - 1}`.length);
  const chip = 0.9 * text;
  const [start, right] = [left + 0.05 * size, left + 0.95 * size];
  const chipWidth = (0.6 * digits + 0.7) * chip;
  claimants.slice(0, 2).forEach(({ seat, name, color, distance }, row) => {
    const middle = panel + (0.055 + 0.1 * row) * size;
    const from = start + chipWidth + 0.4 * text;
    const most = right - pen.width(millimetres(distance), text, 700) - 0.5 * text - from;
    pen.box(start, middle - 0.56 * chip, chipWidth, 1.12 * chip, color, 0.3 * chip);
    const numbered = { color: readableOn(color, look), weight: 800 };
    pen.label(start + chipWidth / 2, middle, String(seat), fontSize(0.82 * chip, 9), { ...numbered, align: "center" });
    pen.label(from, middle, name, text, { color: look.bright, most });
    pen.label(right, middle, millimetres(distance), text, { color: look.bright, weight: 700, align: "right" });
  });
  const style = { color: legible(winner.color), weight: 800, most: 0.9 * size };
  pen.label(x, panel + 0.255 * size, contest.lens.result, text, { ...style, align: "center" });
}

/**
 * Draw the podium over the dimmed arena: the first three contenders, their scores, and the result.
 * @param {Pen} pen
 * @param {Look} look
 * @param {Replay} replay
 * @param {number} side of the picture
 */
export function drawPodium(pen, look, replay, side) {
  const { teams, hunters, duration } = replay;
  const contenders = teams ?? hunters;
  const scores = teams ? replay.teamScores(duration) : replay.scores(duration);
  const unit = side / 720;
  const [middle, foot, wide] = [side / 2, 0.5 * side + 215 * unit, 190 * unit];
  const [big, size, small] = [fontSize(46 * unit, 14), fontSize(27 * unit, 10), fontSize(20 * unit, 10)];
  /** @type {(x: number, y: number, text: string, size: number, weight: number, most?: number, color?: string) => void} */
  const write = (x, y, text, size, weight, most = Infinity, color = WHITE) =>
    pen.label(x, y, text, size, { color, weight, align: "center", most });
  pen.box(0, 0, side, side, `rgb(0 0 0 / ${1 - look.dimmed})`);
  write(middle, 0.5 * side - 265 * unit, replay.result, big, 800, 0.94 * side, look.gold);
  const order = [...scores.keys()].sort((one, other) => scores[other] - scores[one]).slice(
    0,
    look.podiumHeights.length,
  );
  order.forEach((contender, place) => {
    const { name, color } = contenders[contender];
    const rank = scores.filter((score) => score > scores[contender]).length;
    const x = middle + look.podiumPlaces[order.length - 1][place] * 210 * unit;
    const tall = look.podiumHeights[rank] * 200 * unit;
    const top = foot - tall;
    pen.box(x - wide / 2, top, wide, tall, mixed(color, look.panel, 0.35), 10 * unit);
    write(x, top + 34 * unit, String(rank + 1), big, 800);
    pen.turtle(x, top - 52 * unit, 1.57, 92 * unit, color);
    write(x, top - 122 * unit, String(scores[contender]), big, 800);
    write(x, foot + 26 * unit, name, size, 700, 1.06 * wide);
  });
  if (!replay.prey.length) return;
  const caught = replay.hunted(duration).map(({ caught }) => caught === 1 ? "once" : `${caught} times`);
  const texts = replay.prey.slice(0, 2).map(({ label }, index) => `${label}: caught ${caught[index]}`);
  const more = replay.prey.length > 2 ? `, and ${replay.prey.length - 2} more` : "";
  write(middle, foot + 70 * unit, texts.join(", ") + more, small, 600, 0.94 * side);
}
