// SPDX-License-Identifier: Apache-2.0
// The things of the 3D view. Each is drawn up to a frame (`upTo`), so that a run can be played back: what it draws is
// sorted by frame, and moving in time changes nothing but how much of it is drawn.
import * as THREE from 'three';

// How many of the rising numbers are at most `limit`.
export function countUpTo(sorted, limit) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = low + high >> 1;
    if (sorted[middle] <= limit) low = middle + 1; else high = middle;
  }
  return low;
}

export class PointLayer {
  constructor() {
    this.material = new THREE.PointsMaterial({size: 2, sizeAttenuation: false, vertexColors: true});
    this.object = new THREE.Points(new THREE.BufferGeometry(), this.material);
    this.object.frustumCulled = false;
    this.step = 1;
    this.set([], () => [0, 0, 0]);
  }
  // points: rows; colourOf: three numbers from 0 to 255 for a row.
  set(points, colourOf) {
    this.rows = [...points].sort((a, b) => a.frame - b.frame);
    this.frames = this.rows.map(p => p.frame);
    this.positions = new Float32Array(3 * this.rows.length);
    this.rows.forEach((p, k) => this.positions.set(p.t, 3 * k));
    const geometry = this.object.geometry;
    geometry.dispose();
    geometry.setAttribute('position', new THREE.BufferAttribute(this.positions, 3));
    this.setColours(colourOf);
    this.thin(this.step);
  }
  // Draws every step-th point only.
  thin(step) {
    this.step = step;
    const count = step === 1 ? 0 : Math.ceil(this.rows.length / step);
    this.object.geometry.setIndex(count ? new THREE.BufferAttribute(Uint32Array.from({length: count}, (_, k) => k * step), 1) : null);
    this.upTo(this.limit ?? Infinity);
  }
  setColours(colourOf) {
    const colour = new Uint8Array(3 * this.rows.length);
    this.rows.forEach((p, k) => colour.set(colourOf(p), 3 * k));
    this.object.geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3, true));
  }
  upTo(frame) {
    this.limit = frame;
    this.drawn = countUpTo(this.frames, frame);
    this.object.geometry.setDrawRange(0, Math.ceil(this.drawn / this.step));
  }
}

// Thin lines, each of two positions with one colour.
export class ThinLines {
  constructor(opacity = 1) {
    const material = new THREE.LineBasicMaterial({vertexColors: true, transparent: opacity < 1, opacity, depthWrite: opacity === 1});
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.frames = [];
    this.perItem = 2;
  }
  // items: {frame, lines: positions of segments' ends, one after the other, colour}, sorted by frame; all equally long.
  set(items) {
    const ends = items.length ? items[0].lines.length / 3 : 2;
    const positions = new Float32Array(3 * ends * items.length), colour = new Uint8Array(3 * ends * items.length);
    items.forEach((item, k) => {
      positions.set(item.lines, 3 * ends * k);
      for (let e = 0; e < ends; ++e) colour.set(item.colour, 3 * (ends * k + e));
    });
    this.frames = items.map(item => item.frame);
    this.perItem = ends;
    const geometry = this.object.geometry;
    geometry.dispose();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3, true));
  }
  upTo(frame) { this.object.geometry.setDrawRange(0, this.perItem * countUpTo(this.frames, frame)); }
}

// Each segment is a rectangle that the vertex shader turns to the viewer: `side` says to which side of the line from its
// own end to the other a corner lies. A part behind the camera is cut off.
const WIDE_VERTEX = `
  attribute vec3 other; attribute float side; attribute vec3 color;
  uniform vec2 resolution; uniform float width; varying vec3 vColour;
  void main() {
    vec4 a = projectionMatrix * modelViewMatrix * vec4(position, 1.0), b = projectionMatrix * modelViewMatrix * vec4(other, 1.0);
    const float nearest = 1e-4;
    if (a.w < nearest && b.w > nearest) a = mix(a, b, (nearest - a.w) / (b.w - a.w));
    else if (b.w < nearest && a.w > nearest) b = mix(b, a, (nearest - b.w) / (a.w - b.w));
    vec2 along = (b.xy / b.w - a.xy / a.w) * resolution;
    float size = length(along);
    along = size > 0.0 ? along / size : vec2(1.0, 0.0);
    a.xy += (vec2(-along.y, along.x) * side - 0.5 * along) * width / resolution * a.w;
    vColour = color;
    gl_Position = a;
  }`;
const WIDE_FRAGMENT = 'uniform float opacity; varying vec3 vColour; void main() { gl_FragColor = vec4(vColour, opacity); }';

