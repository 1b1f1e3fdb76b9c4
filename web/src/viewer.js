// SPDX-License-Identifier: Apache-2.0
// The page: connects the source of messages, the model, the 3D view, charts, player and panels.
import {Chart, Range} from './chart.js';
import {palette, colours, submapColour} from './colours.js';
import {h, swatch} from './dom.js';
import {layOut} from './layout.js';
import {Model} from './model.js';
import {Picture} from './picture.js';
import {Player} from './player.js';
import {Scene} from './scene.js';
import {Selection} from './selection.js';
import {EmbeddedSource, SocketSource} from './source.js';

const CLICK_PIXELS = 4;
// The time between two pictures of a run that goes on, where the processor draws, which may be the one that tracks: of a
// run in real time, and of one that takes frames as fast as it can.
const REALTIME_MS = 500, FAST_MS = 2000;
// Where the processor draws such a run and the view has not moved for a while, it is looked that often whether there is something to draw.
const LOOK_MS = 100, WHILE_MS = 300;

class Page {
  constructor(root, embedded) {
    this.parts = layOut(root);
    this.model = new Model();
    this.scene = new Scene(this.parts.canvas, this.model);
    this.player = new Player(this.model, () => this.#moveInTime());
    const changed = state => this.#connection(state);
    this.source = embedded ? new EmbeddedSource(this.model, changed, embedded) : new SocketSource(this.model, changed);
    this.picture = new Picture(this.parts.image);
    this.selection = new Selection(this.parts, this.model, this.scene, this.source, new Picture(this.parts.picked));
    this.range = new Range();
    const seek = position => this.player.seek(position);
    const chart = (canvas, series) => new Chart(canvas, this.model, this.range, series, seek);
    this.charts = [
      chart(this.parts.inliers, {title: 'map points that agree with the pose', unit: 'inliers', colour: palette[1], of: f => f.hasPose ? f.inliers : null}),
      chart(this.parts.times, {title: 'time of tracking', unit: 'ms', digits: 1, colour: palette[3], of: f => f.trackingMs > 0 ? f.trackingMs : null}),
    ];
    this.shownLoop = null;
    this.#listen();
    this.forced = false;
    requestAnimationFrame(now => this.#step(now));
  }

  #listen() {
    const {parts, scene, player} = this;
    for (const [name, box] of Object.entries(parts.toggles)) box.addEventListener('change', () => scene.setVisible(name, box.checked));
    parts.pointColour.addEventListener('change', () => scene.setOption('pointColour', parts.pointColour.value));
    parts.pointSize.addEventListener('change', () => scene.setOption('pointSize', Number(parts.pointSize.value)));
    parts.covisibility.addEventListener('change', () => scene.setOption('covisibility', Number(parts.covisibility.value)));
    parts.follow.addEventListener('change', () => scene.setOption('follow', parts.follow.checked));
    // Following would take the view away from all there is at once.
    const fit = from => {
      parts.follow.checked = false;
      scene.setOption('follow', false);
      scene.fit(from);
    };
    parts.fit.addEventListener('click', () => fit('aside'));
    parts.above.addEventListener('click', () => fit('above'));
    parts.play.addEventListener('click', () => player.toggle());
    parts.newest.addEventListener('click', () => player.seek(Infinity));
    parts.slider.addEventListener('input', () => player.seek(Number(parts.slider.value)));
    parts.speed.addEventListener('change', () => player.setSpeed(Number(parts.speed.value)));
    let pressed = null;
    parts.canvas.addEventListener('pointerdown', event => { pressed = [event.offsetX, event.offsetY]; });
    parts.canvas.addEventListener('pointerup', event => {
      const still = pressed && Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) < CLICK_PIXELS;
      if (still && event.button === 0) this.selection.choose(scene.pick(event.offsetX, event.offsetY));
    });
  }

  // True while a run goes on and the processor draws.
  get #sparing() { return this.model.info.mode === 'live' && !this.scene.drawsFast; }

  // Draws what changed since the last time.
  #step(now) {
    const next = () => requestAnimationFrame(then => this.#step(then));
    if (this.#sparing && now - this.scene.rendered > WHILE_MS) setTimeout(next, LOOK_MS);
    else next();
    this.player.tick(now);
    this.#takeChanges();
    if (this.forced) this.scene.stale = true;
    this.#draw(now);
  }

  #draw(now) {
    this.scene.render(now);
    for (const chart of this.charts) chart.draw();
  }

  // The image is decoded first, so that all that changed is one picture for the browser.
  async #takeChanges() {
    const changed = this.model.takeChanges();
    if (!changed.size) return;
    if (changed.has('info')) this.source.askEvery(this.#sparing ? (this.model.info.realtime ? REALTIME_MS : FAST_MS) : 0);
    const image = changed.has('image') && this.player.atEnd ? this.model.image : null;
    const picture = image?.jpeg.length ? await this.picture.decode(image.jpeg) : null;
    this.#update(changed);
    if (image) this.#showImage(image, picture);
    this.#draw(performance.now());
  }

