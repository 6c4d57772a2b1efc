import { Painter } from "./arena.js";
import { Replay, unpacked } from "./replay.js";
import { readableOn } from "./shapes.js";

/** @typedef {import("./shapes.js").Look} Look */
/** @typedef {import("./replay.js").Claim} Claim */

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
const KEYS = [
  ["Space", "play, pause"],
  ["← →", "1 s back, forward; with Shift one step"],
  ["P N", "previous, next contest"],
  ["H, 0 to 9, Esc", "select the next hunter, one by number, none"],
  ["V", "view of the selected hunter, if views are limited"],
  ["W", "what would have won a lost contest, if the page has an answer"],
  ["+ −", "faster, slower"],
  ["Home End", "the beginning, the end"],
];

/**
 * Make an element with its properties and children.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<HTMLElementTagNameMap[Tag]>} [properties]
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
function make(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

/** @param {number} time */
const seconds = (time, digits = 1) => `${(time / 1000).toFixed(digits)} s`;
/** @param {number | null} micrometres */
const metres = (micrometres) => (micrometres === null ? "not measured" : `${(micrometres / 1e6).toFixed(6)} m`);
/** @param {{ caught: number, out: boolean }} prey */
const preyStatus = ({ caught, out }) => `${out ? "out, " : ""}caught ${caught}`;
/** @param {string} verdict */
const words = (verdict) => verdict.toLowerCase().replaceAll("_", " ");

/** Formats of clips, the preferred one first. */
const CLIPS = ["video/webm;codecs=vp9", "video/webm", "video/mp4"];
/** Time of a clip before and after the instant that is shown, in milliseconds. */
const [CLIP_BEFORE, CLIP_AFTER] = [2000, 1500];
/** Least side of a clip, in pixels. */
const CLIP_SIDE = 720;

/**
 * Element <catch-replay bundle="…">: plays a recorded match. It needs nothing from the page around it.
 *
 * With `start`, it begins at this instant. With `end` too, it repeats the part between them, and shows only the arena.
 * With `address`, such as "#match=1", it has a button that copies a link to the instant that is shown.
 * With `what-if`, it shows the replay's answers to lost contests; without it, it does so on demand.
 */
export class CatchReplay extends HTMLElement {
  /** `film` is the former name of `bundle`, which saved notebooks contain. */
  static observedAttributes = ["bundle", "film"];
  static unpacked = unpacked;
  static style = "";
  /** @type {Look} set by the page, from the tables of render/ */
  static look;

  /** @type {Replay | null} */
  replay = null;
  /** The instant that is shown, in milliseconds. */
  time = 0;
  /** @type {number | null} the seat of the selected hunter */
  picked = null;
  /** True if the view of the selected hunter is shown. */
  viewed = false;
  /** True if answers to lost contests are shown. */
  asked = false;
  speed = 1;
  playing = false;
  /** True if playing begins when the replay has been read. */
  waiting = false;
  /** The id of the requested frame. */
  frame = 0;
  /** @type {number | null} the time of the previous frame */
  last = null;
  /** @type {number | null} the end of the clip that is being saved */
  saved = null;
  /** @type {MediaRecorder | null} the recorder of that clip */
  recorder = null;
  /** @type {import("./replay.js").Contest | null} the contest that is explained */
  explained = null;
  painter = new Painter(CatchReplay.look);
  calm = matchMedia("(prefers-reduced-motion: reduce)");

