// SPDX-License-Identifier: Apache-2.0
// The 3D view: draws the model up to a frame, moves the camera, and says what is under the pointer.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {background, colours, heightColour, rgb, submapColour} from './colours.js';
import {PointLayer, ThinLines, WideLines, frustum, frustumLines, frustumSegments, pathSegments, simplified} from './layers.js';

THREE.ColorManagement.enabled = false;

const PICK_PIXELS = 10;
const SLOW_MS = 30, STILL_MS = 400, MOST_THINNED = 16, FEW_POINTS = 20000;
// Returns false where the processor draws in place of a graphics card.
function drawsFast() {
  const context = document.createElement('canvas').getContext('webgl2');
  const names = context?.getExtension('WEBGL_debug_renderer_info');
  return !!context && !/swiftshader|llvmpipe|software/i.test(names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : '');
}

// Some thousand of many rows, evenly.
function some(rows) {
  const list = [...rows], step = Math.ceil(list.length / 4000);
  return list.filter((_, k) => k % step === 0);
}

function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor(share * (sorted.length - 1))];
}

const UP = new THREE.Vector3(0, -1, 0);  // a camera's y axis points down

// Without WebGL nothing is drawn in 3D, and the page says so; its charts and texts need none.
function rendererFor(canvas, antialias) {
  try {
    return new THREE.WebGLRenderer({canvas, antialias});
  } catch {
    const note = document.createElement('p');
    note.className = 'covis-note';
    note.textContent = 'This browser has no WebGL, which the view in 3D needs.';
    canvas.before(note);
    return {setPixelRatio() {}, setSize() {}, render() {}};
  }
}

