/**
 * The first line of a replay, as bundle.py writes it.
 * @typedef {object} Facts
 * @property {string} title
 * @property {string} seed
 * @property {number} side of the arena, in metres
 * @property {number} period between two states, in milliseconds
 * @property {number} steps
 * @property {number} grid parts of the side
 * @property {number} turn parts of a full turn
 * @property {ViewLimits | null} view limits of the hunters' views; null if they see the whole arena
 * @property {Cast[]} hunters by seat
 * @property {Team[] | null} teams null if there are no teams
 * @property {{ name: string, label: string, targets: number[] }[]} prey by index: names, and numbers of the targets that it played
 * @property {[number: number, first: number, length: number][]} targets number, first state and number of states of each
 * @property {[step: number, agent: number][]} withdrawals agents are the hunters by seat, then the prey by index
 * @property {[state: number, seat: number, verdict: string, number: number | null][]} rulings
 * @property {Judged[]} contests
 * @property {Answered[]} answers to lost contests, in the order of time
 * @property {{ time: number, agent: number, text: string, atTop: boolean, contest: number | null }[]} moments captions,
 *   and the index of the contest that each is about
 * @property {string} result the winner and its margin in words
 */

/**
 * A contest, as bundle.py writes it.
 * @typedef {object} Judged
 * @property {number} state
 * @property {string} target
 * @property {string} clause
 * @property {Claim[]} claims
 * @property {string} sentence
 * @property {Lens | null} lens null among team-mates, if no distances were measured, and if the kill failed
 */

/**
 * What would have won a contest, as bundle.py writes it.
 * @typedef {object} Answered
 * @property {number} contest its index
 * @property {number} agent the seat of the loser
 * @property {string} text
 * @property {boolean} atTop true if the text stands at the top of the arena
 * @property {number} first state of the ghost's way
 * @property {number} states number of states in the ghost's way; 0 if no change would have won the contest
 */

/**
 * The picture of a contest: directions from the target in which its first claimants are drawn, in radians.
 * @typedef {{ corner: [right: number, top: number], directions: number[], result: string }} Lens
 */

/**
 * A hunter: its name, a label that no other agent has, its reach in metres, and the number of arcs of its ring.
 * @typedef {{ name: string, label: string, color: string, reach: number, pieces: number }} Cast
 */
/** @typedef {{ name: string, color: string, seats: number[] }} Team */

/** @typedef {[seat: number, verdict: string, micrometres: number | null]} Claim */

/** @typedef {{ radius: number | null, angle: number }} ViewLimits radius in metres, full angle in degrees */

/**
 * Poses of a body in each state from `first` to `last`: x and y in metres, theta in radians.
 * @typedef {{ first: number, last: number, x: Float32Array, y: Float32Array, theta: Float32Array }} Body
 */

/** @typedef {Body & Cast} Hunter */
/** @typedef {Body & { number: number, moves: boolean, prey: number | null }} Target prey: index of the prey that plays it */
/** @typedef {{ name: string, label: string, lives: Target[] }} Prey */
/** @typedef {{ time: number, seat: number, verdict: string, target: Target | null }} Ruling */
/** @typedef {Judged & { time: number, parties: number[], place: Target }} Contest */
/** @typedef {{ time: number, agent: number, text: string, atTop: boolean, contest: Contest | null }} Moment */
/** @typedef {{ agent: number, text: string, atTop: boolean, contest: Contest, ghost: Body | null }} Answer */

/** Largest size of an unpacked replay, in bytes. */
const LARGEST = 256 << 20;

/** Limits of the settings (config.py): a value beyond them could keep a page drawing for ever. */
const FARTHEST = 10_000;
const RANGES = {
  side: [2, 5000],
  period: [16, 1e9],
  grid: [1, 1 << 15],
  turn: [1, 1 << 15],
  steps: [0, 1 << 23],
};

/** @param {string} why */
const damaged = (why) => new Error(`It is damaged: ${why}.`);

/**
 * Unpack the result of Python's `packed_text`, base64 of gzip, to bytes. Throws an Error with one line.
 * @param {string} text
 */
