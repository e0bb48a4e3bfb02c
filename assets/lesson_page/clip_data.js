// Unpacks the embedded clip data: little-endian arrays in base64.
var ClipData = (function () {
  "use strict";

  const { unit } = SwingTwist;
  const KINDS = { f4: Float32Array, u2: Uint16Array, i2: Int16Array, u1: Uint8Array, u4: Uint32Array };

  function unpacked(packed) { // { kind, data }
    const text = atob(packed.data), bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
    return new KINDS[packed.kind](bytes.buffer);
  }

  const part = (values, at, count) => Array.from(values.subarray(at * count, (at + 1) * count));

  class Span { // the frames of a clip around those of some pages
    constructor(data, figure) {
      this.figure = figure;
      this.first = data.first;
      this.fps = data.fps;
      this.moving = data.moving; // the joints that position channels move
      this.offsets = data.offsets;
      this.joints = figure.parents.length;
      this._rotations = unpacked(data.rotations);
      this._positions = unpacked(data.positions);
    }

    rotations(frame, after) { // local, one per joint; after: as corrected, if known
      const at = frame - this.first;
      const out = [];
      for (let j = 0; j < this.joints; j++) {
        out.push(unit(part(this._rotations, at * this.joints + j, 4)));
      }
      if (after) {
        after.joints.forEach((j, k) => {
          out[j] = unit(part(after.values, (frame - after.first) * after.joints.length + k, 4));
        });
      }
      return out;
    }

    translations(frame) { // from the parent, one per joint
      const out = this.offsets.slice(), count = this.moving.length;
      this.moving.forEach((j, k) => {
        out[j] = part(this._positions, (frame - this.first) * count + k, 3);
      });
      return out;
    }

    pose(frame, rotations) { // in world space
      return SwingTwist.forwardKinematics(
        this.figure.parents, rotations, this.translations(frame));
    }
  }

  class Chain { // one chain over the frames of a span
    constructor(data, span) {
      Object.assign(this, data);
      this.span = span;
      ["axes", "arms", "theta_p", "theta_c", "strength", "running"]
        .forEach((name) => { this[name] = unpacked(data[name]); });
    }

    at(frame) { // in the form that SwingTwist expects
      const k = frame - this.span.first;
      const { parent, child, children, free } = this;
      return { parent, child, children, free, axis: row(this.axes, k), arm: row(this.arms, k) };
    }
  }

  function row(vectors, k) { // for each frame, if they vary
    return unit(part(vectors, vectors.length > 3 ? k : 0, 3));
  }

  function read(lesson) {
    lesson.figures.forEach((figure) => {
      ["vertices", "joint", "bone", "part", "faces", "edges", "ground", "strength"]
        .forEach((name) => { figure[name] = unpacked(figure[name]); });
      if (!figure.skin) return; // not shown on any page
      ["bone", "part", "faces", "edges"]
        .forEach((name) => { figure.skin[name] = unpacked(figure.skin[name]); });
    });
    lesson.spans = lesson.spans.map((data) => new Span(data, lesson.figures[data.figure]));
    lesson.chains = lesson.chains.map((data) => new Chain(data, lesson.spans[data.span]));
    lesson.pages.forEach((page) => {
      page.span = lesson.spans[page.span];
      page.chain = page.chain === null ? null : lesson.chains[page.chain];
      if (page.after) page.after.values = unpacked(page.after.rotations);
    });
    return lesson;
  }

  return { read: read };
})();