  #update(changed) {
    this.scene.update(changed);
    if (changed.has('info')) this.#showInfo();
    if (changed.has('points')) this.#offerColours();
    if (changed.has('frames')) {
      this.range.setCount(this.model.frames.length);
      for (const chart of this.charts) chart.stale = true;
    }
    if (changed.has('loops')) this.#showLoops();
    if (changed.has('keyFrames')) this.#showSubmaps();
    this.#moveInTime();
  }

  #connection(state) {
    this.connected = state;
    if (state === 'connected') this.everConnected = true;
    this.parts.root.classList.toggle('disconnected', state === 'disconnected');
    if (this.model.info) this.#showInfo();
  }

  #showInfo() {
    const {info} = this.model, {parts} = this;
    parts.title.textContent = info.title;
    parts.title.title = info.source ?? '';
    const modes = {live: 'live', finished: 'finished run', map: 'saved map'};
    const gone = this.connected === 'disconnected';
    parts.mode.textContent = gone ? (this.everConnected ? 'the command has ended' : 'connecting') : modes[info.mode] ?? '';
    parts.mode.className = `badge ${gone ? 'gone' : info.mode}`;
    parts.summary.replaceChildren(...(info.summary ?? []).map(([name, value]) => h('tr', {}, h('td', {}, name), h('td', {}, value))));
    parts.summaryPanel.style.display = info.summary?.length ? '' : 'none';
    parts.newest.style.display = info.mode === 'live' ? '' : 'none';
    this.#follow(info.mode === 'live');
    parts.imagePanel.style.display = info.mode === 'live' || this.model.image ? '' : 'none';
    parts.root.classList.toggle('no-frames', info.mode === 'map');
  }

  // A run that goes on is followed until the user says otherwise.
  #follow(follow) {
    if (this.followSet) return;
    this.followSet = this.model.info.mode !== '';
    this.parts.follow.checked = follow;
    this.scene.options.follow = follow;
  }

  // Points are drawn in their own colours once there are any.
  #offerColours() {
    if (this.coloursOffered || ![...this.model.points.values()].some(p => p.hasColour)) return;
    this.coloursOffered = true;
    this.parts.pointColour.value = 'own';
    this.scene.setOption('pointColour', 'own');
  }

  #showSubmaps() {
    const submaps = this.model.submaps();
    this.parts.submaps.replaceChildren(...(submaps.length < 2 ? [] : [h('h2', {}, 'Submaps'), ...submaps.map((s, k) =>
      h('div', {class: 'row'}, swatch(submapColour(k)), `submap ${s}`))]));
  }

  #showLoops() {
    const list = this.model.loops.filter(Boolean);
    const {loops} = this.parts;
    if (!list.length) return loops.replaceChildren(h('p', {class: 'note'}, 'None so far.'));
    loops.replaceChildren(...list.map(loop => h('button', {
      class: loop.index === this.shownLoop ? 'chosen' : '', 'data-loop': String(loop.index), onclick: () => this.#chooseLoop(loop.index),
      title: 'show the path before and after',
    }, `frame ${loop.frame}: ${loop.joined ? 'submaps joined' : `moved ${loop.correction.toFixed(2)} m`}`)));
    if (this.shownLoop !== null)
      loops.append(h('p', {class: 'note legend'}, swatch(colours.before), 'before', swatch(colours.after), 'after'));
  }

  #chooseLoop(index) {
    this.shownLoop = this.shownLoop === index ? null : index;
    this.scene.showLoop(this.shownLoop === null ? null : this.model.loops[index]);
    this.#showLoops();
  }

  #showImage(image, picture) {
    if (picture === undefined) return;
    this.parts.imagePanel.style.display = '';
    const count = kind => image.keypoints.filter(k => k.kind === kind).length;
    this.parts.imageText.textContent = `frame ${image.frame}: ${count(0)} tracked, ${count(1)} new, ${count(2)} lost`;
    this.picture.draw(image, picture, image.keypoints);
  }

  #moveInTime() {
    const {player, parts, model, scene} = this, row = player.row;
    scene.showUpTo(player.limit);
    const state = model.stateOf(row);
    scene.showCurrent(model.lastPoseAt(player.at), state === 'tracking');
    for (const chart of this.charts) chart.setCursor(row ? player.at : null);
    parts.play.textContent = player.playing ? '❚❚' : '▶';
    parts.slider.max = String(Math.max(0, model.frames.length - 1));
    parts.slider.value = String(player.at);
    const seconds = row && model.frames.length ? row.stamp - model.frames[0].stamp : 0;
    parts.clock.textContent = row ? `frame ${row.frame} · ${seconds.toFixed(2)} s` : '';
    parts.newest.disabled = player.atEnd;
    parts.state.textContent = state.replaceAll('_', ' ');
    parts.state.className = `pill ${state}`;
    parts.reason.textContent = model.reasonOf(row) || (row?.tentative ? 'tentative: the place is to be confirmed' : '');
    parts.counts.textContent = [
      model.frames.length && `${model.frames.length} frames`, `${model.keyFrames.size} key frames`, `${model.points.size} points`,
    ].filter(Boolean).join(' · ');
  }

  // Turns the view as fast as the browser allows for some seconds; gives the frames drawn per second, and of how many
  // points one was drawn at the end. thinning: whether the view may draw fewer points than there are.
  async measure(seconds, thinning) {
    this.forced = true;
    this.scene.thinning = thinning;
    const next = () => new Promise(requestAnimationFrame);
    const start = await next();
    let now = start, count = 0;
    while (now - start < 1000 * seconds) {
      now = await next();
      ++count;
      this.scene.camera.position.sub(this.scene.controls.target).applyAxisAngle(this.scene.camera.up, 0.01).add(this.scene.controls.target);
    }
    this.forced = false;
    this.scene.thinning = true;
    return {rate: 1000 * count / (now - start), step: this.scene.layers.points.step};
  }
}

const scene = document.getElementById('covis-scene');
const page = new Page(document.getElementById('covis-viewer'), scene?.textContent);
// For tests and measurements.
window.covis = {
  page, model: page.model,
  project: t => page.scene.project(t),
  measure: (seconds, thinning = true) => page.measure(seconds, thinning),
};
