import {
  drawCaptionLens,
  drawGhost,
  drawNames,
  drawNumbers,
  drawPanel,
  drawPodium,
} from "../../catch_arena/player/page/overlays.js";
import { Replay } from "../../catch_arena/player/page/replay.js";
import { Pen } from "../../catch_arena/player/page/shapes.js";

/** @typedef {import("../../catch_arena/player/page/overlays.js").Agent} Agent */
/** @typedef {import("../../catch_arena/player/page/shapes.js").Look} Look */

/**
 * The shapes that are drawn, as rows: name and arguments. Each letter is half as wide as the text's size.
 * @param {(pen: Pen) => void} draw
 */
function shapes(draw) {
  /** @type {unknown[][]} */
  const rows = [];
  const recorder = Object.create(Pen.prototype);
  for (const name of ["ring", "path"]) {
    recorder[name] = (/** @type {unknown[]} */ ...row) => rows.push([name, ...row]);
  }
  /** @type {Pen["box"]} */
  recorder.box = (left, top, width, height, color, radius = 0) => {
    rows.push(["box", left, top, width, height, color, radius]);
  };
  /** @type {Pen["turtle"]} */
  recorder.turtle = (x, y, theta, length, color, contrast = 1, faded = false) => {
    rows.push(["turtle", x, y, theta, length, color, contrast, Number(faded)]);
  };
  recorder.width = (/** @type {string} */ text, /** @type {number} */ size) => 0.5 * size * text.length;
  /** @type {Pen["label"]} */
  recorder.label = (x, y, text, size, { color, weight = 600, align = "left", outline = "", most = Infinity }) => {
    rows.push(["label", x, y, recorder.truncated(text, size, weight, most), size, color, weight, align, outline]);
  };
  draw(recorder);
  return rows;
}

/**
 * @type {{
 *   look: Look,
 *   side: number,
 *   matches: { bundle: string, age: number, agents: Agent[], length: number, instants: number[] }[],
 * }}
 */
const { look, side, matches } = await new Response(Deno.stdin.readable).json();
const found = [];
for (const { bundle, age, agents, length, instants } of matches) {
  const replay = await Replay.of(bundle);
  const scale = side / (replay.side * (1 + 2 * look.margin));
  /** @type {(pose: { x: number, y: number }) => [number, number]} */
  const place = ({ x, y }) => [side / 2 + (x - replay.side / 2) * scale, side / 2 - (y - replay.side / 2) * scale];
  found.push({
    times: replay.moments.map((moment) => moment.time),
    captions: replay.moments.map((moment) =>
      shapes((pen) => {
        drawCaptionLens(pen, look, replay, moment, side, age, 160);
        drawPanel(pen, look, replay, moment, side);
      })
    ),
    answers: replay.answers.map((answer) =>
      instants.map((time) =>
        shapes((pen) => {
          drawGhost(pen, replay, answer, time, place, length);
          drawPanel(pen, look, replay, answer, side, true);
        })
      )
    ),
    podium: shapes((pen) => drawPodium(pen, look, replay, side)),
    agents: shapes((pen) => {
      drawNames(pen, look, agents, side, length);
      drawNumbers(pen, look, agents, length);
    }),
  });
}
console.log(JSON.stringify(found));
