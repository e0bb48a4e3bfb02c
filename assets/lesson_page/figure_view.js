// Draws the figure: flat bones with a stripe, and in a what-if the captured pose as a ghost.
// Without WebGL, bones are lines in the upper canvas, which also has the gizmo.
var FigureView = (function () {
  "use strict";

  const { rotate, plus, dot, minus, scaled } = SwingTwist;
  const FAINT = 0.62; // share of the background's colour in bones that the page is not about
  const GROWN = 1.09; // the ghost is slightly larger than a solid body of the same pose
  const PLAIN = 0, CHOSEN = 1, AFTER = 3; // roles, as in bone_colours.Role
  const JOINT = 4; // the spheres at joints

  const mixed = (colour, other, share) => colour.map((c, k) => (1 - share) * c + share * other[k]);
  const fromHex = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));

  function makeRenderer(canvas) { // null without WebGL
    const options = { antialias: true, alpha: false, powerPreference: "low-power" };
    const context = canvas.getContext("webgl2", options) || canvas.getContext("webgl", options);
    if (!context) return null;
    try {
      return new THREE.WebGLRenderer({ canvas, context, antialias: true });
    } catch (error) {
      return null;
    }
  }

  // The parts of bodies: { bone, part } of every vertex, faces, edges, and place(pose, points,
  // normals), which fills three numbers a vertex.
  function wedgesOf(figure, covered, grown) { // flat bones, unless a skin covers them
    const { joint, bone, part, edges } = figure, vertices = thicker(figure, grown);
    const kept = (cells, corners) => {
      const out = [];
      for (let k = 0; k < cells.length; k += corners) {
        if (!covered.has(bone[cells[k]])) out.push(...cells.subarray(k, k + corners));
      }
      return out;
    };
    const place = (pose, points) => {
      const matrices = pose.rotations.map(columns);
      for (let k = 0; k < joint.length; k++) {
        const m = matrices[joint[k]], at = pose.positions[joint[k]], i = 3 * k;
        const x = vertices[i], y = vertices[i + 1], z = vertices[i + 2];
        points[i] = m[0] * x + m[3] * y + m[6] * z + at[0];
        points[i + 1] = m[1] * x + m[4] * y + m[7] * z + at[1];
        points[i + 2] = m[2] * x + m[5] * y + m[8] * z + at[2];
      }
    };
    return { bone, part, faces: kept(figure.faces, 3), edges: kept(edges, 2), place };
  }

  function thicker(figure, grown) { // vertices are this many times as far from the bone
    const { vertices, bone, bones } = figure, out = Float32Array.from(vertices);
    for (let k = 0; grown !== 1 && k < bone.length; k++) {
      if (bone[k] < 0) continue;
      const tip = bones[bone[k]].tip, v = [0, 1, 2].map((c) => vertices[3 * k + c]);
      const along = scaled(tip, dot(v, tip) / dot(tip, tip));
      out.set(plus(along, scaled(minus(v, along), grown)), 3 * k);
    }
    return out;
  }

  function skinOf(figure, grown) {
    const { skin } = figure;
    const place = (pose, points, normals) =>
      StripedSkin.drape(skin, pose, points, normals, grown);
    return {
      bone: skin.bone, part: skin.part, faces: Array.from(skin.faces), edges: Array.from(skin.edges),
      place, smooth: true,
    };
  }

  class Body { // a figure's faces, moved with its joints; ghost: a thin shell with an outline
    constructor(shape, ghost, colour) {
      this.shape = shape;
      this.ghost = ghost;
      const count = shape.bone.length;
      this.points = new Float32Array(3 * count);
      this.normals = new Float32Array(3 * count);
      this.colours = new Float32Array((ghost ? 4 : 3) * count);
      this.geometry = new THREE.BufferGeometry();
      this.geometry.setAttribute("position", new THREE.BufferAttribute(this.points, 3));
      this.geometry.setAttribute("normal", new THREE.BufferAttribute(this.normals, 3));
      this.geometry.setAttribute("color", new THREE.BufferAttribute(this.colours, ghost ? 4 : 3));
      this.geometry.setIndex(shape.faces);
      const material = ghost
        ? new THREE.MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false })
        : new THREE.MeshPhongMaterial({
          vertexColors: true, flatShading: !shape.smooth, specular: 0, side: THREE.DoubleSide });
      this.meshes = [new THREE.Mesh(this.geometry, material)];
      if (ghost) this.meshes.push(this._outline(colour));
      this.meshes.forEach((mesh) => { mesh.frustumCulled = false; });
    }

    _outline(colour) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", this.geometry.attributes.position);
      geometry.setIndex(this.shape.edges);
      return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour }));
    }

    place(pose, shown) { // shown: bone → true if visible; a hidden bone is drawn as one point
      const { bone } = this.shape, points = this.points;
      this.shape.place(pose, points, this.normals);
      for (let k = 0; shown && k < bone.length; k++) {
        if (bone[k] < 0 || !shown[bone[k]]) points.fill(0, 3 * k, 3 * k + 3);
      }
      this.geometry.attributes.position.needsUpdate = true;
      this.geometry.attributes.normal.needsUpdate = true;
    }

    show(on) { this.meshes.forEach((mesh) => { mesh.visible = on; }); }

    paint(colourOf) { // colourOf(bone, part) → numbers 0…255
      const { bone, part } = this.shape, channels = this.ghost ? 4 : 3;
      for (let k = 0; k < bone.length; k++) {
        const colour = colourOf(bone[k], part[k]);
        for (let c = 0; c < channels; c++) this.colours[channels * k + c] = colour[c] / 255;
      }
      this.geometry.attributes.color.needsUpdate = true;
    }
  }

  function columns(q) { // columns of the rotation matrix, one after the other
    return [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => rotate(q, axis)).flat();
  }

  class View {
    constructor(element, lesson) {
      this.lesson = lesson;
      this.figureCanvas = element.querySelector(".figure");
      this.signs = element.querySelector(".signs");
      this.renderer = makeRenderer(this.figureCanvas);
      this.room = null;
    }

    get size() { return [this.signs.clientWidth, this.signs.clientHeight]; }

    resize() {
      const [width, height] = this.size, ratio = Math.min(window.devicePixelRatio || 1, 2);
      this.signs.width = Math.round(width * ratio);
      this.signs.height = Math.round(height * ratio);
      if (!this.renderer) return;
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
    }

    enter(figure, theme, skin) { // another clip, other bodies or colours
      this.colours = this.lesson.themes[theme];
      this.figure = figure;
      if (!this.renderer) return;
      if (this.room) this.room.traverse((x) => { if (x.geometry) x.geometry.dispose(); });
      const { roles } = this.colours;
      this.surface = fromHex(roles.surface);
      this.room = new THREE.Scene();
      this.room.background = new THREE.Color(roles.surface);
      this.light = new THREE.DirectionalLight(0xffffff, 0.55);
      this.room.add(
        new THREE.AmbientLight(0xffffff, 0.55), this.light, groundOf(figure, this.colours));
      const covered = new Set(skin ? figure.skin.bone : []);
      const shapes = (grown) =>
        [wedgesOf(figure, covered, grown), ...(skin ? [skinOf(figure, grown)] : [])];
      this.solids = shapes(1).map((shape) => new Body(shape, false));
      this.ghosts = shapes(GROWN).map((shape) => new Body(shape, true, roles.before));
      this.shadows = this.solids.map((body) => shadowOf(body, this.colours));
      const before = fromHex(roles.before);
      this.ghosts.forEach((body) => body.paint((_, part) => [...before, this.lesson.ghost[part]]));
      [...this.solids, ...this.ghosts].forEach((body) => this.room.add(...body.meshes));
      this.room.add(...this.shadows);
      this.lens = new THREE.PerspectiveCamera(1, 1, 1, 10);
    }

    // look: { solid, ghost } poses; strong: bone → the page is about it; differs: bone →
    // coloured by role, as "after" by default; left: bone → leaves a ghost. drawSigns(context, project):
    // draws symbols on top of the figure.
    draw(camera, look, drawSigns) {
      const [width, height] = this.size;
      const context = this.signs.getContext("2d"), ratio = this.signs.width / Math.max(width, 1);
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      const project = camera.projector(width, height);
      if (this.renderer) this._render(camera, look);
      else this._drawLines(context, project, look);
      drawSigns(context, project);
    }

    _render(camera, { solid, ghost, strong, differs, left, role = AFTER }) {
      const palette = this.colours.palette;
      this.solids.forEach((body) => {
        body.place(solid, null);
        body.paint((bone, part) => {
          if (bone >= 0 && differs[bone]) return palette[role][part];
          return bone >= 0 && strong[bone]
            ? palette[CHOSEN][part] : mixed(palette[PLAIN][part], this.surface, FAINT);
        });
      });
      const leaves = left.some((x) => x);
      this.ghosts.forEach((body) => {
        body.show(leaves);
        if (leaves) body.place(ghost, left);
      });
      this._castShadow();
      const [width, height] = this.size, lens = this.lens;
      lens.fov = (180 / Math.PI) * OrbitCamera.VIEW_ANGLE;
      lens.aspect = width / height;
      lens.near = 0.02 * camera.distance;
      lens.far = 50 * camera.distance;
      lens.up.set(...camera.up);
      lens.position.set(...camera.position);
      lens.lookAt(...camera.target);
      lens.updateProjectionMatrix();
      const axes = camera.axes; // from over the left shoulder
      this.light.position.set(...plus(camera.position,
        scaled(plus(axes[1], scaled(axes[0], -0.6)), 0.5 * camera.distance)));
      this.light.target.position.set(...camera.target);
      this.light.target.updateMatrixWorld();
      this.renderer.render(this.room, lens);
    }

    _castShadow() {
      const { up, level, radius } = this.figure.room, least = level + 2e-4 * radius;
      this.shadows.forEach((shadow, n) => {
        const from = this.solids[n].points, points = shadow.geometry.attributes.position.array;
        for (let k = 0; k < from.length; k += 3) {
          const above = from[k] * up[0] + from[k + 1] * up[1] + from[k + 2] * up[2] - least;
          for (let c = 0; c < 3; c++) points[k + c] = from[k + c] - above * up[c];
        }
        shadow.geometry.attributes.position.needsUpdate = true;
      });
    }

    _drawLines(context, project, { solid, ghost, strong, differs, left, role = AFTER }) {
      const roles = this.colours.roles, changed = role === AFTER ? roles.after : roles.before;
      const tip = (pose, bone) => plus(
        pose.positions[bone.parent], rotate(pose.rotations[bone.parent], bone.tip));
      const stroke = (pose, bone, colour, width) => {
        const a = project(pose.positions[bone.parent]), b = project(tip(pose, bone));
        context.beginPath();
        context.moveTo(a[0], a[1]);
        context.lineTo(b[0], b[1]);
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.lineCap = "round";
        context.stroke();
      };
      this.figure.bones.forEach((bone, k) => {
        if (left[k]) stroke(ghost, bone, roles.before, 3);
        const colour = differs[k] ? changed : strong[k] ? roles.accent : roles.bone;
        stroke(solid, bone, colour, strong[k] ? 6 : 3);
      });
    }
  }

  function groundOf(figure, colours) { // lines that fade into the background at the rim
    const surface = fromHex(colours.roles.surface), line = fromHex(colours.roles.line);
    const geometry = new THREE.BufferGeometry();
    const painted = Array.from(figure.strength).map((s) => mixed(surface, line, 0.85 * s)).flat();
    geometry.setAttribute("position", new THREE.BufferAttribute(figure.ground, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(painted.map((c) => c / 255), 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true }));
  }

  function shadowOf(body, colours) {
    const window = fromHex(colours.roles.window);
    const dark = mixed(window, [0, 0, 0], colours.dark ? 0.38 : 0.13).map(Math.round);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute(
      "position", new THREE.BufferAttribute(new Float32Array(body.points.length), 3));
    const { faces, part } = body.shape, kept = [];
    for (let k = 0; k < faces.length; k += 3) {
      if (part[faces[k]] !== JOINT) kept.push(faces[k], faces[k + 1], faces[k + 2]);
    }
    geometry.setIndex(kept);
    const material = new THREE.MeshBasicMaterial(
      { color: `rgb(${dark.join(",")})`, side: THREE.DoubleSide });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    return mesh;
  }

  // Returns the bones that differ between two poses.
  function differing(figure, solid, ghost) {
    const angle = (p, q) => {
      const d = Math.abs(dot(p, q));
      return 2 * Math.acos(Math.min(d, 1));
    };
    return figure.bones.map((bone) => {
      const apart = minus(solid.positions[bone.parent], ghost.positions[bone.parent]);
      return angle(solid.rotations[bone.parent], ghost.rotations[bone.parent]) > 0.001
        || SwingTwist.length(apart) > 1e-4 * figure.room.height;
    });
  }

  return { View: View, differing: differing };
})();
