// Curves of θp, θc and m(t) around the page's frame, with τ, the playhead and a what-if.
var Curves = (function () {
  "use strict";

  const { wrap } = SwingTwist;
  const { inDegrees, signed, plain } = Labels;
  const LEFT = 44, RIGHT = 10, TOP = 16, BETWEEN = 20, BOTTOM = 18; // pixels
  const STEP = 45; // degrees; a plot grows in such steps until a dot fits into it
  const TICKS = 17; // the least distance between two of them, pixels
  const TWIST_SHARE = 0.56; // of the height is for θ, the rest for m

  class Plot {
    constructor(canvas, scrubbed) {
      this.canvas = canvas;
      this.scrubbed = scrubbed;
      canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        this._scrub(event);
      });
      canvas.addEventListener("pointermove", (event) => {
        if (event.buttons & 1) this._scrub(event);
      });
    }

    resize() {
      const ratio = Math.min(window.devicePixelRatio || 1, 2);
      this.canvas.width = Math.round(this.canvas.clientWidth * ratio);
      this.canvas.height = Math.round(this.canvas.clientHeight * ratio);
    }

    show(page) { // another span or chain
      this.page = page;
      const chain = page.chain;
      if (!chain) return;
      const frames = [];
      for (let f = page.first; f <= page.last; f++) frames.push(f);
      this.frames = frames;
      const values = (name) => frames.map((f) => chain[name][f - page.span.first]);
      this.lines = { p: about(values("theta_p")), c: about(values("theta_c")) };
      this.m = values("strength").map(inDegrees);
      this.range = rangeOf(this.lines.p.y.concat(this.lines.c.y));
      this.top = Math.max(1.25 * inDegrees(chain.tau), 1.1 * Math.max(...this.m), 1);
    }

    // state: { frame, theta_p, theta_c, m } of the what-if, or null; lit: symbols; look:
    // { roles, colourOf, paper }
    draw(state, lit, look) {
      const context = this.canvas.getContext("2d"), wide = this.canvas.clientWidth;
      const ratio = this.canvas.width / Math.max(wide, 1), high = this.canvas.clientHeight;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, wide, high);
      if (!this.page.chain) return;
      const split = TOP + TWIST_SHARE * (high - TOP - BETWEEN - BOTTOM);
      const dots = [
        { pane: 0, symbol: "theta_p", angle: turnedTo(state.theta_p, this.lines.p.centre) },
        { pane: 0, symbol: "across", angle: turnedTo(state.theta_c, this.lines.c.centre) },
        { pane: 1, symbol: "m", angle: state.m === null ? null : inDegrees(state.m) },
      ].filter((dot) => dot.angle !== null);
      const panes = [
        { top: TOP, bottom: split, low: this.range[0], high: this.range[1] },
        { top: split + BETWEEN, bottom: high - BOTTOM, low: 0, high: this.top },
      ];
      dots.forEach((dot) => { // in steps, so that a plot does not move with every step of a slider
        const pane = panes[dot.pane];
        while (dot.angle > pane.high) pane.high += STEP;
        while (dot.angle < pane.low) pane.low -= STEP;
      });
      const faint = (...symbols) => (lit.size && !symbols.some((s) => lit.has(s)) ? 0.25 : 1);
      const { first, last } = this.page;
      this.x = (frame) => LEFT + ((frame - first) / (last - first)) * (wide - LEFT - RIGHT);
      const y = (pane, v) => { // √m, as in the program: both τ and a half turn are visible
        const share = (v - pane.low) / (pane.high - pane.low);
        const up = pane.low === 0 ? Math.sqrt(Math.max(share, 0)) : share;
        return pane.bottom - up * (pane.bottom - pane.top);
      };
      panes.forEach((pane) => this._grid(context, pane, y, wide, look));
      this._title(context, state, look, panes);
      const tau = inDegrees(this.page.chain.tau), level = y(panes[1], tau);
      line(context, [[LEFT, level], [wide - RIGHT, level]], look.roles.tau, 1.2, [4, 3]);
      context.fillStyle = look.roles.tau;
      context.textAlign = "right";
      context.fillText(`τ ${plain(tau, 1)}°`, wide - RIGHT - 2, level - 3);
      const head = this.x(state.frame);
      line(context, [[head, TOP - 4], [head, high - BOTTOM]], look.roles.accent, 1.5);
      const drawn = [
        [panes[0], this.lines.p.y, this.lines.p.seams, "theta_p", [], ["theta_p", "twist"]],
        [panes[0], this.lines.c.y, this.lines.c.seams, "across", [6, 4], ["across", "dtheta_c"]],
        [panes[1], this.m, [], "m", [], ["m", "product"]],
      ];
      drawn.forEach(([pane, values, seams, symbol, dash, lights]) => {
        context.globalAlpha = faint(...lights);
        let points = [];
        values.forEach((value, k) => {
          points.push([this.x(this.frames[k]), y(pane, value)]);
          if (!seams.includes(k)) return;
          line(context, points, look.colourOf(symbol), 1.8, dash);
          points = [];
        });
        line(context, points, look.colourOf(symbol), 1.8, dash);
        context.globalAlpha = 1;
      });
      dots.forEach((dot) => {
        context.beginPath();
        context.arc(head, y(panes[dot.pane], dot.angle), 5, 0, 2 * Math.PI);
        context.fillStyle = look.colourOf(dot.symbol);
        context.strokeStyle = look.paper;
        context.lineWidth = 2;
        context.stroke();
        context.fill();
      });
    }

    _grid(context, pane, y, wide, look) {
      context.font = look.smallFont;
      context.textAlign = "right";
      context.textBaseline = "middle";
      let last = Infinity;
      ticksOf(pane).forEach((v) => {
        const level = y(pane, v);
        if (last - level < TICKS) return;
        last = level;
        line(context, [[LEFT, level], [wide - RIGHT, level]], look.roles.line, 1);
        context.fillStyle = look.roles.soft;
        context.fillText(`${plain(v, v % 1 ? 1 : 0)}°`, LEFT - 6, level);
      });
      context.textBaseline = "alphabetic";
      if (pane.low !== 0) return;
      const page = this.page, ticks = stepOf(page.last - page.first, (wide - LEFT) / 70);
      context.textAlign = "center";
      for (let f = Math.ceil(page.first / ticks) * ticks; f <= page.last; f += ticks) {
        context.fillStyle = look.roles.soft;
        context.fillText(String(f), this.x(f), pane.bottom + 13);
      }
    }

    _title(context, state, look, panes) {
      const k = state.frame - this.page.first;
      const at = (name, y) => inDegrees(this.page.chain[name][y - this.page.span.first]);
      context.font = look.smallFont;
      context.textAlign = "left";
      const words = [
        [["θp ━ ", "theta_p", signed(at("theta_p", state.frame), 1)],
          ["θc ╌ ", "across", signed(inDegrees(wrap(this.page.chain.theta_c[
            state.frame - this.page.span.first])), 1)]],
        [["m ", "m", plain(this.m[k], 1)]],
      ];
      words.forEach((texts, row) => {
        let x = LEFT;
        texts.forEach(([name, symbol, value]) => {
          context.fillStyle = look.colourOf(symbol);
          context.fillText(`${name}${value}°`, x, panes[row].top - 5);
          x += context.measureText(`${name}${value}°`).width + 16;
        });
      });
    }

    _scrub(event) {
      if (!this.page || !this.page.chain) return;
      const wide = this.canvas.clientWidth - LEFT - RIGHT, { first, last } = this.page;
      const share = (event.offsetX - LEFT) / wide;
      this.scrubbed(Math.round(first + Math.min(Math.max(share, 0), 1) * (last - first)));
    }
  }

  // An angle in degrees within half a turn of its usual value, and its seams: a full turn is no
  // movement and must not look like one.
  function about(angles) {
    const x = angles.reduce((sum, a) => sum + Math.cos(a), 0);
    const centre = Math.atan2(angles.reduce((sum, a) => sum + Math.sin(a), 0), x);
    const y = angles.map((a) => inDegrees(centre + wrap(a - centre)));
    const seams = [];
    for (let k = 0; k + 1 < y.length; k++) if (Math.abs(y[k + 1] - y[k]) > 180) seams.push(k);
    return { y, seams, centre };
  }

  // An angle, radians or null, in degrees within half a turn of a line's centre.
  const turnedTo = (angle, centre) =>
    (angle === null ? null : inDegrees(centre + wrap(angle - centre)));

  function rangeOf(values) {
    const low = Math.min(...values), high = Math.max(...values);
    const more = Math.max(0.08 * (high - low), 3);
    return [low - more, high + more];
  }

  function ticksOf(pane) { // from low to high
    if (pane.low === 0) return [0, 0.5, 1, 2, 5, 10, 20, 45, 90, 180].filter((v) => v <= pane.high);
    const step = stepOf(pane.high - pane.low, (pane.bottom - pane.top) / TICKS), out = [];
    for (let v = Math.ceil(pane.low / step) * step; v <= pane.high; v += step) out.push(v);
    return out;
  }

  function stepOf(range, count) { // 1, 2 or 5 times a power of ten
    const exact = range / Math.max(count, 1), power = 10 ** Math.floor(Math.log10(exact));
    return power * ([1, 2, 5].find((n) => n * power >= exact) || 10);
  }

  function line(context, points, colour, width, dash) {
    context.beginPath();
    points.forEach((p, k) => (k ? context.lineTo(p[0], p[1]) : context.moveTo(p[0], p[1])));
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.setLineDash(dash || []);
    context.stroke();
    context.setLineDash([]);
  }

  return { Plot: Plot };
})();
