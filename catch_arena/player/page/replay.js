"use strict";

/** What Python's `packed_text` packed: base64 of gzip, as bytes. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** One match: who was where in every state, and what the arbiter answered. Times are in milliseconds. */
class Replay {
  static async of(text) {
    const bytes = await unpacked(text);
    const end = bytes.indexOf(10);
    const facts = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
    return new Replay(facts, bytes.subarray(end + 1));
  }

  constructor(facts, tracks) {
    Object.assign(this, facts);
    this.duration = this.steps * this.period;
    const numbers = Replay.numbers(tracks);
    let at = 0;
    const body = (first, length) => {
      const metres = this.side / this.grid;
      const [x, y, theta] = [metres, metres, (2 * Math.PI) / this.turn].map((unit) => {
        const values = new Float32Array(length);
        for (let state = 0, sum = 0; state < length; state++) values[state] = unit * (sum += numbers[at++]);
        return values;
      });
      return { first, last: first + length - 1, x, y, theta };
    };
    this.hunters.forEach((hunter) => Object.assign(hunter, body(0, this.steps + 1)));
    this.targets = this.targets.map(([number, first, length]) => ({ number, ...body(first, length) }));
    this.rulings = this.rulings.map(([state, seat, verdict, number]) => ({
      time: state * this.period,
      seat,
      verdict,
      target: this.targets.find((target) => target.number === number),
    }));
    this.catches = this.rulings.filter((ruling) => ruling.verdict === "GRANTED");
    this.contests.forEach((contest) => {
      contest.time = contest.state * this.period;
      const parties = contest.claims.map(([seat]) => seat);
      contest.place = this.rulings.find(({ time, seat }) => time === contest.time && parties.includes(seat)).target;
      contest.parties = parties;
    });
  }

  /** 16-bit differences: the sign is the lowest bit; all low bytes come first, then all high ones. */
  static numbers(bytes) {
    const half = bytes.length / 2;
    return Int16Array.from({ length: half }, (_, index) => {
      const word = bytes[index] | (bytes[half + index] << 8);
      return (word >>> 1) ^ -(word & 1);
    });
  }

  /** Where a body is at an instant, between the states before and after. */
  pose(body, time) {
    const exact = Math.min(Math.max(time / this.period - body.first, 0), body.last - body.first);
    const from = Math.floor(exact);
    const to = Math.min(from + 1, body.last - body.first);
    const mix = (values) => values[from] + (values[to] - values[from]) * (exact - from);
    return { x: mix(body.x), y: mix(body.y), theta: mix(body.theta) };
  }

  /** The targets that are there: one that is caught leaves after the state on which that was judged (R1.4). */
  alive(time) {
    const state = time / this.period;
    return this.targets.filter(({ first, last }) => first <= state && (state <= last || last === this.steps));
  }

  /** Each hunter's catches before an instant. */
  scores(time) {
    const scores = this.hunters.map(() => 0);
    for (const one of this.catches) if (one.time < time) scores[one.seat] += 1;
    return scores;
  }

  withdrawn(seat, time) {
    return this.withdrawals.some(([step, who]) => who === seat && step * this.period <= time);
  }

  /** The contests that a hunter took part in; all of them where none is picked. */
  contestsOf(seat) {
    return this.contests.filter(({ parties }) => seat === null || parties.includes(seat));
  }
}
