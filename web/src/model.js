// SPDX-License-Identifier: Apache-2.0
// What the page knows: the map, the frames of the run, its loops and its newest image. It changes by the blocks of messages
// alone, and keeps which of its lists changed since they were drawn.

const edgeKey = e => e.a * 0x4000000 + e.b;

export class Model {
  constructor() { this.reset(); }

  // Forgets everything, for a new connection.
  reset() {
    this.info = {title: '', mode: '', states: [], camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 320, cy: 240}};
    this.cameras = [];
    this.keyFrames = new Map();
    this.points = new Map();
    this.edges = new Map();
    this.path = new Map();
    this.#beginLog();
    this.image = null;
    this.changed = new Set(['info', 'keyFrames', 'points', 'edges', 'path', 'frames', 'loops']);
  }

  apply(blocks) {
    for (const {kind, content} of blocks) {
      const handler = this.#handlers[kind];
      if (handler) this.changed.add(handler(content));
    }
  }

  // Returns the lists that changed since the last call.
  takeChanges() {
    const changed = this.changed;
    this.changed = new Set();
    return changed;
  }

  // The pose of a frame: as corrected, else as it was when it was tracked; null without one.
  poseOf(row) { return row && (this.path.get(row.frame) ?? (row.hasPose ? row : null)); }
  // The newest pose up to a position in the list of frames: a lost camera's last one; null before the first.
  lastPoseAt(position) {
    for (let k = position; k >= 0; --k) {
      const pose = this.poseOf(this.frames[k]);
      if (pose) return pose;
    }
    return null;
  }
  // The camera that made a key frame.
  cameraOf(keyFrame) { return this.cameras[keyFrame.camera - 1] ?? this.info.camera; }
  stateOf(row) { return row ? this.info.states[row.state] ?? '' : ''; }
  reasonOf(row) { return row ? this.texts[row.reason] ?? '' : ''; }
  sortedPath() { return [...this.path.values()].sort((a, b) => a.frame - b.frame); }
  sortedKeyFrames() { return [...this.keyFrames.values()].sort((a, b) => a.frame - b.frame || a.id - b.id); }
  // Position in the list of submaps, which gives the colour.
  submapIndex(submap) { return Math.max(0, this.submaps().indexOf(submap)); }
  submaps() {
    this.submapList ??= [...new Set([...this.keyFrames.values()].map(k => k.submap))].sort((a, b) => a - b);
    return this.submapList;
  }

  #beginLog() {
    this.frames = [];
    this.texts = [];
    this.loops = [];
  }

  #handlers = {
    info: content => {
      this.info = content;
      this.#beginLog();
      this.changed.add('frames').add('loops');
      return 'info';
    },
    cameras: list => {
      this.cameras = list;
      return 'keyFrames';
    },
    keyFrames: list => {
      for (const row of list) this.keyFrames.set(row.id, row);
      this.submapList = null;
      return 'keyFrames';
    },
    keyFramesRemoved: list => {
      for (const id of list) this.keyFrames.delete(id);
      this.submapList = null;
      return 'keyFrames';
    },
    points: list => {
      for (const row of list) this.points.set(row.id, row);
      return 'points';
    },
    pointsRemoved: list => {
      for (const id of list) this.points.delete(id);
      return 'points';
    },
    edges: list => {
      for (const row of list) this.edges.set(edgeKey(row), row);
      return 'edges';
    },
    edgesRemoved: list => {
      for (const row of list) this.edges.delete(edgeKey(row));
      return 'edges';
    },
    path: list => {
      for (const row of list) this.path.set(row.frame, row);
      return 'path';
    },
    pathRemoved: list => {
      for (const frame of list) this.path.delete(frame);
      return 'path';
    },
    frames: list => {
      for (const row of list) this.frames.push(row);
      return 'frames';
    },
    texts: list => {
      this.texts.push(...list);
      return 'frames';
    },
    loop: row => {
      this.loops[row.index] = row;
      return 'loops';
    },
    image: row => {
      this.image = row;
      return 'image';
    },
  };
}
