// A camera that orbits a point and stays upright; azimuth 0 is the figure's front.
var OrbitCamera = (function () {
  "use strict";

  const { cross, dot, length, plus, minus, scaled, unit } = SwingTwist;
  const VIEW_ANGLE = (28 * Math.PI) / 180; // vertical field of view
  const STEEPEST = (89 * Math.PI) / 180;

  class Camera {
    constructor(up, ahead) {
      this.up = up;
      this.ahead = ahead;
      this.sideways = cross(up, ahead);
      this.target = [0, 0, 0];
      this.azimuth = this.elevation = 0;
      this.distance = 1;
    }

    get direction() { // from the target to the camera
      const level = plus(
        scaled(this.ahead, Math.cos(this.azimuth)), scaled(this.sideways, Math.sin(this.azimuth)));
      return plus(scaled(level, Math.cos(this.elevation)), scaled(this.up, Math.sin(this.elevation)));
    }

    get position() { return plus(this.target, scaled(this.direction, this.distance)); }

    get axes() { // right, up and backwards as seen
      const back = this.direction, right = unit(cross(this.up, back));
      return [right, cross(back, right), back];
    }

    orbit(azimuth, elevation) {
      this.azimuth += azimuth;
      this.elevation = Math.min(Math.max(this.elevation + elevation, -STEEPEST), STEEPEST);
    }

    zoom(factor) { this.distance /= factor; }

    pan(right, up, height) { // by pixels, in a view of this height
      const pixel = (2 * this.distance * Math.tan(VIEW_ANGLE / 2)) / height, axes = this.axes;
      this.target = minus(
        this.target, plus(scaled(axes[0], right * pixel), scaled(axes[1], up * pixel)));
    }

    lookFrom(direction) {
      this.azimuth = Math.atan2(dot(direction, this.sideways), dot(direction, this.ahead));
      this.elevation = Math.asin(Math.min(Math.max(dot(direction, this.up), -1), 1));
      this.orbit(0, 0);
    }

    frame(points, aspect, margin) { // so that all of them are just in view
      const axes = this.axes, low = [], high = [];
      axes.forEach((axis, k) => {
        const along = points.map((p) => dot(p, axis));
        low[k] = Math.min(...along);
        high[k] = Math.max(...along);
      });
      const size = Math.max(high[1] - low[1], (high[0] - low[0]) / Math.max(aspect, 0.1));
      const away = (margin * size) / (2 * Math.tan(VIEW_ANGLE / 2)) + (high[2] - low[2]) / 2;
      this.distance = Math.max(away, 1e-9);
      this.target = [0, 1, 2]
        .map((k) => scaled(axes[k], (low[k] + high[k]) / 2)).reduce((sum, v) => plus(sum, v));
    }

    projector(width, height) { // point → [x, y, depth], pixels from the top left corner
      const axes = this.axes, eye = this.position, least = 1e-6 * this.distance;
      const scale = height / (2 * Math.tan(VIEW_ANGLE / 2));
      return (point) => {
        const seen = minus(point, eye), depth = Math.max(-dot(seen, axes[2]), least);
        return [
          width / 2 + (scale * dot(seen, axes[0])) / depth,
          height / 2 - (scale * dot(seen, axes[1])) / depth,
          depth,
        ];
      };
    }
  }

  // The best of many directions: the swing is seen flat, the dial at an angle.
  function bestDirection(camera, along, normal, outward) {
    const way = length(outward) > 1e-9 ? unit(outward) : outward;
    let best = camera.ahead, most = -Infinity;
    for (let above = 0; above <= 45; above += 15) {
      for (let around = 0; around < 360; around += 10) {
        const rise = (above * Math.PI) / 180, turn = (around * Math.PI) / 180;
        const level = plus(
          scaled(camera.ahead, Math.cos(turn)), scaled(camera.sideways, Math.sin(turn)));
        const seen = plus(scaled(level, Math.cos(rise)), scaled(camera.up, Math.sin(rise)));
        const worth = Math.abs(dot(seen, normal)) + 1.4 * Math.min(Math.abs(dot(seen, along)), 0.5)
          + 0.35 * dot(seen, way) + 0.25 * dot(seen, camera.ahead);
        if (worth > most) {
          most = worth;
          best = seen;
        }
      }
    }
    return best;
  }

  return { Camera: Camera, VIEW_ANGLE: VIEW_ANGLE, bestDirection: bestDirection };
})();