export class Scene {
  constructor(canvas, model) {
    this.model = model;
    this.canvas = canvas;
    this.drawsFast = drawsFast();
    this.renderer = rendererFor(canvas, this.drawsFast);  // smooth edges cost a processor half of its frames
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.01, 10000);
    this.camera.up.copy(UP);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => { this.stale = true; });
    this.world = new THREE.Scene();
    this.world.background = new THREE.Color(background);
    this.layers = {
      points: new PointLayer(), covisibility: new ThinLines(0.35), keyFrames: new ThinLines(), wholePath: new ThinLines(0.3),
      path: new WideLines(3), loops: new WideLines(2.5), before: new WideLines(2.5), after: new WideLines(2.5),
      current: new WideLines(2.5), selected: new WideLines(2.5), selectedPoints: new PointLayer(),
    };
    this.layers.selectedPoints.material.size = 5;
    this.layers.selectedPoints.material.depthTest = false;
    for (const layer of Object.values(this.layers)) this.world.add(layer.object);
    this.axes = new THREE.AxesHelper(1);
    this.world.add(this.axes);
    this.options = {pointColour: 'height', covisibility: 100, follow: true};
    this.frame = Infinity;  // drawn up to here
    this.size = 1;          // radius of the path, metres
    this.fitted = false;
    this.thinning = true;  // fewer points while the view moves and the browser can't keep up
    this.stale = true;
  }

  // Draws again what changed.
  update(changed) {
    const map = changed.has('keyFrames') || changed.has('info');
    if (map || changed.has('path') || changed.has('points')) this.#measure();
    if (changed.has('points')) this.#drawPoints();
    if (map) this.#drawKeyFrames();
    if (map || changed.has('edges')) this.#drawEdges();
    if (map || changed.has('path') || changed.has('frames')) this.#drawPath();
    if (this.selection && (map || changed.has('points'))) this.select(this.selection);
    this.#limit();
    if (!this.fitted && this.size > 0 && (this.model.keyFrames.size > 1 || this.model.path.size > 1)) {
      this.fit();
      this.fitted = this.model.info.mode !== 'live' || this.model.keyFrames.size > 5;
    }
  }

  // Shows everything up to a frame; Infinity: all.
  showUpTo(frame) {
    this.frame = frame;
    this.#limit();
  }

  // The present camera. pose: its newest one; null: there was none so far. tracked: whether the present frame is.
  showCurrent(pose, tracked) {
    if (!pose) {
      this.layers.current.set([]);
      this.stale = true;
      return;
    }
    const corners = frustum(pose, this.model.info.camera, 1.6 * this.frustumSize());
    this.layers.current.set(frustumSegments(corners, rgb(tracked ? colours.tracked : colours.lost)));
    const now = new THREE.Vector3(...pose.t);
    if (this.options.follow && this.lastCurrent) {
      const step = now.clone().sub(this.controls.target);
      this.camera.position.add(step);
      this.controls.target.copy(now);
    }
    this.lastCurrent = now;
    this.stale = true;
  }

  setOption(name, value) {
    this.options[name] = value;
    if (name === 'pointColour') this.layers.points.setColours(this.#pointColour());
    if (name === 'covisibility') this.#drawEdges();
    if (name === 'pointSize') this.layers.points.material.size = value;
    if (name === 'follow' && value && this.lastCurrent) {
      this.camera.position.add(this.lastCurrent.clone().sub(this.controls.target));
      this.controls.target.copy(this.lastCurrent);
    }
    this.#limit();
  }

  setVisible(name, visible) {
    const layer = this.layers[name];
    if (name === 'axes') this.axes.visible = visible;
    else layer.object.visible = visible;
    this.#limit();
  }

  // Looks at everything, from behind and above; or from straight above.
  fit(from = 'aside') {
    const direction = from === 'above' ? new THREE.Vector3(0, -1, -0.001) : new THREE.Vector3(-0.45, -0.75, -0.6);
    this.controls.target.copy(this.centre);
    this.camera.position.copy(this.centre).addScaledVector(direction.normalize(), 1.9 * this.viewRadius);
    this.camera.near = this.size / 500;
    this.camera.far = this.size * 200;
    this.camera.updateProjectionMatrix();
    this.axes.scale.setScalar(this.size / 10);
    this.controls.update();
    this.stale = true;
  }

  // The paths of the key frames before and after a loop; null: none.
  showLoop(loop) {
    const segments = (places, colour) => pathSegments(
      places.map(p => ({...p, frame: p.id})).sort((a, b) => a.id - b.id), () => rgb(colour));
    this.layers.before.set(loop ? segments(loop.before, colours.before) : []);
    this.layers.after.set(loop ? segments(loop.after, colours.after) : []);
    this.stale = true;
  }

  // selection: {keyFrame: ID, points: [ids]}, {point: ID, keyFrames: [ids]}, or null.
  select(selection) {
    this.selection = selection;
    const {keyFrames, points} = this.model;
    const colour = rgb(colours.selected);
    let segments = [], rows = [];
    if (selection?.keyFrame !== undefined && keyFrames.has(selection.keyFrame)) {
      segments = frustumSegments(this.#frustumOf(keyFrames.get(selection.keyFrame)), colour);
      rows = (selection.points ?? []).map(id => points.get(id)).filter(Boolean);
    } else if (selection?.point !== undefined && points.has(selection.point)) {
      rows = [points.get(selection.point)];
      segments = (selection.keyFrames ?? []).map(id => keyFrames.get(id)).filter(Boolean)
        .map(k => ({frame: 0, a: k.t, b: rows[0].t, colour}));
    }
    this.layers.selected.set(segments);
    this.layers.selectedPoints.set(rows, () => colour);
    this.layers.selectedPoints.material.size = selection?.point !== undefined ? 9 : 4;
    this.stale = true;
  }

  // Where a point of the world is on the canvas, CSS pixels; null: behind the camera.
  project(t) {
    const p = new THREE.Vector3(...t).project(this.camera);
    if (p.z > 1 || p.z < -1) return null;
    return {x: (p.x + 1) / 2 * this.canvas.clientWidth, y: (1 - p.y) / 2 * this.canvas.clientHeight};
  }

  // What is shown at a place of the canvas: {keyFrame: id}, {point: id} or null. Key frames come first.
  pick(x, y) {
    const {points, keyFrames} = this.layers;
    const shown = keyFrames.object.visible ? [...this.model.keyFrames.values()].filter(k => k.frame <= this.frame) : [];
    const keyFrame = this.#nearest(shown, x, y, PICK_PIXELS);
    if (keyFrame) return {keyFrame: keyFrame.id};
    if (!points.object.visible) return null;
    const point = this.#nearest(points.rows.slice(0, points.drawn), x, y, PICK_PIXELS / 2);
    return point ? {point: point.id} : null;
  }

  // now: milliseconds.
  render(now) {
    this.#resize();
    this.controls.update();
    if (this.stale) this.#keepPace(now);
    else if (this.layers.points.step > 1 && now - this.rendered > STILL_MS) this.#thin(1);
    if (!this.stale) return;
    this.stale = false;
    this.rendered = now;
    this.renderer.render(this.world, this.camera);
  }

  #frustumOf(keyFrame) { return frustum(keyFrame, this.model.cameraOf(keyFrame), this.frustumSize()); }

  frustumSize() { return Math.max(1e-6, this.spacing); }

  // While the view moves too slowly for the eye, fewer points are drawn; once it is still, all are.
  #keepPace(now) {
    const interval = now - (this.rendered ?? 0);
    if (interval > STILL_MS || !this.thinning || this.layers.points.rows.length < FEW_POINTS) {
      this.pace = SLOW_MS / 2;
      return;
    }
    this.pace += 0.3 * (interval - this.pace);
    if (this.pace < SLOW_MS || this.layers.points.step >= MOST_THINNED) return;
    this.pace = SLOW_MS / 2;
    this.#thin(2 * this.layers.points.step);
  }

  #thin(step) {
    this.layers.points.thin(step);
    this.stale = true;
  }

  #nearest(rows, x, y, limit) {
    this.camera.updateMatrixWorld();
    let best = null, least = limit;
    for (const row of rows) {
      const p = this.project(row.t);
      if (!p) continue;
      const distance = Math.hypot(p.x - x, p.y - y);
      if (distance < least) [best, least] = [row, distance];
    }
    return best;
  }

  // Finds the size of what there is: the box of the paths, how far key frames are apart, and what the view is to show.
  #measure() {
    const rows = [...this.model.keyFrames.values(), ...this.model.path.values()];
    const box = new THREE.Box3();
    for (const row of rows) box.expandByPoint(new THREE.Vector3(...row.t));
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
    const radius = box.getSize(new THREE.Vector3()).length() / 2;
    const keyFrames = this.model.sortedKeyFrames();
    const steps = keyFrames.slice(1).map((k, i) => Math.hypot(...k.t.map((v, j) => v - keyFrames[i].t[j]))).sort((a, b) => a - b);
    const step = steps.length ? steps[steps.length >> 1] : radius / 10;
    this.size = Math.max(radius, 3 * step, 1e-3);
    this.spacing = Math.min(Math.max(0.7 * step, this.size / 60), this.size / 12);
    // All of the path and most points are to be seen.
    const points = some(this.model.points.values());
    if (points.length) {
      const end = share => new THREE.Vector3(...[0, 1, 2].map(axis => quantile(points.map(p => p.t[axis]), share)));
      box.expandByPoint(end(0.1)).expandByPoint(end(0.9));
    }
    this.centre = box.getCenter(new THREE.Vector3());
    this.viewRadius = Math.max(this.size, box.getSize(new THREE.Vector3()).length() / 2);
  }

  #pointColour() {
    const mode = this.options.pointColour;
    if (mode === 'submap') return p => rgb(submapColour(this.model.submapIndex(p.submap)));
    const heights = some(this.model.points.values()).map(p => -p.t[1]);
    const low = quantile(heights, 0.03) ?? 0, high = quantile(heights, 0.97) ?? 1;
    const byHeight = p => heightColour((-p.t[1] - low) / Math.max(high - low, 1e-9));
    return mode === 'own' ? p => p.hasColour ? p.colour : rgb(colours.neutral) : byHeight;
  }

  #drawPoints() { this.layers.points.set(this.model.points.values(), this.#pointColour()); }

  #drawKeyFrames() {
    this.layers.keyFrames.set(this.model.sortedKeyFrames().map(k => ({
      frame: k.frame, lines: frustumLines(this.#frustumOf(k)),
      colour: rgb(submapColour(this.model.submapIndex(k.submap))).map(c => 0.8 * c),
    })));
  }

  #drawEdges() {
    const {keyFrames, edges} = this.model;
    const drawn = [...edges.values()].filter(e => keyFrames.has(e.a) && keyFrames.has(e.b)).map(e => {
      const a = keyFrames.get(e.a), b = keyFrames.get(e.b);
      return {frame: Math.max(a.frame, b.frame), a: a.t, b: b.t, lines: [...a.t, ...b.t], colour: rgb(e.loop ? colours.loop : colours.covisibility), edge: e};
    }).sort((x, y) => x.frame - y.frame);
    this.layers.covisibility.set(drawn.filter(d => !d.edge.loop && this.options.covisibility && d.edge.shared >= this.options.covisibility));
    this.layers.loops.set(drawn.filter(d => d.edge.loop));
  }

  #drawPath() {
    const colourOf = row => rgb(submapColour(this.model.submapIndex(row.submap)));
    const rows = this.model.path.size ? this.model.sortedPath() : this.model.sortedKeyFrames();
    const frames = this.model.path.size ? new Map(this.model.frames.map((f, k) => [f.frame, k])) : undefined;
    const segments = simplified(pathSegments(rows, colourOf, frames), this.size / 2000);
    this.layers.path.set(segments);
    this.layers.wholePath.set(segments.map(s => ({...s, lines: [...s.a, ...s.b]})));
  }

  #limit() {
    for (const name of ['points', 'covisibility', 'keyFrames', 'path', 'loops']) this.layers[name].upTo(this.frame);
    this.layers.wholePath.upTo(Infinity);
    this.stale = true;
  }

  #resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (!width || !height || (this.width === width && this.height === height)) return;
    [this.width, this.height] = [width, height];
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    for (const layer of Object.values(this.layers)) layer.setSize?.(width, height);
    this.stale = true;
  }
}