export async function unpacked(text) {
  const parts = [];
  let size = 0;
  const gzip = new DecompressionStream("gzip");
  try {
    const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const reader = new Blob([packed]).stream().pipeThrough(gzip).getReader();
    for (let part = await reader.read(); !part.done && size <= LARGEST; part = await reader.read()) {
      parts.push(part.value);
      size += part.value.length;
    }
  } catch {
    throw damaged("it cannot be unpacked");
  }
  if (size > LARGEST) throw damaged(`it has more than ${LARGEST} bytes when unpacked`);
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

/** One match: all poses in every state, and the arbiter's answers. Times are in milliseconds. */
export class Replay {
  /**
   * Read a replay. Throws an Error with one line if the text is not a replay.
   * @param {string} text
   */
  static async of(text) {
    const bytes = await unpacked(text);
    const end = Math.max(bytes.indexOf(10), 0);
    let facts;
    try {
      facts = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes.subarray(0, end)));
    } catch {
      throw damaged("its first line is not JSON");
    }
    check(facts);
    return new Replay(facts, bytes.subarray(end + 1));
  }

  /**
   * @param {Facts} facts
   * @param {Uint8Array} tracks
   */
  constructor(facts, tracks) {
    this.title = facts.title;
    this.seed = facts.seed;
    this.side = facts.side;
    this.view = facts.view;
    this.period = facts.period;
    this.steps = facts.steps;
    this.withdrawals = facts.withdrawals;
    this.duration = this.steps * this.period;
    const states = facts.hunters.length * (this.steps + 1) +
      facts.targets.reduce((sum, [, , length]) => sum + length, 0) +
      facts.answers.reduce((sum, { states }) => sum + states, 0);
    if (tracks.length !== 6 * states) throw damaged(`its tracks must have ${6 * states} bytes, got ${tracks.length}`);
    const numbers = Replay.numbers(tracks);
    const metres = this.side / facts.grid;
    let at = 0;
    /** @type {(first: number, length: number) => Body} */
    const body = (first, length) => {
      const [x, y, theta] = [metres, metres, (2 * Math.PI) / facts.turn].map((unit) => {
        const values = new Float32Array(length);
        for (let state = 0, sum = 0, way = 0; state < length; state++) {
          way += numbers[at++];
          values[state] = unit * (sum += way);
        }
        return values;
      });
      return { first, last: first + length - 1, x, y, theta };
    };
    /** @type {Hunter[]} */
    this.hunters = facts.hunters.map((one) => ({ ...one, ...body(0, this.steps + 1) }));
    /** @type {Target[]} */
    this.targets = facts.targets.map(([number, first, length]) => {
      const track = body(first, length);
      const moves = track.x.some((x, state) => x !== track.x[0] || track.y[state] !== track.y[0]);
      return { number, moves, prey: null, ...track };
    });
    const numbered = new Map(this.targets.map((target) => [target.number, target]));
    this.teams = facts.teams;
    /** @type {Prey[]} */
    this.prey = facts.prey.map(({ name, label, targets }, index) => {
      const lives = targets.map((number) => {
        const target = numbered.get(number);
        if (!target) throw damaged(`prey[${index}] plays target ${number}, which is not in the replay`);
        target.prey = index;
        return target;
      });
      return { name, label, lives };
    });
    /** @type {Ruling[]} */
    this.rulings = facts.rulings.map(([state, seat, verdict, number], index) => {
      const target = number === null ? null : numbered.get(number);
      if (target === undefined) {
        throw damaged(`rulings[${index}] is about target ${number}, which is not in the replay`);
      }
      return { time: state * this.period, seat, verdict, target };
    });
    this.catches = this.rulings.filter((ruling) => ruling.verdict === "GRANTED");
    /** @type {Contest[]} */
    this.contests = facts.contests.map((contest, index) => {
      const time = contest.state * this.period;
      const parties = contest.claims.map(([seat]) => seat);
      const place = this.rulings.find((ruling) => ruling.time === time && parties.includes(ruling.seat))?.target;
      if (!place) throw damaged(`contests[${index}] belongs to no ruling in the replay`);
      return { ...contest, time, parties, place };
    });
    /** @type {Answer[]} */
    this.answers = facts.answers.map(({ contest: number, agent, text, atTop, first, states }, index) => {
      const contest = this.contests[number];
      if (!contest) throw damaged(`answers[${index}] is about contest ${number}, which is not in the replay`);
      return { agent, text, atTop, contest, ghost: states ? body(first, states) : null };
    });
    /** @type {Moment[]} */
    this.moments = facts.moments.map((moment, index) => {
      const contest = moment.contest === null ? null : this.contests[moment.contest];
      if (contest === undefined) {
        throw damaged(`moments[${index}] is about contest ${moment.contest}, which is not in the replay`);
      }
      return { ...moment, contest };
    });
    this.result = facts.result;
  }

  /**
   * Read 16-bit numbers: the sign is the lowest bit; all low bytes come first, then all high ones.
   * @param {Uint8Array} bytes
   */
  static numbers(bytes) {
    const half = bytes.length / 2;
    return Int16Array.from({ length: half }, (_, index) => {
      const word = bytes[index] | (bytes[half + index] << 8);
      return (word >>> 1) ^ -(word & 1);
    });
  }

  /**
   * Return a body's pose at an instant, between the states before and after.
   * @param {Body} body
   * @param {number} time
   */
  pose(body, time) {
    const exact = Math.min(Math.max(time / this.period - body.first, 0), body.last - body.first);
    const from = Math.floor(exact);
    const to = Math.min(from + 1, body.last - body.first);
    /** @type {(values: Float32Array) => number} */
    const mix = (values) => values[from] + (values[to] - values[from]) * (exact - from);
    return { x: mix(body.x), y: mix(body.y), theta: mix(body.theta) };
  }

  /**
   * Return the alive targets: a caught target leaves after the state on which its catch was judged (R1.4).
   * @param {number} time
   */
  alive(time) {
    const state = time / this.period;
    return this.targets.filter(({ first, last }) => first <= state && (state <= last || last === this.steps));
  }

  /**
   * Return each hunter's number of catches before an instant.
   * @param {number} time
   */
  scores(time) {
    const scores = this.hunters.map(() => 0);
    for (const caught of this.catches) if (caught.time < time) scores[caught.seat] += 1;
    return scores;
  }

  /**
   * Return each team's number of catches before an instant; empty if there are no teams.
   * @param {number} time
   */
  teamScores(time) {
    const scores = this.scores(time);
    return (this.teams ?? []).map(({ seats }) => seats.reduce((sum, seat) => sum + scores[seat], 0));
  }

  /**
   * Return how many times each prey was caught before an instant, and if it is out then.
   * @param {number} time
   */
  hunted(time) {
    const alive = new Set(this.alive(time).map(({ prey }) => prey));
    return this.prey.map(({ lives }, index) => ({
      caught: lives.filter(({ last }) => last < this.steps && last * this.period < time).length,
      out: !alive.has(index),
    }));
  }

  /**
   * Return true if an agent is withdrawn; agents are the hunters by seat, then the prey by index.
   * @param {number} agent
   * @param {number} time
   */
  withdrawn(agent, time) {
    return this.withdrawals.some(([step, left]) => left === agent && step * this.period <= time);
  }

  /**
   * Return the latest caption, if it is not older than a number of milliseconds.
   * @param {number} time
   * @param {number} lasts
   */
  captionAt(time, lasts) {
    const latest = this.moments.findLast((moment) => moment.time <= time);
    return latest && time - latest.time < lasts ? latest : null;
  }

  /**
   * Return the answer to the contest that is nearest to an instant, if it is shown then.
   * @param {number} time
   * @param {number[]} shown time for which an answer is shown before and after its contest, in milliseconds
   */
  answerAt(time, [before, after]) {
    /** @type {(answer: Answer) => number} */
    const age = ({ contest }) => time - contest.time;
    const shown = this.answers.filter((answer) => -before <= age(answer) && age(answer) <= after);
    return shown.sort((one, other) => Math.abs(age(one)) - Math.abs(age(other))).at(0) ?? null;
  }

  /**
   * Return the contests of a hunter; all contests if no hunter is selected.
   * @param {number | null} seat
   */
  contestsOf(seat) {
    return this.contests.filter(({ parties }) => seat === null || parties.includes(seat));
  }
}

