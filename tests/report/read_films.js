import { Film } from "../../catch_arena/player/page/film.js";

/** @typedef {import("../../catch_arena/player/page/film.js").Body} Body */

/** @param {Body} body */
const tracks = (body) => [body.x, body.y, body.theta].map((values) => [...values]);

/**
 * All that the player reads from a film, in each state and half a state later; or why it reads nothing.
 * @param {string} text
 */
async function read(text) {
  try {
    const film = await Film.of(text);
    const bodies = [...film.hunters, ...film.targets];
    return {
      ...film,
      hunters: film.hunters.map(({ name, color }) => ({ name, color })),
      targets: film.targets.map(({ number, first, last }) => [number, first, last - first + 1]),
      rulings: film.rulings.map((ruling) => ({ ...ruling, target: ruling.target?.number ?? null })),
      contests: film.contests.map((contest) => ({ ...contest, place: contest.place.number })),
      tracks: bodies.map(tracks),
      states: Array.from({ length: film.steps + 1 }, (_, state) => {
        const time = state * film.period;
        return {
          alive: film.alive(time).map((target) => target.number),
          scores: film.scores(time),
          withdrawn: film.hunters.map((_, seat) => film.withdrawn(seat, time)),
          later: bodies.map((body) => film.pose(body, time + film.period / 2)),
        };
      }),
    };
  } catch (error) {
    return { kind: error instanceof Error ? error.name : typeof error, error: String(error) };
  }
}

/** The standard input is a JSON array of films' texts, and so is the output, of what was read. */
const texts = await new Response(Deno.stdin.readable).json();
const found = [];
for (const text of texts) found.push(await read(text));
console.log(JSON.stringify(found));
