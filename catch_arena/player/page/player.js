const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
const KEYS = [
  ["Space", "play, pause"],
  ["← →", "a second back, on; with Shift a step"],
  ["P N", "previous, next contest"],
  ["H, 0 to 9, Esc", "pick the next hunter, one by its number, none"],
  ["+ −", "faster, slower"],
  ["Home End", "the beginning, the end"],
];

const make = (tag, properties = {}, ...children) => {
  const { attributes = {}, ...rest } = properties;
  const node = Object.assign(document.createElement(tag), rest);
  Object.entries(attributes).forEach(([name, value]) => node.setAttribute(name, value));
  node.append(...children);
  return node;
};

const seconds = (time, digits = 1) => `${(time / 1000).toFixed(digits)} s`;
const metres = (micrometres) => (micrometres === null ? "not measured" : `${(micrometres / 1e6).toFixed(6)} m`);
const words = (verdict) => verdict.toLowerCase().replaceAll("_", " ");

/** <catch-replay film="…">: a recorded match that plays. It needs nothing from the page around it. */
class CatchReplay extends HTMLElement {
  static observedAttributes = ["film"];

  constructor() {
    super();
    this.painter = new Painter(CatchReplay.look);
    this.attachShadow({ mode: "open", delegatesFocus: true });
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.speed = 1;
    this.#build();
    this.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#fit()).observe(this.arena);
  }

  /** A replay may come with the element, or later, or be changed for another. */
  async attributeChangedCallback(_, before, text) {
    if (!text || before === text) return;
    this.pause();
    this.replay = null;
    try {
      const replay = await Replay.of(text);
      if (this.getAttribute("film") !== text) return; // another one was asked for meanwhile
      this.replay = replay;
    } catch (error) {
      this.note.textContent = `This browser cannot show the replay: ${error.message}`;
      return;
    }
    this.time = 0;
    this.picked = null;
    this.#cast();
    this.#fit();
    this.#describe();
  }

