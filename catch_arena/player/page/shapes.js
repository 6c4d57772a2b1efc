/**
 * The colours, shapes and sizes of render/, as element.py writes them.
 * @typedef {object} Look
 * @property {string} ground
 * @property {string} outside
 * @property {string} grid
 * @property {string} wall
 * @property {string} target
 * @property {string} targetTrail
 * @property {string} ink
 * @property {string} panel behind texts
 * @property {string} bright of texts on a panel
 * @property {string} gold of headings
 * @property {number[]} gridSteps in metres
 * @property {number} gridGap least distance of two lines, in pixels
 * @property {number} hunterLength in metres
 * @property {number} targetLength in metres
 * @property {number} preyLength in metres
 * @property {number} preyPieces number of arcs of its ring
 * @property {number} margin part of the side
 * @property {number} lens part of the picture's side
 * @property {number} caption part of the picture's side
 * @property {number} captionMs time for which a caption and its lens are shown
 * @property {number[]} answerMs times for which an answer is shown before and after its contest
 * @property {number} leastArena side of the smallest picture with captions, in pixels
 * @property {number} lensGrowsMs
 * @property {number} mostNames greatest number of agents that have their names next to them
 * @property {number} leastNamed side of the smallest arena with names, in pixels
 * @property {number} longestName greatest width of a name next to a turtle, in sizes of its text
 * @property {number[]} podiumHeights
 * @property {number[][]} podiumPlaces
 * @property {number} dimmed brightness of the arena under the podium
 * @property {[own: number, white: number, points: [number, number][]][]} turtle
 */

/**
 * How a text is drawn: weight 600, from `x` to the right and in a single colour by default.
 * @typedef {object} Style
 * @property {string} color
 * @property {number} [weight]
 * @property {CanvasTextAlign} [align]
 * @property {string} [outline]
 * @property {number} [most] greatest width; a longer text ends in an ellipsis
 */

/** Height of the middle of capitals above the baseline, in sizes. */
const MIDDLE = 0.36;
/** Width of a text's outline, in sizes. */
const OUTLINE = 0.11;

/** A turtle from above, in any colour. */
export class Turtle {
  /** @param {Look} look */
  constructor({ ink, turtle }) {
    this.ink = ink;
    this.shadow = mixed(ink, ink, 0, 0.33);
    this.parts = turtle.map(([own, white, points]) => {
      const path = new Path2D();
      points.forEach(([x, y]) => path.lineTo(x, y));
      path.closePath();
      return { own, white, path };
    });
    /** @type {Map<string, string[]>} */
    this.dyes = new Map();
  }

  /**
   * Return the colour of each part: a mix of the turtle's own colour and white; less contrast makes it lighter.
   * @param {string} color
   * @param {number} contrast from 0 to 1
   */
  dyed(color, contrast) {
    const key = color + contrast;
    let inks = this.dyes.get(key);
    if (!inks) {
      /** @type {(own: number, white: number, channel: number) => number} */
      const part = (own, white, channel) => {
        const lit = channel * (1 - contrast);
        return Math.round(own * channel * contrast + white * (255 - lit) + lit);
      };
      inks = this.parts.map(({ own, white }) => `rgb(${rgb(color).map((channel) => part(own, white, channel))})`);
      this.dyes.set(key, inks);
    }
    return inks;
  }
}

