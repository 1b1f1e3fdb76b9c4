// SPDX-License-Identifier: Apache-2.0
// Reads the blocks of a message. Their layout is that of apps/view/rows.h and protocol.h.

const names = [
  '', 'info', 'keyFrames', 'keyFramesRemoved', 'points', 'pointsRemoved', 'edges', 'edgesRemoved', 'path', 'pathRemoved',
  'frames', 'texts', 'loop', 'image', 'keyFrameObservations', 'pointObservations',
  'cameras',
];

export const NONE = 0xffffffff;
const PIXEL_UNITS = 4;
const utf8 = new TextDecoder();

// Reads numbers one after the other.
class Reader {
  constructor(buffer, offset, size) {
    this.view = new DataView(buffer, offset, size);
    this.at = 0;
  }
  get done() { return this.at >= this.view.byteLength; }
  u8() { return this.view.getUint8(this.at++); }
  u16() { return this.#take(2, this.view.getUint16(this.at, true)); }
  u32() { return this.#take(4, this.view.getUint32(this.at, true)); }
  i32() { return this.#take(4, this.view.getInt32(this.at, true)); }
  f32() { return this.#take(4, this.view.getFloat32(this.at, true)); }
  f64() { return this.#take(8, this.view.getFloat64(this.at, true)); }
  floats(count) { return Array.from({length: count}, () => this.f32()); }
  pose() { return {t: this.floats(3), q: this.floats(4)}; }
  #take(size, value) {
    this.at += size;
    return value;
  }
}

function rows(reader, read) {
  const list = [];
  while (!reader.done) list.push(read(reader));
  return list;
}

const camera = r => ({fx: r.f32(), fy: r.f32(), cx: r.f32(), cy: r.f32(), width: r.u32(), height: r.u32()});
const keyFrame = r => ({
  id: r.u32(), submap: r.u32(), frame: r.i32(), parent: r.u32(), stamp: r.f64(), ...r.pose(), camera: r.u32(),
});
const edge = r => ({a: r.u32(), b: r.u32(), shared: r.u16(), loop: r.u16() === 1});
const pathRow = r => ({frame: r.i32(), submap: r.u32(), ...r.pose()});
const observation = r => ({other: r.u32(), u: r.u16() / PIXEL_UNITS, v: r.u16() / PIXEL_UNITS});
const place = r => ({id: r.u32(), t: r.floats(3), submap: r.u32()});
const point = r => ({
  id: r.u32(), t: r.floats(3), colour: [r.u8(), r.u8(), r.u8()], hasColour: r.u8() === 1, submap: r.u32(), frame: r.i32(),
});

function frame(r) {
  const row = {frame: r.i32(), state: r.u8()};
  const flags = r.u8();
  Object.assign(row, {reason: r.u16(), stamp: r.f64(), ...r.pose(), submap: r.u32()});
  Object.assign(row, {inliers: r.i32(), features: r.i32(), trackingMs: r.f32(), totalMs: r.f32()});
  return Object.assign(row, {keyFrame: !!(flags & 1), tentative: !!(flags & 2), hasPose: !!(flags & 4)});
}

function loop(r) {
  const row = {index: r.u32(), frame: r.i32(), joined: r.u32() === 1, correction: r.f32()};
  const before = r.u32(), after = r.u32();
  row.before = Array.from({length: before}, () => place(r));
  row.after = Array.from({length: after}, () => place(r));
  return row;
}

function image(r, buffer, offset) {
  const row = {frame: r.i32(), width: r.u32(), height: r.u32()};
  const keypoints = r.u32(), bytes = r.u32();
  row.keypoints = Array.from({length: keypoints}, () => ({u: r.u16() / PIXEL_UNITS, v: r.u16() / PIXEL_UNITS, kind: r.u32()}));
  row.jpeg = new Uint8Array(buffer, offset + r.at, bytes);
  return row;
}

const readers = {
  info: (r, text) => JSON.parse(text),
  texts: (r, text) => JSON.parse(text),
  cameras: r => rows(r, camera),
  keyFrames: r => rows(r, keyFrame),
  keyFramesRemoved: r => rows(r, x => x.u32()),
  points: r => rows(r, point),
  pointsRemoved: r => rows(r, x => x.u32()),
  edges: r => rows(r, edge),
  edgesRemoved: r => rows(r, x => ({a: x.u32(), b: x.u32()})),
  path: r => rows(r, pathRow),
  pathRemoved: r => rows(r, x => x.i32()),
  frames: r => rows(r, frame),
  loop,
  keyFrameObservations: r => ({id: r.u32(), list: rows(r, observation)}),
  pointObservations: r => ({id: r.u32(), list: rows(r, observation)}),
};

// Returns a list of {kind, content}.
export function decode(buffer) {
  const blocks = [];
  const head = new DataView(buffer);
  for (let at = 0; at + 8 <= buffer.byteLength;) {
    const kind = names[head.getUint32(at, true)], size = head.getUint32(at + 4, true);
    const reader = new Reader(buffer, at + 8, size);
    if (kind === 'image') {
      blocks.push({kind, content: image(reader, buffer, at + 8)});
    } else if (kind) {
      const text = kind === 'info' || kind === 'texts' ? utf8.decode(new Uint8Array(buffer, at + 8, size)) : '';
      blocks.push({kind, content: readers[kind](reader, text)});
    }
    at += 8 + Math.ceil(size / 4) * 4;
  }
  return blocks;
}