// Lines some pixels wide.
export class WideLines {
  constructor(width, opacity = 1) {
    this.material = new THREE.ShaderMaterial({
      uniforms: {resolution: {value: new THREE.Vector2(1, 1)}, width: {value: width}, opacity: {value: opacity}},
      vertexShader: WIDE_VERTEX, fragmentShader: WIDE_FRAGMENT, side: THREE.DoubleSide,
      // Drawn last and over everything: a path within a dense map stays in sight.
      transparent: true, depthTest: false,
    });
    this.object = new THREE.Mesh(new THREE.BufferGeometry(), this.material);
    this.object.renderOrder = 1;
    this.object.frustumCulled = false;
    this.set([]);
  }
  // segments: {frame, a, b, colour}, sorted by frame.
  set(segments) {
    this.frames = segments.map(s => s.frame);
    const count = segments.length, geometry = this.object.geometry;
    const own = new Float32Array(12 * count), other = new Float32Array(12 * count), side = new Float32Array(4 * count);
    const colour = new Uint8Array(12 * count), corners = new Uint32Array(6 * count);
    segments.forEach((s, k) => {
      for (let corner = 0; corner < 4; ++corner) {
        own.set(corner < 2 ? s.a : s.b, 12 * k + 3 * corner);
        other.set(corner < 2 ? s.b : s.a, 12 * k + 3 * corner);
        colour.set(s.colour, 12 * k + 3 * corner);
      }
      side.set([1, -1, -1, 1], 4 * k);
      corners.set([0, 1, 2, 1, 3, 2].map(c => 4 * k + c), 6 * k);
    });
    geometry.dispose();
    geometry.setAttribute('position', new THREE.BufferAttribute(own, 3));
    geometry.setAttribute('other', new THREE.BufferAttribute(other, 3));
    geometry.setAttribute('side', new THREE.BufferAttribute(side, 1));
    geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3, true));
    geometry.setIndex(new THREE.BufferAttribute(corners, 1));
    this.upTo(Infinity);
  }
  upTo(frame) { this.object.geometry.setDrawRange(0, 6 * countUpTo(this.frames, frame)); }
  setSize(width, height) { this.material.uniforms.resolution.value.set(width, height); }
}

// The segments of a path through rows that are sorted by frame. Rows of different submaps are not joined, nor those
// between which frames have no pose.
export function pathSegments(rows, colourOf, frames) {
  const gaps = frames ?? new Map(rows.map((r, k) => [r.frame, k]));
  const segments = [];
  for (let k = 1; k < rows.length; ++k) {
    const a = rows[k - 1], b = rows[k];
    const from = gaps.get(a.frame), to = gaps.get(b.frame);
    if (a.submap !== b.submap || from === undefined || to === undefined || to - from > 1) continue;
    segments.push({frame: b.frame, a: a.t, b: b.t, colour: colourOf(b)});
  }
  return segments;
}

// The same path with fewer segments: neighbours whose common end lies within `tolerance` of the line between their outer
// ends become one, of at most kMerged.
const kMerged = 10;
export function simplified(segments, tolerance) {
  const merged = [];
  let inner = [];
  for (const s of segments) {
    const last = merged.at(-1);
    const joins = last && last.b === s.a && inner.length < kMerged && last.colour[0] === s.colour[0] &&
      [...inner, s.a].every(p => offLine(p, last.a, s.b) < tolerance);
    if (!joins) {
      merged.push({...s});
      inner = [];
      continue;
    }
    inner.push(s.a);
    [last.b, last.frame] = [s.b, s.frame];
  }
  return merged;
}

// The distance of p from the segment from a to b.
function offLine(p, a, b) {
  const along = a.map((v, i) => b[i] - v), to = a.map((v, i) => p[i] - v);
  const length = along.reduce((sum, v) => sum + v * v, 0);
  const share = length > 0 ? Math.min(Math.max(along.reduce((sum, v, i) => sum + v * to[i], 0) / length, 0), 1) : 0;
  return Math.hypot(...to.map((v, i) => v - share * along[i]));
}

// The corners of a camera's frustum, in the world: its centre, then the four corners of the image at this depth.
export function frustum(pose, camera, depth) {
  const q = new THREE.Quaternion(...pose.q), t = new THREE.Vector3(...pose.t);
  const corner = (u, v) => new THREE.Vector3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1)
    .multiplyScalar(depth).applyQuaternion(q).add(t).toArray();
  return [pose.t, corner(0, 0), corner(camera.width, 0), corner(camera.width, camera.height), corner(0, camera.height)];
}

const FRUSTUM_EDGES = [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1]];
export const frustumLines = corners => FRUSTUM_EDGES.flatMap(([a, b]) => [...corners[a], ...corners[b]]);
export const frustumSegments = (corners, colour) =>
  FRUSTUM_EDGES.map(([a, b]) => ({frame: 0, a: corners[a], b: corners[b], colour}));