  arena = make("canvas", { className: "arena", tabIndex: 0, role: "img" });
  teams = make("ol", { className: "teams", ariaLabel: "Teams" });
  cast = make("ol", { className: "cast", ariaLabel: "Hunters" });
  hunted = make("ol", { className: "cast", ariaLabel: "Prey" });
  note = make("p", { className: "note" });
  closeUp = make("canvas", { className: "close-up", role: "img" });
  claims = make("ol", { className: "claims" });
  reason = make("p", { className: "reason" });
  answer = make("p", { className: "reason" });
  contest = make("div", { className: "contest", hidden: true }, this.closeUp, this.claims, this.reason, this.answer);
  spoken = make("p", { className: "spoken", ariaLive: "polite" });
  strip = make("canvas", { className: "strip", ariaHidden: "true" });
  scrub = make("input", { type: "range", min: "0", value: "0", ariaLabel: "Time" });
  toggle = make("button", { type: "button", className: "toggle" });
  previous = make("button", { type: "button", textContent: "Previous", ariaLabel: "Previous contest" });
  next = make("button", { type: "button", textContent: "Next contest" });
  clip = make("button", {
    type: "button",
    className: "share",
    textContent: "Save clip",
    hidden: !globalThis.MediaRecorder,
  });
  link = make("button", { type: "button", className: "share", textContent: "Copy link", hidden: true });
  sight = make("button", { type: "button", textContent: "Show its view", ariaPressed: "false", hidden: true });
  whatIf = make("button", {
    type: "button",
    className: "asks",
    textContent: "What if?",
    ariaPressed: "false",
    hidden: true,
  });
  clock = make("output", { className: "clock" });
  pace = make("select", { ariaLabel: "Speed" });
  whole = make("div", { className: "player", role: "group", ariaLabel: "Replay" });

  constructor() {
    super();
    this.#build();
    this.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#fit()).observe(this.arena);
  }

