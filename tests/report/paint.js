import { Painter } from "../../catch_arena/player/page/arena.js";
import { readableOn } from "../../catch_arena/player/page/shapes.js";

// What the player's page has of a browser, without a page.
Object.assign(globalThis, { Path2D: class {} });

/**
 * How many lines are drawn before the walls of an empty arena.
 * @param {import("../../catch_arena/player/page/shapes.js").Look} look
 * @param {number} side of the arena
 * @param {number} pixels of the canvas
 */
function gridLines(look, side, pixels) {
  let lines = 0;
  const context = new Proxy({ lineTo: () => lines++ }, {
    get: (target, name) => name === "lineTo" ? target.lineTo : () => {},
    set: () => true,
  });
  const canvas = /** @type {HTMLCanvasElement} */ (/** @type {unknown} */ ({
    width: 2 * pixels, // of a screen with two dots in a pixel
    clientWidth: pixels,
    getContext: () => context,
  }));
  const replay = /** @type {import("../../catch_arena/player/page/replay.js").Replay} */ (/** @type {unknown} */ ({
    side,
    hunters: [],
    rulings: [],
    alive: () => [],
    captionAt: () => null,
  }));
  const painter = new Painter({ ...look, turtle: [] });
  painter.paint(canvas, replay, 0, { picked: null, viewed: false, calm: true, grows: 0, over: false, asked: false });
  return lines;
}

const { look, colors, arenas } = await new Response(Deno.stdin.readable).json();
console.log(JSON.stringify({
  dark: colors.map((/** @type {string} */ color) => readableOn(color, look) === look.panel),
  lines: arenas.map((/** @type {[number, number]} */ [side, pixels]) => gridLines(look, side, pixels)),
}));
