// Draws the symbols of a frame in 3D, on top of the figure, so that no limb hides them.
var Gizmo = (function () {
  "use strict";

  const S = SwingTwist;
  const { cross, length, plus, minus, scaled, rotate } = S;
  const ARC = 32; // steps of an arc
  const SEEN = Math.PI / 180; // smaller differences are not drawn
  const BOLD = 3, THIN = 1.6; // pixels
  const DIMMED = 0.22; // opacity of symbols that are not highlighted
  const HEAD = [0.105, 0.034]; // length and radius of an arrowhead, in bone lengths
  const GAP = 15; // pixels from a symbol to the middle of its label
  const MEMBERS = 8; // of the dials at a swing of 180°
  const OUT = 0.62, DIAL = 0.13; // the dials' distance from P and radius, as a fraction of the bone
  const AXES = ["#e14840", "#4aa854", "#4076eb"], AXIS = 0.16; // x, y, z; in bone lengths

  // -- shapes: lists of { symbol, kind, points, … } and of labels, in the world -----------------

  const turned = (v, axis, angle) =>
    plus(scaled(v, Math.cos(angle)), scaled(cross(axis, v), Math.sin(angle)));

  function fan(start, axis, angle) { // unit vectors on the path of `start` about an axis
    return Array.from({ length: ARC + 1 }, (_, k) => turned(start, axis, (angle * k) / ARC));
  }

  class Sketch {
    constructor(size) {
      this.size = size; // the length of the bone
      this.parts = [];
      this.marks = [];
    }

    line(symbol, points, width, share, dashed) {
      this.parts.push({
        symbol, kind: "line", points, width: width || BOLD, share: share || 1, dashed: !!dashed });
    }

    face(symbol, points, share) { this.parts.push({ symbol, kind: "face", points, share }); }

    ball(symbol, centre, radius, hollow) {
      this.parts.push({ symbol, kind: "ball", points: [centre], radius, hollow: !!hollow });
    }

    arrow(symbol, start, way) { // an arrow that is too short gets a smaller head
      const far = length(way);
      if (far < 1e-9) return;
      const head = Math.min(HEAD[0] * this.size, 0.6 * far);
      const end = plus(start, way), neck = minus(end, scaled(way, head / far));
      this.line(symbol, [start, neck]);
      this.parts.push({
        symbol, kind: "head", points: [neck, end], radius: (head * HEAD[1]) / HEAD[0] });
    }

    sector(symbol, centre, rim, share, inner) {
      const low = rim.map((p) => plus(centre, scaled(minus(p, centre), inner || 0)));
      this.face(symbol, rim.concat(low.reverse()), share);
    }

    mark(symbol, at, away, shown) {
      if (shown !== false) this.marks.push({ symbol, at, away });
    }
  }

  // d: the frame's quantities; parent: P's global rotation; at, child: places of P and C; reach:
  // the length that v is drawn with; least: the shortest length a bone is drawn as; staged: P's
  // rotation is animated, so changes since the previous frame are not shown.
  function sketch(d, parent, at, child, reach, least, staged) {
    const out = new Sketch(Math.max(length(minus(child, at)), least));
    const along = rotate(parent, d.a);
    drawFamily(out, d, parent, at);
    d = defined(d, staged);
    drawSwing(out, d, parent, along, at);
    drawTwist(out, d, parent, along, at);
    drawAzimuth(out, d, parent, along, child, Math.max(reach, 0.5 * out.size));
    return out;
  }

  function defined(d, staged) { // an undefined angle has no dial and no label
    const out = Object.assign({}, d);
    if (!d.swing_is_one) out.theta_p = 0;
    if (staged || !d.dtheta_p_is_defined) {
      Object.assign(out, { theta_p_before: out.theta_p, dtheta_p: 0 });
    }
    if (staged || !d.dtheta_c_is_defined) {
      Object.assign(out, { across_before: d.across, v_ideal: d.v, dtheta_c: 0 });
    }
    return out;
  }

  // Near a swing of 180° a fan of normals around P, at the end of each a dial: one pose, many
  // (n, θp). A normal turned by φ about a has a θp larger by 2φ; all hands point the same way.
  function drawFamily(out, d, parent, at) {
    if (d.swing_reliability >= Labels.NEAR_SWING) return;
    const above = S.multiply(parent, S.conjugate(d.q)), mark = S.perpendicular(d.a);
    const axis = rotate(above, scaled(d.a, -1)), first = length(d.n) > 0 ? d.n : mark;
    for (let k = 0; k < MEMBERS; k++) {
      const turn = (2 * Math.PI * k) / MEMBERS, n = turned(first, d.a, turn);
      const angle = S.wrap(d.theta_p + 2 * turn), way = rotate(above, n);
      const zero = rotate(above, minus(scaled(n, 2 * S.dot(n, mark)), mark));
      const far = (by) => plus(at, scaled(way, by * out.size)), centre = far(OUT);
      const rim = (v, by) => plus(centre, scaled(v, by * DIAL * out.size));
      const swept = fan(zero, axis, angle);
      out.sector("theta_p", centre, swept.map((v) => rim(v, 1)), 0.5);
      out.line("n", [at, far(OUT - DIAL)], THIN, 0.8);
      out.line("theta_p", fan(zero, axis, 2 * Math.PI).map((v) => rim(v, 1)), THIN, 0.7);
      out.line("theta_p", [centre, rim(swept[ARC], 1.25)]);
      const words = `${Labels.signed(Labels.inDegrees(angle), 0)}°`;
      out.marks.push({ symbol: "theta_p", at: far(OUT + DIAL), away: at, words });
    }
  }

  function drawSwing(out, d, parent, along, at) {
    const above = S.multiply(parent, S.conjugate(d.q)); // the coordinates of P's rotation
    const bone = rotate(above, d.a), normal = rotate(above, d.n), size = out.size;
    const arc = fan(bone, normal, d.alpha).map((v) => plus(at, scaled(v, 0.46 * size)));
    out.sector("alpha", at, arc, 0.24);
    out.line("alpha", arc);
    const middle = plus(at, scaled(minus(arc[ARC / 2], at), 1.12));
    out.mark("alpha", middle, at, d.alpha > 4 * SEEN);
    const tip = (v, by) => plus(at, scaled(v, by * size));
    out.arrow("a", at, scaled(bone, 0.92 * size));
    out.mark("a", tip(bone, 0.92), at);
    out.arrow("w", at, scaled(along, 0.92 * size));
    out.mark("w", tip(along, 0.8), tip(bone, 0.8));
    if (d.n_is_defined) out.arrow("n", at, scaled(normal, 0.5 * size)); // an undefined normal is not drawn
    out.mark("n", tip(normal, 0.5), at, d.n_is_defined);
  }

  function drawTwist(out, d, parent, along, at) {
    // The dial: its zero is the mark after the swing alone, its hand is the actual mark.
    const centre = plus(at, scaled(along, 0.6 * out.size)), radius = 0.25 * out.size;
    const hand = rotate(parent, S.perpendicular(d.a)), zero = turned(hand, along, -d.theta_p);
    const before = turned(zero, along, d.theta_p_before);
    const rim = (vectors, by) => vectors.map((v) => plus(centre, scaled(v, by * radius)));
    out.sector("theta_p", centre, rim(fan(zero, along, d.theta_p), 1), 0.4);
    out.line("theta_p", rim(fan(zero, along, 2 * Math.PI), 1), THIN, 0.75);
    out.line("theta_p", [centre, rim([zero], 1.12)[0]], THIN, 0.75);
    out.line("theta_p", [centre, rim([hand], 1.12)[0]]);
    const changed = rim(fan(before, along, d.dtheta_p), 1.22);
    out.sector("dtheta_p", centre, changed, 0.55, 0.84);
    out.line("dtheta_p", changed);
    const middle = rim([turned(zero, along, d.theta_p / 2)], 0.9)[0];
    out.mark("theta_p", middle, centre, Math.abs(d.theta_p) > SEEN);
    out.mark("dtheta_p", changed[ARC / 2], centre, Math.abs(d.dtheta_p) > SEEN);
  }

  function drawAzimuth(out, d, parent, along, child, reach) {
    const at = (v, by) => plus(child, scaled(v, by));
    const v = rotate(parent, d.v), flat = rotate(parent, d.across);
    const flatBefore = rotate(parent, d.across_before), ideal = rotate(parent, d.v_ideal);
    const apart = Math.abs(d.dtheta_c) > 2 * SEEN && d.azimuth_reliability > 0.01;
    const far = length(flatBefore), start = far > 0 ? scaled(flatBefore, 1 / far) : flatBefore;
    const radius = Math.min(0.62 * reach * Math.max(far, 0.12), 0.3 * out.size);
    const rim = fan(start, along, d.dtheta_c).map((u) => at(u, radius));
    out.sector("dtheta_c", child, rim, 0.5);
    out.line("dtheta_c", rim);
    out.mark("dtheta_c", rim[ARC / 2], child, Math.abs(d.dtheta_c) > SEEN);
    out.line("across", fan(start, along, 2 * Math.PI).map((u) => at(u, radius)), THIN, 0.6);
    out.line("dtheta_c", [child, at(flatBefore, reach)], THIN, 0.9, true);
    out.arrow("v", child, scaled(v, reach));
    out.mark("v", at(v, 0.55 * reach), at(flat, reach));
    out.arrow("across", child, scaled(flat, reach));
    out.line("across", [at(v, reach), at(flat, reach)], THIN, 0.8, true);
    out.mark("across", at(flat, reach), child, d.azimuth_reliability > 0.05);
    out.ball("v", at(v, reach), 0.03 * out.size);
    if (!apart) return;
    out.ball("ideal", at(ideal, reach), 0.04 * out.size, true);
    out.line("ideal", [child, at(ideal, reach)], THIN, 1, true);
    out.mark("real", at(v, reach), child);
    out.mark("ideal", at(ideal, reach), child);
  }

  // The coordinate axes of P, C and G, in the usual colours of x, y and z.
  function drawTriads(out, { parent, child, grandchild }, pose) {
    [parent, child, grandchild].filter((joint) => joint >= 0).forEach((joint) => {
      const at = pose.positions[joint], size = AXIS * out.size;
      AXES.forEach((colour, k) => {
        const axis = rotate(pose.rotations[joint], [0, 1, 2].map((i) => (i === k ? size : 0)));
        out.parts.push({ symbol: "", kind: "line", points: [at, plus(at, axis)], width: 2, colour });
      });
    });
  }

  // A name at every joint; if the real G is visible, it replaces G.
  function nameJoints(out, { parent, child, grandchild }, positions) {
    const [p, c, g] = [positions[parent], positions[child], positions[grandchild]];
    out.mark("P", p, c);
    out.mark("C", c, g ? scaled(plus(p, g), 0.5) : p);
    if (g) out.mark("G", g, c, !out.marks.some((mark) => mark.symbol === "real"));
  }

  // Of a limb P, C, E: the line from P to E, and the circle on which a flip moves C about it.
  function limbSketch(solid, ghost, { parent, child, end }, size) {
    const out = new Sketch(size), at = solid.positions, way = minus(at[end], at[parent]);
    if (length(way) < 1e-6 * size) return out; // a folded limb has no line
    const line = S.unit(way), arm = minus(at[child], at[parent]);
    const foot = plus(at[parent], scaled(line, S.dot(arm, line)));
    const round = fan(minus(at[child], foot), line, 2 * Math.PI).map((v) => plus(foot, v));
    out.line("a", [at[parent], at[end]], THIN, 0.9, true);
    out.line("a", round, THIN, 0.55);
    out.ball("a", ghost.positions[child], 0.014 * size, true);
    out.ball("a", at[child], 0.014 * size);
    return out;
  }

  // -- drawing into a canvas --------------------------------------------------------------------

  // project: point → [x, y, depth]; lit: the highlighted symbols, none: all; colourOf: symbol →
  // colour; formulas: symbol → { path, box }, 100 units an em; paper: the colour behind.
  function draw(context, shapes, project, look) {
    const strength = (symbol) => (look.lit.size && !look.lit.has(symbol) ? DIMMED : 1);
    const parts = shapes.parts.map((part) => {
      const seen = part.points.map(project);
      const depth = seen.reduce((sum, p) => sum + p[2], 0) / seen.length;
      return { part, seen, depth: part.kind === "face" ? depth + 1e3 * shapes.size : depth };
    });
    parts.sort((x, y) => y.depth - x.depth); // transparent faces first, then from far to near
    context.save();
    context.lineJoin = context.lineCap = "round";
    parts.forEach(({ part, seen }) => {
      context.fillStyle = context.strokeStyle = part.colour || look.colourOf(part.symbol);
      context.globalAlpha = (part.share || 1) * (part.colour ? 1 : strength(part.symbol));
      DRAWN[part.kind](context, part, seen, project);
    });
    context.restore();
    drawMarks(context, shapes.marks, project, look, strength);
  }

  function outline(context, seen) {
    context.beginPath();
    seen.forEach((p, k) => (k ? context.lineTo(p[0], p[1]) : context.moveTo(p[0], p[1])));
  }

  function pixels(radius, seen, project, part) { // the scale at the depth of a part
    const at = part.points[part.points.length - 1], end = seen[seen.length - 1];
    const sides = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => {
      const p = project(plus(at, scaled(axis, radius)));
      return Math.hypot(p[0] - end[0], p[1] - end[1]);
    });
    return Math.max(...sides);
  }

  const DRAWN = {
    line(context, part, seen) {
      outline(context, seen);
      context.lineWidth = part.width;
      context.setLineDash(part.dashed ? [5, 5] : []);
      context.stroke();
      context.setLineDash([]);
    },
    face(context, part, seen) {
      outline(context, seen);
      context.fill();
    },
    head(context, part, seen, project) {
      const [neck, end] = seen, wide = pixels(part.radius, seen, project, part);
      const far = Math.hypot(end[0] - neck[0], end[1] - neck[1]);
      if (far < 0.5 * wide) { // it points at the viewer or away: a disc
        context.beginPath();
        context.arc(end[0], end[1], wide, 0, 2 * Math.PI);
        context.fill();
        return;
      }
      const x = (-(end[1] - neck[1]) / far) * wide, y = ((end[0] - neck[0]) / far) * wide;
      outline(context, [end, [neck[0] + x, neck[1] + y], [neck[0] - x, neck[1] - y]]);
      context.fill();
    },
    ball(context, part, seen, project) {
      context.beginPath();
      context.arc(seen[0][0], seen[0][1], pixels(part.radius, seen, project, part), 0, 2 * Math.PI);
      context.lineWidth = 2;
      if (part.hollow) context.stroke();
      else context.fill();
    },
  };

  function drawMarks(context, marks, project, look, strength) {
    const small = 0.8 * look.fontSize, placed = [];
    context.font = `${small}px system-ui, sans-serif`;
    marks.forEach((mark) => {
      const formula = look.formulas[mark.symbol];
      if (!formula) return;
      const scale = mark.words ? 1 : (1.25 * look.fontSize) / 100; // units: pixels, or of an em
      const at = project(mark.at), from = project(mark.away);
      const x = at[0] - from[0], y = at[1] - from[1], far = Math.hypot(x, y) || 1;
      const [left, top, wide, high] = mark.words
        ? [0, -small, context.measureText(mark.words).width, small]
        : formula.box.map((n) => n * scale);
      const box = { x: at[0] + (GAP * x) / far - wide / 2, y: at[1] + (GAP * y) / far - high / 2 };
      Object.assign(box, { wide, high });
      makeRoom(box, placed);
      placed.push(box);
      context.save();
      context.globalAlpha = strength(mark.symbol) < 1 ? 0.35 : 1;
      context.translate(box.x - left, box.y - top);
      context.scale(scale, scale);
      context.lineJoin = "round";
      context.lineWidth = 5 / scale;
      context.strokeStyle = look.paper;
      context.fillStyle = look.colourOf(mark.symbol);
      if (mark.words) {
        context.strokeText(mark.words, 0, 0);
        context.fillText(mark.words, 0, 0);
      } else {
        context.stroke(formula.path);
        context.fill(formula.path);
      }
      context.restore();
    });
  }

  function makeRoom(box, placed) { // up or down, past existing labels
    const apart = 4;
    placed.forEach((other) => {
      const aside = box.x > other.x + other.wide + apart || other.x > box.x + box.wide + apart;
      const over = box.y > other.y + other.high + apart || other.y > box.y + box.high + apart;
      if (aside || over) return;
      const down = box.y + box.high / 2 > other.y + other.high / 2;
      box.y = down ? other.y + other.high + apart : other.y - box.high - apart;
    });
  }

  return { sketch, nameJoints, drawTriads, limbSketch, draw };
})();