  /**
   * Load the replay of a new attribute value, which may be set at any time.
   * @param {string} name
   * @param {string | null} before
   * @param {string | null} text
   */
  async attributeChangedCallback(name, before, text) {
    if (!text || before === text) return;
    this.pause();
    this.replay = null;
    try {
      const replay = await Replay.of(text);
      if (this.getAttribute(name) !== text) return; // another replay was requested meanwhile
      this.replay = replay;
    } catch (error) {
      this.note.textContent = `The replay cannot be shown. ${error instanceof Error ? error.message : error}`;
      return;
    }
    this.time = Math.min(this.#milliseconds("start") ?? 0, this.replay.duration);
    this.link.hidden = !this.hasAttribute("address");
    this.whatIf.hidden = !this.#answers(this.replay).length;
    this.asked = this.hasAttribute("what-if");
    this.#cast(this.replay);
    this.#fit();
    this.#describe();
    if (this.waiting) this.play();
    this.dispatchEvent(new Event("load"));
  }

  play() {
    this.waiting = !this.replay;
    if (!this.replay || this.playing) return;
    if (this.time >= this.replay.duration) this.time = 0;
    this.playing = true;
    this.last = null;
    this.#button();
    this.frame = requestAnimationFrame((now) => this.#advance(now));
  }

  pause() {
    this.waiting = false;
    if (!this.playing) return;
    this.playing = false;
    this.saved = null;
    this.recorder?.stop();
    this.recorder = null;
    cancelAnimationFrame(this.frame);
    this.#button();
    this.#draw();
    this.#describe();
  }

  /**
   * Show an instant.
   * @param {number} time
   */
  seek(time) {
    if (!this.replay) return;
    this.time = Math.min(Math.max(time, 0), this.replay.duration);
    this.#draw();
    if (!this.playing) this.#describe();
  }

  /**
   * Select one hunter, or none.
   * @param {number | null} seat
   */
  pick(seat) {
    this.picked = seat;
    this.sight.disabled = seat === null;
    this.cast.querySelectorAll("button").forEach((button, index) => (button.ariaPressed = String(index === seat)));
    this.#draw();
    this.#describe();
  }

  /** Show or hide the view of the selected hunter. */
  toggleView() {
    if (!this.replay) return;
    if (!this.replay.view || this.picked === null) {
      this.spoken.textContent = this.replay.view ? "Select a hunter first." : "All hunters see the whole arena.";
      return;
    }
    this.viewed = !this.viewed;
    this.sight.ariaPressed = String(this.viewed);
    this.#draw();
  }

  /**
   * Show or hide what would have won lost contests.
   * @param {boolean} asked
   */
  ask(asked) {
    this.asked = asked;
    this.#draw();
    this.#describe();
  }

  /** Show what would have won a contest, of the next one that has an answer if none is near; or hide it. */
  toggleAnswer() {
    const { replay } = this;
    if (!replay) return;
    const answers = this.#answers(replay);
    if (!answers.length) {
      this.spoken.textContent = "This replay has no answer to a lost contest.";
      return;
    }
    this.ask(!this.asked);
    if (!this.asked) return;
    let answer = replay.answerAt(this.time, CatchReplay.look.answerMs);
    if (!answer) {
      answer = answers.find(({ contest }) => contest.time > this.time) ?? answers[0];
      this.pause();
      this.seek(answer.contest.time);
    }
    this.spoken.textContent = answer.text;
  }

  /** Save the part around the instant that is shown as a video: it is played once and recorded. */
  async save() {
    const { replay, arena, time, playing } = this;
    if (!replay || this.saved !== null) return;
    const type = CLIPS.find((one) => MediaRecorder.isTypeSupported(one));
    const end = this.#milliseconds("end");
    const start = end === null ? time - CLIP_BEFORE : this.#milliseconds("start") ?? 0;
    this.pause();
    this.seek(start);
    this.saved = Math.min(end ?? time + CLIP_AFTER, replay.duration);
    this.clip.disabled = true;
    this.clip.textContent = "Saving …";
    this.#fit();
    const recorder = new MediaRecorder(arena.captureStream(), { mimeType: type, videoBitsPerSecond: 8e6 });
    /** @type {Blob[]} */
    const parts = [];
    recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
    const stopped = new Promise((resolve) => recorder.addEventListener("stop", resolve));
    this.recorder = recorder;
    recorder.start();
    this.play();
    await stopped;
    recorder.stream.getTracks().forEach((track) => track.stop());
    this.clip.disabled = false;
    this.clip.textContent = "Save clip";
    this.#fit();
    if (this.replay === replay) this.seek(time);
    if (playing) this.play();
    const href = URL.createObjectURL(new Blob(parts, { type: recorder.mimeType }));
    const name = `${replay.title || "match"} ${seconds(time)}`.replaceAll(/[^\p{L}\p{N}.]+/gu, "-");
    make("a", { href, download: `${name}.${recorder.mimeType.includes("mp4") ? "mp4" : "webm"}` }).click();
    setTimeout(() => URL.revokeObjectURL(href), 60_000);
    this.spoken.textContent = "The clip has been saved.";
  }

  /** Copy a link to the instant that is shown; if that is not allowed, the address bar gets it. */
  async share() {
    const address = this.getAttribute("address") ?? "";
    const at = this.hasAttribute("end") ? "" : `&t=${this.time / 1000}`;
    const { href } = new URL(address + at + (this.asked ? "&what-if" : ""), location.href);
    try {
      await navigator.clipboard.writeText(href);
      this.link.textContent = "Copied";
    } catch {
      history.replaceState(null, "", href);
      this.link.textContent = "See the address bar";
    }
    this.spoken.textContent = `${this.link.textContent}.`;
    setTimeout(() => (this.link.textContent = "Copy link"), 2000);
  }

  /**
   * Go to the next or the previous contest of the selected hunter.
   * @param {1 | -1} direction
   */
  jump(direction) {
    if (!this.replay) return;
    const contests = this.replay.contestsOf(this.picked);
    const found = direction > 0
      ? contests.find(({ time }) => time > this.time)
      : contests.findLast(({ time }) => time < this.time);
    if (!found) {
      this.spoken.textContent = direction > 0 ? "There is no later contest." : "There is no earlier contest.";
      return;
    }
    this.pause();
    this.seek(found.time);
    this.spoken.textContent = found.sentence;
  }

  #build() {
    this.scrub.addEventListener("input", () => this.seek(Number(this.scrub.value)));
    this.toggle.addEventListener("click", () => this.#toggle());
    this.previous.addEventListener("click", () => this.jump(-1));
    this.next.addEventListener("click", () => this.jump(1));
    this.sight.addEventListener("click", () => this.toggleView());
    this.whatIf.addEventListener("click", () => this.toggleAnswer());
    this.clip.addEventListener("click", () => this.save());
    this.link.addEventListener("click", () => this.share());
    this.pace.append(...SPEEDS.map((speed) => make("option", { value: String(speed), textContent: `${speed} ×` })));
    this.pace.value = String(this.speed);
    this.pace.addEventListener("change", () => (this.speed = Number(this.pace.value)));
    const keys = KEYS.flatMap(([key, does]) => [make("dt", { textContent: key }), make("dd", { textContent: does })]);
    const parts = [
      make(
        "div",
        { className: "stage" },
        this.arena,
        make("div", { className: "time" }, this.strip, this.scrub),
        make(
          "div",
          { className: "controls" },
          this.toggle,
          this.previous,
          this.next,
          this.sight,
          this.whatIf,
          this.clip,
          this.link,
          this.clock,
          this.pace,
        ),
      ),
      make(
        "div",
        { className: "aside" },
        this.teams,
        this.cast,
        this.hunted,
        this.note,
        this.contest,
        make(
          "details",
          { className: "keys" },
          make("summary", { textContent: "Keys" }),
          make("dl", {}, ...keys),
        ),
      ),
      this.spoken,
    ];
    this.whole.append(...parts);
    const root = this.attachShadow({ mode: "open", delegatesFocus: true });
    root.append(make("style", { textContent: CatchReplay.style }), this.whole);
    this.#button();
  }

  /**
   * Fill the lists of hunters, teams and prey; a line of the first selects its hunter.
   * @param {Replay} replay
   */
  #cast({ hunters, teams, prey, duration, period, title, seed, contests, view }) {
    this.teams.replaceChildren(
      ...(teams ?? []).map(({ name, color }) => {
        const line = make("li", {}, make("span", { className: "name", textContent: name }), make("b"));
        line.style.borderColor = color;
        return line;
      }),
    );
    this.hunted.replaceChildren(
      ...prey.map(({ label }, index) =>
        make(
          "li",
          { className: "prey" },
          chip(`P${index}`, CatchReplay.look.target),
          make("span", { className: "name", textContent: label }),
          make("span", { className: "score" }),
        )
      ),
    );
    this.cast.replaceChildren(
      ...hunters.map(({ label, color }, seat) => {
        const score = make("span", { className: "score" });
        const line = make(
          "button",
          { type: "button", onclick: () => this.pick(this.picked === seat ? null : seat) },
          chip(String(seat), color),
          make("span", { className: "name", textContent: label }),
          score,
        );
        return make("li", {}, line);
      }),
    );
    this.pick(null);
    this.sight.hidden = !view;
    this.scrub.max = String(duration);
    this.scrub.step = String(period);
    this.previous.disabled = this.next.disabled = !contests.length;
    this.whole.ariaLabel = `Replay: ${title || "match"}, seed ${seed}`;
    this.strip.style.height = `${Math.min(96, 16 + 9 * hunters.length)}px`;
  }

  /**
   * Return true if the replay has come to its end, and there was something to play.
   * @param {Replay} replay
   */
  #over({ duration }) {
    return !this.playing && duration > 0 && this.time === duration;
  }

