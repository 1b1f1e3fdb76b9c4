// SPDX-License-Identifier: Apache-2.0
// The place in time: at the newest frame, or at one that was chosen, from where it can play.

export class Player {
  // moved: called when the place changes.
  constructor(model, moved) {
    Object.assign(this, {model, moved, position: null, playing: false, speed: 1});
  }

  // Position in the list of frames; the newest one's at the end.
  get at() { return Math.max(0, Math.min(this.position ?? Infinity, this.model.frames.length - 1)); }
  get row() { return this.model.frames[this.at] ?? null; }
  get atEnd() { return this.position === null; }
  // The frame up to which to draw: all at the end.
  get limit() { return this.atEnd ? Infinity : this.row?.frame ?? Infinity; }

  seek(position) {
    this.position = position >= this.model.frames.length - 1 ? null : Math.max(0, position);
    this.moved();
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.atEnd) this.position = 0;
    this.clock = null;
    this.moved();
  }

  // Goes on in time. now: milliseconds.
  tick(now) {
    if (!this.playing) return;
    const {frames} = this.model;
    this.clock ??= {now, stamp: this.row?.stamp ?? 0};
    const stamp = this.clock.stamp + (now - this.clock.now) / 1000 * this.speed;
    let next = this.at;
    while (next + 1 < frames.length && frames[next + 1].stamp <= stamp) ++next;
    if (next >= frames.length - 1) this.playing = false;
    if (next !== this.at || !this.playing) this.seek(next);
  }

  setSpeed(speed) {
    this.speed = speed;
    this.clock = null;
  }
}
