// SPDX-License-Identifier: Apache-2.0
// The key frame or point that was picked: its image, its observations and figures.
import {h} from './dom.js';
import {NONE} from './protocol.js';

const metres = t => t.map(v => v.toFixed(3)).join(' ');
const table = rows => h('table', {}, ...rows.map(([name, value]) => h('tr', {}, h('td', {}, name), h('td', {}, value))));

export class Selection {
  constructor(parts, model, scene, source, picture) {
    Object.assign(this, {parts, model, scene, source, picture, chosen: null});
    this.clear();
  }

  clear() {
    this.chosen = null;
    this.scene.select(null);
    this.parts.pickedTitle.textContent = 'Selection';
    this.parts.picked.style.display = 'none';
    this.parts.pickedText.replaceChildren(h('p', {class: 'note'}, 'Click a key frame or a point.'));
  }

  // hit: {keyFrame: id}, {point: id} or null.
  async choose(hit) {
    if (!hit) return this.clear();
    this.chosen = hit;
    await (hit.keyFrame !== undefined ? this.#keyFrame(hit.keyFrame) : this.#point(hit.point));
  }

  async #keyFrame(id) {
    const row = this.model.keyFrames.get(id);
    if (!row) return;
    this.scene.select({keyFrame: id});
    this.parts.pickedTitle.textContent = `Key frame ${id}`;
    this.#show([], row, null);
    const observations = await this.source.ask('key_frame', id);
    if (this.chosen?.keyFrame !== id) return;
    this.scene.select({keyFrame: id, points: (observations ?? []).map(o => o.other)});
    this.#show(observations, row, this.source.imageOf(id));
  }

  async #show(observations, row, url) {
    const neighbours = [...this.model.edges.values()].filter(e => e.a === row.id || e.b === row.id);
    const loops = neighbours.filter(e => e.loop).map(e => e.a === row.id ? e.b : e.a);
    this.parts.pickedText.replaceChildren(table([
      ['frame', String(row.frame)], ['time', `${row.stamp.toFixed(3)} s`], ['position, m', metres(row.t)],
      ['observes', observations ? `${observations.length} points` : 'not kept in a report'],
      ['covisible with', `${neighbours.length} key frames`], ['loop edges to', loops.join(', ') || 'none'],
      ['parent', row.parent === NONE ? 'none' : String(row.parent)], ['submap', String(row.submap)],
    ]));
    this.parts.picked.style.display = observations ? 'block' : 'none';
    if (!observations) return;
    const keypoints = observations.map(o => ({...o, kind: 0}));
    const there = await this.picture.drawUrl(this.model.cameraOf(row), url, keypoints);
    if (url && !there && this.chosen?.keyFrame === row.id)
      this.parts.pickedText.append(h('p', {class: 'note'}, 'No image was kept, or it can’t be decoded; its observations are drawn alone.'));
  }

  async #point(id) {
    const row = this.model.points.get(id);
    if (!row) return;
    this.scene.select({point: id});
    this.parts.picked.style.display = 'none';
    this.parts.pickedTitle.textContent = `Point ${id}`;
    const list = await this.source.ask('point', id);
    if (this.chosen?.point !== id) return;
    const observers = (list ?? []).map(o => o.other);
    this.scene.select({point: id, keyFrames: observers});
    this.parts.pickedText.replaceChildren(table([
      ['position, m', metres(row.t)], ['first seen', `frame ${row.frame}`], ['submap', String(row.submap)],
      ['observed by', list ? `${observers.length} key frames` : 'not kept in a report'],
    ]), h('p', {class: 'chips'}, ...observers.map(k => h('button', {onclick: () => this.choose({keyFrame: k})}, String(k)))));
    if (!list?.length) return;
    // Its place in the image of the first key frame that observes it.
    this.parts.picked.style.display = 'block';
    const {other, u, v} = list[0], camera = this.model.cameraOf(this.model.keyFrames.get(other) ?? {});
    await this.picture.drawUrl(camera, this.source.imageOf(other), [{u, v, kind: 0, radius: 6}]);
  }
}