  /**
   * Return the answers to contests of the part that plays.
   * @param {Replay} replay
   */
  #answers({ answers }) {
    const [start, end] = [this.#milliseconds("start") ?? 0, this.#milliseconds("end")];
    return end === null ? answers : answers.filter(({ contest }) => start <= contest.time && contest.time <= end);
  }

  #button() {
    this.toggle.textContent = this.playing ? "Pause" : "Play";
  }

  #toggle() {
    if (this.playing || this.waiting) this.pause();
    else this.play();
  }

  /** @param {number} now */
  #advance(now) {
    if (!this.playing || !this.replay) return;
    const passed = this.last === null ? 0 : Math.min(now - this.last, 100); // a page in the background stands still
    this.last = now;
    const looped = this.saved === null ? this.#milliseconds("end") : null;
    const end = Math.min(this.saved ?? looped ?? Infinity, this.replay.duration);
    this.time = Math.min(this.time + passed * this.speed, end);
    this.#draw();
    if (this.time < end || looped !== null) {
      if (this.time >= end) this.time = this.#milliseconds("start") ?? 0;
      this.frame = requestAnimationFrame((later) => this.#advance(later));
      return;
    }
    const whole = this.saved === null;
    this.pause();
    if (whole) this.spoken.textContent = `${this.replay.result}.`;
  }

  /**
   * Return an attribute that is a time; null if it is missing.
   * @param {"start" | "end"} name
   */
  #milliseconds(name) {
    const text = this.getAttribute(name);
    return text === null ? null : Number(text) || 0;
  }

  /** Give the canvases the resolution of the screen; the arena has at least that of a clip while one is saved. */
  #fit() {
    if (this.recorder?.state === "recording") return;
    for (const canvas of [this.arena, this.strip]) {
      canvas.width = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio));
      canvas.height = Math.max(1, Math.round(canvas.clientHeight * devicePixelRatio));
    }
    if (this.saved !== null) this.arena.width = this.arena.height = Math.max(CLIP_SIDE, this.arena.width);
    this.explained = null; // its lens has to be drawn again
    this.#draw();
  }

  #draw() {
    const { replay, time, picked, viewed, playing, speed, asked } = this;
    if (!replay || !this.arena.clientWidth) return;
    const calm = this.calm.matches;
    const grows = playing && !calm ? CatchReplay.look.lensGrowsMs * speed : 0;
    const over = this.#over(replay);
    this.painter.paint(this.arena, replay, time, { picked, viewed, calm, grows, over, asked });
    this.whatIf.ariaPressed = String(asked);
    this.painter.strip(this.strip, replay, picked);
    const scores = replay.scores(time);
    this.cast.querySelectorAll(".score").forEach((node, seat) => (node.textContent = String(scores[seat])));
    const teamScores = replay.teamScores(time);
    this.teams.querySelectorAll("b").forEach((node, team) => (node.textContent = String(teamScores[team])));
    const hunted = replay.hunted(time);
    this.hunted.querySelectorAll(".score").forEach((node, index) => (node.textContent = preyStatus(hunted[index])));
    this.clock.textContent = `${seconds(time)} of ${seconds(replay.duration, 0)}`;
    this.scrub.value = String(time);
    this.scrub.ariaValueText = this.clock.textContent;
    this.#explain(replay);
  }

  /**
   * Show the latest contest: distances, deciding rule and winner.
   * @param {Replay} replay
   */
  #explain(replay) {
    const { time, picked } = this;
    const contests = replay.contestsOf(picked);
    const contest = contests.findLast(({ time: judged }) => judged <= time);
    this.contest.hidden = !contest;
    const owner = picked === null ? "" : ` of ${replay.hunters[picked].label}`;
    if (!contests.length) {
      this.note.textContent =
        `No contest${owner}: no target was requested by two hunters within reach in the same step.`;
    } else if (contest) {
      const which = `Contest ${contests.indexOf(contest) + 1} of ${contests.length}${owner}`;
      const { prey } = contest.place;
      const whose = prey === null ? "" : `, P${prey}`;
      this.note.textContent = `${which}${whose}, step ${contest.state + 1} (${contest.clause})`;
    } else {
      const count = contests.length === 1 ? "1 contest" : `${contests.length} contests`;
      this.note.textContent = `${count}${owner}, the first at ${seconds(contests[0].time)}`;
    }
    if (!contest || contest === this.explained) return;
    this.explained = contest;
    this.reason.textContent = contest.sentence;
    const answers = replay.answers.filter((answer) => answer.contest === contest).map(({ text }) => text);
    this.answer.textContent = answers.length ? `What if? ${answers.join(" ")}` : "";
    this.answer.hidden = !answers.length;
    this.claims.replaceChildren(...contest.claims.map((claim) => this.#claim(replay, claim)));
    this.closeUp.hidden = !contest.lens;
    if (!contest.lens) return;
    this.closeUp.ariaLabel = `Close-up of ${contest.target} in step ${contest.state + 1}: ${contest.lens.result}`;
    this.closeUp.width = this.closeUp.height = Math.round(this.closeUp.clientWidth * devicePixelRatio);
    this.painter.closeUp(this.closeUp, replay, contest);
  }

  /**
   * @param {Replay} replay
   * @param {Claim} claim
   */
  #claim({ hunters }, [seat, verdict, distance]) {
    const { label, color, reach } = hunters[seat];
    const bar = make("span", { className: "bar" });
    bar.style.width = `${Math.min(100, (100 * (distance ?? 0)) / (1e6 * reach))}%`;
    bar.style.background = color;
    return make(
      "li",
      { className: verdict === "LOST_CONTEST" ? "lost" : "won" },
      make(
        "span",
        { className: "who" },
        chip(String(seat), color),
        make("span", { className: "name", textContent: label }),
        make("span", { className: "verdict", textContent: words(verdict) }),
      ),
      make("span", { className: "rule" }, bar),
      make("span", { className: "distance", textContent: metres(distance) }),
    );
  }

  /** Update the description of the arena for screen readers. */
  #describe() {
    if (!this.replay) return;
    const { replay, time } = this;
    const scores = replay.scores(time);
    const sentences = [
      `Catches: ${replay.hunters.map(({ label }, seat) => `${label} has ${scores[seat]}`).join(", ")}.`,
    ];
    const { teams, prey } = replay;
    if (teams) {
      const sums = replay.teamScores(time);
      sentences.unshift(`Teams: ${teams.map(({ name }, team) => `${name} ${sums[team]}`).join(", ")}.`);
    }
    if (prey.length) {
      const hunted = replay.hunted(time);
      sentences.push(`Prey: ${prey.map(({ label }, index) => `${label} ${preyStatus(hunted[index])}`).join(", ")}.`);
    }
    const caption = replay.captionAt(time, CatchReplay.look.captionMs);
    const answer = this.asked ? replay.answerAt(time, CatchReplay.look.answerMs) : null;
    if (this.#over(replay)) sentences.unshift(`${replay.result}.`);
    else if (answer) sentences.unshift(`What if? ${answer.text}`);
    else if (caption) sentences.unshift(`${caption.text}.`);
    this.arena.ariaLabel = `The arena at ${seconds(this.time)}. ${sentences.join(" ")}`;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { replay } = this;
    const [inside] = event.composedPath();
    if (event.ctrlKey || event.metaKey || event.altKey || inside === this.pace) return;
    if (inside !== this.arena && inside !== this.scrub && ["Enter", " "].includes(event.key)) return; // a button's own
    const action = event.key === " " ? () => this.#toggle() : replay && this.#action(event, replay);
    if (!action) return;
    event.preventDefault();
    event.stopPropagation(); // a notebook has keys of its own
    action();
  }

  /**
   * Return the action of a key. The space bar is not here, since it works before the replay has been read, too.
   * @param {KeyboardEvent} event
   * @param {Replay} replay
   * @returns {(() => void) | undefined}
   */
  #action(event, replay) {
    const stride = event.shiftKey ? replay.period : 1000;
    /** @type {(way: 1 | -1) => number} */
    const change = (way) => SPEEDS[Math.min(Math.max(SPEEDS.indexOf(this.speed) + way, 0), SPEEDS.length - 1)];
    /** @param {1 | -1} way */
    const pace = (way) => {
      this.speed = change(way);
      this.pace.value = String(this.speed);
    };
    const seats = replay.hunters.length;
    const following = this.picked === null ? 0 : this.picked + 1 < seats ? this.picked + 1 : null;
    /** @type {Record<string, () => void>} */
    const actions = {
      arrowleft: () => this.seek(this.time - stride),
      arrowright: () => this.seek(this.time + stride),
      p: () => this.jump(-1),
      n: () => this.jump(1),
      h: () => this.pick(following),
      escape: () => this.pick(null),
      v: () => this.toggleView(),
      w: () => this.toggleAnswer(),
      "+": () => pace(1),
      "=": () => pace(1),
      "-": () => pace(-1),
      home: () => this.seek(0),
      end: () => this.seek(replay.duration),
    };
    const seat = /^\d$/.test(event.key) ? Number(event.key) : NaN;
    return seat < seats ? () => this.pick(seat) : actions[event.key.toLowerCase()];
  }
}

/**
 * Make a chip: an agent's number on its colour.
 * @param {string} number
 * @param {string} color
 */
function chip(number, color) {
  const node = make("span", { className: "chip", textContent: number, ariaHidden: "true" });
  node.style.background = color;
  node.style.color = readableOn(color, CatchReplay.look);
  return node;
}