  play() {
    if (!this.replay || this.playing) return;
    if (this.time >= this.replay.duration) this.time = 0;
    this.playing = true;
    this.last = null;
    this.#button();
    this.frame = requestAnimationFrame((now) => this.#advance(now));
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    cancelAnimationFrame(this.frame);
    this.#button();
    this.#describe();
  }

  /** Show an instant. */
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.replay.duration);
    this.#draw();
    if (!this.playing) this.#describe();
  }

  /** Follow one hunter, or none. */
  pick(seat) {
    this.picked = seat;
    [...this.cast.children].forEach((row, index) => {
      row.firstChild.setAttribute("aria-pressed", String(index === seat));
    });
    this.#draw();
    this.#describe();
  }

  /** The next contest of the picked hunter, or the one before. */
  jump(direction) {
    const contests = this.replay.contestsOf(this.picked);
    const found =
      direction > 0
        ? contests.find(({ time }) => time > this.time)
        : contests.findLast(({ time }) => time < this.time);
    if (!found) {
      this.spoken.textContent = direction > 0 ? "No contest after this." : "No contest before this.";
      return;
    }
    this.pause();
    this.seek(found.time);
    this.spoken.textContent = found.sentence;
  }

  #build() {
    this.arena = make("canvas", { className: "arena", tabIndex: 0, attributes: { role: "img" } });
    this.cast = make("ol", { className: "cast", attributes: { "aria-label": "Hunters" } });
    this.note = make("p", { className: "note" });
    this.closeUp = make("canvas", { className: "close-up", attributes: { role: "img" } });
    this.claims = make("ol", { className: "claims" });
    this.reason = make("p", { className: "reason" });
    this.contest = make("div", { className: "contest", hidden: true }, this.closeUp, this.claims, this.reason);
    this.spoken = make("p", { className: "spoken", attributes: { "aria-live": "polite" } });
    this.strip = make("canvas", { className: "strip", attributes: { "aria-hidden": "true" } });
    this.scrub = make("input", { type: "range", min: 0, value: 0, attributes: { "aria-label": "Time" } });
    this.scrub.addEventListener("input", () => this.seek(Number(this.scrub.value)));
    this.toggle = make("button", { type: "button", className: "toggle", onclick: () => this.#toggle() });
    this.before = make("button", { type: "button", textContent: "Previous", onclick: () => this.jump(-1) });
    this.before.setAttribute("aria-label", "Previous contest");
    this.next = make("button", { type: "button", textContent: "Next contest", onclick: () => this.jump(1) });
    this.clock = make("output", { className: "clock" });
    const paces = SPEEDS.map((speed) => make("option", { value: speed, textContent: `${speed} ×` }));
    this.pace = make("select", { attributes: { "aria-label": "Speed" } }, ...paces);
    this.pace.value = this.speed;
    this.pace.addEventListener("change", () => (this.speed = Number(this.pace.value)));
    const listed = KEYS.flatMap(([key, does]) => [make("dt", { textContent: key }), make("dd", { textContent: does })]);
    const keys = make("details", { className: "keys" }, make("summary", { textContent: "Keys" }), make("dl", {}, ...listed));
    const controls = make("div", { className: "controls" }, this.toggle, this.before, this.next, this.clock, this.pace);
    this.shadowRoot.append(
      make("style", { textContent: CatchReplay.style }),
      make(
        "div",
        { className: "player", attributes: { role: "group", "aria-label": "Replay" } },
        make(
          "div",
          { className: "stage" },
          this.arena,
          make("div", { className: "time" }, this.strip, this.scrub),
          controls,
        ),
        make("div", { className: "aside" }, this.cast, this.note, this.contest, keys, this.spoken),
      ),
    );
    this.#button();
  }

  /** The hunters' list: each line picks one. */
  #cast() {
    const { hunters, duration, title, seed, contests } = this.replay;
    this.cast.replaceChildren(
      ...hunters.map(({ name, color }, seat) => {
        const score = make("span", { className: "score" });
        const line = make(
          "button",
          { type: "button", onclick: () => this.pick(this.picked === seat ? null : seat) },
          chip(seat, color),
          make("span", { className: "name", textContent: name }),
          score,
        );
        return make("li", {}, line);
      }),
    );
    this.pick(null);
    this.scrub.max = duration;
    this.scrub.step = this.replay.period;
    this.before.disabled = this.next.disabled = !contests.length;
    this.shadowRoot.querySelector(".player").setAttribute("aria-label", `Replay: ${title || "match"}, seed ${seed}`);
    this.strip.style.height = `${Math.min(96, 16 + 9 * hunters.length)}px`;
  }

  #button() {
    this.toggle.textContent = this.playing ? "Pause" : "Play";
  }

  #toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  #advance(now) {
    if (!this.playing) return;
    const passed = this.last === null ? 0 : Math.min(now - this.last, 100); // a page in the background stands still
    this.last = now;
    this.time = Math.min(this.time + passed * this.speed, this.replay.duration);
    this.#draw();
    if (this.time >= this.replay.duration) this.pause();
    else this.frame = requestAnimationFrame((later) => this.#advance(later));
  }

  /** Canvases have as many dots as the screen. */
  #fit() {
    const ratio = window.devicePixelRatio || 1;
    for (const canvas of [this.arena, this.closeUp, this.strip]) {
      canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
      canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    }
    this.#draw();
  }

  #draw() {
    if (!this.replay || !this.arena.clientWidth) return;
    const { replay, time, picked } = this;
    this.painter.paint(this.arena, replay, time, picked, this.calm.matches);
    this.painter.strip(this.strip, replay, picked);
    const scores = replay.scores(time);
    [...this.cast.querySelectorAll(".score")].forEach((node, seat) => (node.textContent = scores[seat]));
    this.clock.textContent = `${seconds(time)} of ${seconds(replay.duration, 0)}`;
    this.scrub.value = time;
    this.scrub.setAttribute("aria-valuetext", `${seconds(time)} of ${seconds(replay.duration, 0)}`);
    this.#explain();
  }

  /** The latest contest: who was how far away, what decided, who won. */
  #explain() {
    const { replay, time, picked } = this;
    const contests = replay.contestsOf(picked);
    const contest = contests.findLast((one) => one.time <= time);
    this.contest.hidden = !contest;
    const who = picked === null ? "" : ` of ${replay.hunters[picked].name}`;
    if (!contests.length) this.note.textContent = `No contest${who}: in no step could two catch the same target.`;
    else if (contest) this.note.textContent = `Contest ${contests.indexOf(contest) + 1} of ${contests.length}${who}, step ${contest.state + 1} (${contest.clause})`;
    else this.note.textContent = `${contests.length} ${contests.length === 1 ? "contest" : "contests"}${who}, the first at ${seconds(contests[0].time)}`;
    if (!contest || contest === this.explained) return;
    this.explained = contest;
    this.reason.textContent = contest.sentence;
    this.claims.replaceChildren(...contest.claims.map((claim) => this.#claim(claim)));
    this.closeUp.setAttribute("aria-label", `Close-up of ${contest.target} in step ${contest.state + 1}`);
    this.closeUp.width = this.closeUp.height = Math.round(this.closeUp.clientWidth * (window.devicePixelRatio || 1));
    this.painter.closeUp(this.closeUp, replay, contest);
  }

  #claim([seat, verdict, distance]) {
    const { name, color } = this.replay.hunters[seat];
    const bar = make("span", { className: "bar" });
    bar.style.width = `${Math.min(100, (100 * (distance ?? 0)) / (1e6 * this.replay.reach))}%`;
    bar.style.background = color;
    return make(
      "li",
      { className: verdict === "LOST_CONTEST" ? "lost" : "won" },
      make(
        "span",
        { className: "who" },
        chip(seat, color),
        make("span", { className: "name", textContent: name }),
        make("span", { className: "verdict", textContent: words(verdict) }),
      ),
      make("span", { className: "rule" }, bar),
      make("span", { className: "distance", textContent: metres(distance) }),
    );
  }

  /** For those who cannot see the arena. */
  #describe() {
    if (!this.replay) return;
    const scores = this.replay.scores(this.time);
    const catches = this.replay.hunters.map(({ name }, seat) => `${name} ${scores[seat]}`).join(", ");
    this.arena.setAttribute("aria-label", `The arena at ${seconds(this.time)}. Catches: ${catches}.`);
  }

  #key(event) {
    const inside = event.composedPath()[0];
    if (!this.replay || event.ctrlKey || event.metaKey || event.altKey || inside.tagName === "SELECT") return;
    if (inside.tagName !== "CANVAS" && inside !== this.scrub && ["Enter", " "].includes(event.key)) return; // a button's own
    const stride = event.shiftKey ? this.replay.period : 1000;
    const change = (way) => SPEEDS[Math.min(Math.max(SPEEDS.indexOf(this.speed) + way, 0), SPEEDS.length - 1)];
    const pace = (way) => (this.pace.value = this.speed = change(way));
    const seats = this.replay.hunters.length;
    const following = this.picked === null ? 0 : this.picked + 1 < seats ? this.picked + 1 : null;
    const actions = {
      " ": () => this.#toggle(),
      arrowleft: () => this.seek(this.time - stride),
      arrowright: () => this.seek(this.time + stride),
      p: () => this.jump(-1),
      n: () => this.jump(1),
      h: () => this.pick(following),
      escape: () => this.pick(null),
      "+": () => pace(1),
      "=": () => pace(1),
      "-": () => pace(-1),
      home: () => this.seek(0),
      end: () => this.seek(this.replay.duration),
    };
    const seat = /^\d$/.test(event.key) ? Number(event.key) : NaN;
    const action = seat < seats ? () => this.pick(seat) : actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    event.stopPropagation(); // a notebook has keys of its own
    action();
  }
}

/** A hunter's number in its colour. */
function chip(seat, color) {
  const node = make("span", { className: "chip", textContent: seat, attributes: { "aria-hidden": "true" } });
  node.style.background = color;
  node.style.color = inkOn(color);
  return node;
}
