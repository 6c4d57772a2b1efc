import { Replay } from "../../catch_arena/player/page/replay.js";

/** @typedef {import("../../catch_arena/player/page/replay.js").Body} Body */

/** @param {Body} body */
const tracks = (body) => [body.x, body.y, body.theta].map((values) => [...values]);

/**
 * All that the player reads from a replay, in each state and half a state later; or why it reads nothing.
 * @param {string} text
 */
async function read(text) {
  try {
    const replay = await Replay.of(text);
    const bodies = [...replay.hunters, ...replay.targets];
    return {
      ...replay,
      hunters: replay.hunters.map(({ name, label, color, reach, pieces }) => ({ name, label, color, reach, pieces })),
      prey: replay.prey.map(({ lives, ...one }) => ({ ...one, targets: lives.map(({ number }) => number) })),
      targets: replay.targets.map(({ number, first, last }) => [number, first, last - first + 1]),
      moving: replay.targets.filter(({ moves }) => moves).map(({ number }) => number),
      rulings: replay.rulings.map((ruling) => ({ ...ruling, target: ruling.target?.number ?? null })),
      contests: replay.contests.map((contest) => ({ ...contest, place: contest.place.number })),
      answers: replay.answers.map(({ ghost, ...answer }) => ({
        ...answer,
        contest: replay.contests.indexOf(answer.contest),
        way: ghost && { first: ghost.first, track: tracks(ghost) },
      })),
      shown: replay.answers.map(({ contest }) =>
        [-2001, -2000, 0, 1500, 1501].map((later) => replay.answerAt(contest.time + later, [2000, 1500])?.text ?? null)
      ),
      tracks: bodies.map(tracks),
      states: Array.from({ length: replay.steps + 1 }, (_, state) => {
        const time = state * replay.period;
        return {
          alive: replay.alive(time).map((target) => target.number),
          scores: replay.scores(time),
          teamScores: replay.teamScores(time),
          hunted: replay.hunted(time),
          withdrawn: [...replay.hunters, ...replay.prey].map((_, agent) => replay.withdrawn(agent, time)),
          later: bodies.map((body) => replay.pose(body, time + replay.period / 2)),
        };
      }),
    };
  } catch (error) {
    return { kind: error instanceof Error ? error.name : typeof error, error: String(error) };
  }
}

/** The standard input is a JSON array of bundles' texts, and so is the output, of what was read. */
const texts = await new Response(Deno.stdin.readable).json();
const found = [];
for (const text of texts) found.push(await read(text));
console.log(JSON.stringify(found));
