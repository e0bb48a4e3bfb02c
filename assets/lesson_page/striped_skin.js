// A striped skin along the limbs, the same as in inspector/viewport/striped_skin.py. Its roll changes
// evenly along a bone from the joint above to the joint below, so a wrong twist is visible in its stripes.
// A plain script like swing_twist.js.
var StripedSkin = (function () {
  "use strict";

  const S = SwingTwist;
  const { plus, minus, scaled, length } = S;
  const BEND = 0.2; // as a fraction of a bone: closer to a joint the skin bends with the next bone

  const towards = (from, to, share) => plus(from, scaled(minus(to, from), share));
  const rolled = (sides, angle) => [
    plus(scaled(sides[0], Math.cos(angle)), scaled(sides[1], Math.sin(angle))),
    minus(scaled(sides[1], Math.cos(angle)), scaled(sides[0], Math.sin(angle))),
  ];

  function boneOf(skin, pose, k) { // the position of a bone, and the roll of its skin at both ends
    const p = skin.parent[k], c = skin.child[k];
    const local = S.multiply(S.conjugate(pose.rotations[p]), pose.rotations[c]);
    const sides = skin.across[k].map((v) => S.rotate(pose.rotations[p], v));
    const angle = S.twistAngle(local, skin.axis[k]);
    const start = pose.positions[p], way = minus(pose.positions[c], start), far = length(way);
    return {
      sides, angle, start, stop: pose.positions[c], way, far,
      along: scaled(way, 1 / Math.max(far, 1e-12)), end: rolled(sides, angle),
    };
  }

  // Near a joint a ring belongs to both bones, at the joint itself in equal parts.
  function ringOf(skin, bones, k, at) {
    const own = bones[k];
    let centre = plus(own.start, scaled(own.way, at));
    let sides = rolled(own.sides, own.angle * at);
    const next = [
      { other: skin.below[k], ours: own.stop, reach: at - 1, theirs: (bone) => bone.sides },
      { other: skin.above[k], ours: own.start, reach: at, theirs: (bone) => bone.end },
    ];
    next.forEach(({ other, ours, reach, theirs }) => {
      if (other === k) return;
      const share = 0.5 * Math.max(1 - Math.abs(reach) / BEND, 0) ** 2;
      const beyond = plus(ours, scaled(bones[other].along, own.far * reach));
      centre = towards(centre, beyond, share);
      sides = sides.map((side, n) => towards(side, theirs(bones[other])[n], share));
    });
    return { centre, sides: sides.map((v) => scaled(v, 1 / Math.max(length(v), 1e-6))) };
  }

  // Fills points and normals, three numbers a vertex: bones, rings, vertices, in this order, then the
  // fins, which keep to their bones; grown: thickness as a multiple.
  function drape(skin, pose, points, normals, grown) {
    const bones = skin.axis.map((_, k) => boneOf(skin, pose, k));
    let i = 0;
    bones.forEach((_, k) => skin.stations.forEach((at, ring) => {
      const { centre, sides } = ringOf(skin, bones, k, at), radius = grown * skin.radius[k][ring];
      skin.circle.forEach(([cosine, sine]) => {
        for (let c = 0; c < 3; c++, i++) {
          normals[i] = cosine * sides[0][c] + sine * sides[1][c];
          points[i] = centre[c] + radius * normals[i];
        }
      });
    }));
    bones.forEach(({ start }, k) => skin.fin[k].forEach((corner, n) => {
      const turn = pose.rotations[skin.parent[k]];
      const at = S.rotate(turn, corner), normal = S.rotate(turn, skin.fin_normals[k][n]);
      for (let c = 0; c < 3; c++, i++) {
        normals[i] = normal[c];
        points[i] = start[c] + at[c];
      }
    }));
  }

  return { drape: drape };
})();