/**
 * Throw an Error that names the first field that is not as bundle.py writes it.
 * @param {any} facts
 * @returns {asserts facts is Facts}
 */
function check(facts) {
  /** @typedef {(value: any) => boolean} Fits */
  /** @type {(fits: boolean, field: string, value: unknown, requirement: string) => void} */
  const must = (fits, field, value, requirement) => {
    if (!fits) {
      throw damaged(`${field} must be ${requirement}, got ${(JSON.stringify(value) ?? "no value").slice(0, 60)}`);
    }
  };
  /** @type {Fits} */
  const isText = (value) => typeof value === "string";
  /** @type {Fits} */
  const isCount = (value) => Number.isSafeInteger(value) && value >= 0;
  /** @type {Fits} */
  const isState = (value) => isCount(value) && value <= facts.steps;
  /** @type {Fits} */
  const isSeat = (value) => isCount(value) && value < facts.hunters.length;
  /** @type {Fits} */
  const isAgent = (value) => isCount(value) && value < facts.hunters.length + facts.prey.length;
  /** @type {Fits} */
  const isColor = (value) => /^#[\da-f]{6}$/.test(value);
  /** @type {(fits: Fits) => Fits} */
  const isListOf = (fits) => (value) => Array.isArray(value) && value.every(fits);
  /** @type {(value: any, most: number) => boolean} */
  const isWithin = (value, most) => Number.isFinite(value) && value >= 0 && value <= most;
  /** @type {Fits} */
  const isNumberOrNull = (value) => value === null || isCount(value);
  /** @type {(...fits: Fits[]) => Fits} */
  const isRow = (...fits) => (row) => Array.isArray(row) && fits.every((fit, index) => fit(row[index]));
  const isClaim = isRow(isSeat, isText, isNumberOrNull);
  /** @type {Fits} */
  const isLens = (lens) =>
    isListOf(isCount)(lens?.corner) && isListOf(Number.isFinite)(lens.directions) && lens.directions.length > 1 &&
    isText(lens.result);

  must(facts !== null && typeof facts === "object", "the first line", facts, "an object");
  for (const field of ["title", "seed", "result"]) must(isText(facts[field]), field, facts[field], "text");
  for (const [field, [low, high]] of Object.entries(RANGES)) {
    const value = facts[field];
    must(Number.isFinite(value) && low <= value && value <= high, field, value, `a number from ${low} to ${high}`);
  }
  const { view } = facts;
  const isViewLimits = view === null ||
    (view && (view.radius === null || isWithin(view.radius, FARTHEST)) && isWithin(view.angle, 360));
  must(isViewLimits, "view", view, "a radius and an angle, or null");
  must(isCount(facts.steps), "steps", facts.steps, "a whole number");
  /** @type {[string, Fits, string][]} */
  const lists = [
    [
      "hunters",
      (one) =>
        isText(one?.name) && isText(one.label) && isColor(one.color) && isWithin(one.reach, FARTHEST) &&
        isCount(one.pieces) &&
        one.pieces > 0,
      "a name, a label, a colour, a reach and the number of a ring's arcs",
    ],
    [
      "prey",
      (one) => isText(one?.name) && isText(one.label) && isListOf(isCount)(one.targets),
      "a name, a label and the numbers of its targets",
    ],
    [
      "targets",
      (row) => isRow(isCount, isState, isCount)(row) && row[2] > 0 && row[1] + row[2] <= facts.steps + 1,
      "a number, its first state, and the number of its states",
    ],
    ["withdrawals", isRow(isState, isAgent), "a step and an agent"],
    [
      "rulings",
      isRow(isState, isSeat, isText, isNumberOrNull),
      "a state, a seat, a verdict, and a target's number or null",
    ],
    [
      "contests",
      (one) =>
        isState(one?.state) && [one.target, one.clause, one.sentence].every(isText) && isListOf(isClaim)(one.claims) &&
        (one.lens === null || isLens(one.lens) && one.lens.directions.length <= one.claims.length),
      "a state, a target, a clause, claims, a sentence, and a lens or null",
    ],
    [
      "answers",
      (one) =>
        isCount(one?.contest) && isSeat(one.agent) && isText(one.text) && isState(one.first) && isCount(one.states) &&
        one.first + one.states <= facts.steps + 1,
      "a contest's index, a seat, a text, the first state of a way, and the number of its states",
    ],
    [
      "moments",
      (one) => isCount(one?.time) && isSeat(one.agent) && isText(one.text) && isNumberOrNull(one.contest),
      "a time, a seat, a text, and a contest's index or null",
    ],
  ];
  for (const [field, fits, requirement] of lists) {
    const list = facts[field];
    must(Array.isArray(list), field, list, "a list");
    for (const [index, one] of list.entries()) must(fits(one), `${field}[${index}]`, one, requirement);
  }
  /** @type {Fits} */
  const isTeam = (one) => isText(one?.name) && isColor(one.color) && isListOf(isSeat)(one.seats);
  must(
    facts.teams === null || isListOf(isTeam)(facts.teams),
    "teams",
    facts.teams,
    "names, colours and seats, or null",
  );
}
