// Points and directions: the camera's eye, rays of the mouse, and places of the picture.

export const add = (a, b) => a.map((part, i) => part + b[i]);
export const subtract = (a, b) => a.map((part, i) => part - b[i]);
export const times = (a, by) => a.map((part) => part * by);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const unit = (a) => times(a, 1 / (length(a) || 1));

/** What the camera of the state sees, for a picture whose width is `aspect` times its height. */
export class Eye {
  constructor({ position, target, sky, fov }, aspect) {
    this.position = position;
    this.forward = unit(subtract(target, position));
    this.right = unit(cross(this.forward, sky));
    this.up = cross(this.right, this.forward);
    this.fov = fov;
    this.aspect = aspect;
  }

  /** Where a point is in the picture, both numbers from 0 to 1, to the right and down; null if it is behind. */
  project(point) {
    const way = subtract(point, this.position);
    const depth = dot(way, this.forward);
    if (depth <= 1e-9) return null;
    const [x, y] = [dot(way, this.right) / (depth * this.fov * this.aspect), dot(way, this.up) / (depth * this.fov)];
    return [(x + 1) / 2, (1 - y) / 2];
  }

  /** Distance of a point along the view. */
  depth(point) {
    return dot(subtract(point, this.position), this.forward);
  }

  /** The unit direction of the ray through a place of the picture. */
  ray([u, v]) {
    const [x, y] = [(2 * u - 1) * this.fov * this.aspect, (1 - 2 * v) * this.fov];
    return unit(add(this.forward, add(times(this.right, x), times(this.up, y))));
  }

  /** How far along an axis through a point, from the point, the axis is nearest to a ray. */
  along(axis, point, ray) {
    const way = subtract(point, this.position);
    const cosine = dot(axis, ray);
    const rest = 1 - cosine * cosine;
    return rest < 1e-6 ? null : (cosine * dot(way, ray) - dot(way, axis)) / rest;
  }

  /** Where a ray meets the plane through a point; null if it does not. */
  meets(normal, point, ray) {
    const against = dot(normal, ray);
    if (Math.abs(against) < 1e-3) return null;
    const far = dot(subtract(point, this.position), normal) / against;
    return far > 0 ? add(this.position, times(ray, far)) : null;
  }
}

/** A round number near another: 1, 2 or 5 times a power of ten, and not larger. */
export function round(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  const first = size / power;
  return power * (first >= 5 ? 5 : first >= 2 ? 2 : 1);
}

/** A multiple of a step, without digits that rounding adds. */
export function stepped(value, step) {
  return Number((Math.round(value / step) * step).toPrecision(12));
}