/** Draws the shapes of render/shapes.py on a canvas, in pixels of the page, y downwards. */
export class Pen {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Turtle} shape
   */
  constructor(canvas, shape) {
    const context = canvas.getContext("2d");
    if (!context) throw new Error("This browser does not support canvas.");
    const dots = canvas.width / canvas.clientWidth;
    context.setTransform(dots, 0, 0, dots, 0, 0);
    this.context = context;
    this.shape = shape;
  }

  /**
   * Draw a filled rectangle with round corners.
   * @param {number} left
   * @param {number} top
   * @param {number} width
   * @param {number} height
   * @param {string} color
   * @param {number} [radius]
   */
  box(left, top, width, height, color, radius = 0) {
    this.context.fillStyle = color;
    this.context.beginPath();
    this.context.roundRect(left, top, width, height, radius);
    this.context.fill();
  }

  /**
   * Draw a line through points, with round ends.
   * @param {[x: number, y: number][]} points
   * @param {number} width
   * @param {string} color
   */
  path(points, width, color) {
    const { context } = this;
    context.strokeStyle = color;
    context.lineWidth = width;
    context.lineCap = context.lineJoin = "round";
    context.beginPath();
    points.forEach((point) => context.lineTo(...point));
    context.stroke();
  }

  /**
   * Draw the line of a circle, as a number of arcs.
   * @param {number} x
   * @param {number} y
   * @param {number} radius
   * @param {number} width
   * @param {string} color
   * @param {number} pieces
   */
  ring(x, y, radius, width, color, pieces) {
    const { context } = this;
    const piece = (2 * Math.PI * radius) / pieces;
    const gap = Math.max(3, Math.min(0.3 * piece, 6 * width));
    context.strokeStyle = color;
    context.lineWidth = width;
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
   * Draw a turtle.
   * @param {number} x
   * @param {number} y
   * @param {number} theta counter-clockwise, in radians
   * @param {number} length
   * @param {string} color
   * @param {number} [contrast] from 0 to 1
   * @param {boolean} [faded] true to draw it dark and translucent
   */
  turtle(x, y, theta, length, color, contrast = 1, faded = false) {
    const { context, shape } = this;
    context.save();
    context.globalAlpha = faded ? 0.55 : 1;
    context.translate(x, y);
    context.fillStyle = shape.shadow;
    context.beginPath();
    context.ellipse(0.05 * length, 0.07 * length, 0.36 * length, 0.3 * length, 0, 0, 2 * Math.PI);
    context.fill();
    context.rotate(-theta);
    context.scale(length, length);
    const inks = shape.dyed(faded ? mixed(color, shape.ink, 0.5) : color, contrast);
    for (const [index, { path }] of shape.parts.entries()) {
      context.fillStyle = inks[index];
      context.fill(path);
    }
    context.restore();
  }

  /**
   * Draw one line of text; `y` is the middle of its capitals.
   * @param {number} x
   * @param {number} y
   * @param {string} text
   * @param {number} size
   * @param {Style} style
   */
  label(x, y, text, size, { color, weight = 600, align = "left", outline, most = Infinity }) {
    const { context } = this;
    const shown = this.truncated(text, size, weight, most);
    context.textAlign = align;
    context.textBaseline = "alphabetic";
    if (outline) {
      context.lineJoin = "round";
      context.lineWidth = 2 * OUTLINE * size;
      context.strokeStyle = outline;
      context.strokeText(shown, x, y + MIDDLE * size);
    }
    context.fillStyle = color;
    context.fillText(shown, x, y + MIDDLE * size);
  }

  /**
   * Return the width of a text.
   * @param {string} text
   * @param {number} size
   * @param {number} weight
   */
  width(text, size, weight) {
    this.context.font = `${weight} ${size}px system-ui, sans-serif`;
    return this.context.measureText(text).width;
  }

  /**
   * Return the text, or as much of it as fits with an ellipsis.
   * @param {string} text
   * @param {number} size
   * @param {number} weight
   * @param {number} most
   */
  truncated(text, size, weight, most) {
    if (this.width(text, size, weight) <= most) return text;
    const letters = [...text];
    /** @param {number} count */
    const cut = (count) => `${letters.slice(0, count).join("").trimEnd()}…`;
    let count = letters.length - 1;
    while (count > 0 && this.width(cut(count), size, weight) > most) count -= 1;
    return count > 0 ? cut(count) : "";
  }

  /**
   * Return a text as lines that fit; a word that is too long has a line of its own.
   * @param {string} text
   * @param {number} size
   * @param {number} weight
   * @param {number} most
   */
  wrapped(text, size, weight, most) {
    const [first, ...words] = text.split(" ");
    const lines = [first];
    for (const word of words) {
      const longer = `${lines.at(-1)} ${word}`;
      if (this.width(longer, size, weight) <= most) lines[lines.length - 1] = longer;
      else lines.push(word);
    }
    return lines;
  }
}

/** @param {string} color #rrggbb, or #rrggbbaa, whose opacity is dropped */
const rgb = (color) => [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));

/** @param {number[]} channels */
const luminance = ([red, green, blue]) => 0.2126 * red + 0.7152 * green + 0.0722 * blue;

/**
 * Mix a colour with a part of another one.
 * @param {string} color
 * @param {string} added
 * @param {number} part
 */
export function mixed(color, added, part, opacity = 1) {
  const [from, to] = [rgb(color), rgb(added)];
  const channels = from.map((channel, index) => Math.round(channel + (to[index] - channel) * part));
  return `#${[...channels, Math.round(255 * opacity)].map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}

/**
 * Return the dark or the bright text colour, whichever stands out from a colour, as render/hud.py does.
 * @param {string} color
 * @param {Look} look
 */
export function readableOn(color, { panel, bright }) {
  return luminance(rgb(color)) > 120 ? panel : bright;
}

/**
 * Return a colour, lightened as far as texts on a panel need, as render/hud.py does.
 * @param {string} color
 */
export function legible(color) {
  const parts = Array.from({ length: 11 }, (_, tenths) => tenths / 10);
  const bright = (/** @type {number} */ part) =>
    luminance(rgb(color).map((channel) => channel + (255 - channel) * part)) >= 105;
  return mixed(color, "#ffffff", parts.find(bright) ?? 1);
}
