// SPDX-License-Identifier: Apache-2.0
// A chart of one figure over the frames. Charts that share a Range show the same frames: the wheel zooms, dragging moves,
// a double click shows all again, a click goes to the frame.
import {colours, palette} from './colours.js';

const LEFT = 42, BOTTOM = 16, TOP = 18, RIGHT = 8;
const DRAG_PIXELS = 4;

// The frames that charts show, by their positions in the list of frames.
export class Range {
  constructor() {
    this.count = 0;
    this.listeners = [];
    this.reset();
  }
  setCount(count) {
    const whole = this.whole;
    this.count = count;
    if (whole) this.reset();
  }
  reset() {
    [this.first, this.last] = [0, Math.max(1, this.count - 1)];
    this.whole = true;
    this.#tell();
  }
  zoom(centre, factor) {
    this.#set(centre - (centre - this.first) * factor, centre + (this.last - centre) * factor);
  }
  move(by) {
    const end = Math.max(1, this.count - 1);
    const step = Math.min(Math.max(by, -this.first), end - this.last);
    this.#set(this.first + step, this.last + step);
  }
  #set(first, last) {
    const end = Math.max(1, this.count - 1);
    if (last - first < 8) return;
    [this.first, this.last] = [Math.max(0, first), Math.min(end, last)];
    this.whole = this.first === 0 && this.last === end;
    this.#tell();
  }
  #tell() { for (const listener of this.listeners) listener(); }
}

const nice = value => {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map(k => k * power).find(k => k >= value) ?? value;
};

export class Chart {
  // series: {title, unit, colour, of: row => number or null}; seek: called with a position in the list of frames.
  constructor(canvas, model, range, series, seek) {
    Object.assign(this, {canvas, model, range, series, seek, cursor: null, hover: null, stale: true});
    range.listeners.push(() => { this.stale = true; });
    canvas.addEventListener('wheel', event => {
      event.preventDefault();
      range.zoom(this.#positionAt(event.offsetX), event.deltaY > 0 ? 1.25 : 0.8);
    }, {passive: false});
    canvas.addEventListener('dblclick', () => range.reset());
    canvas.addEventListener('pointerdown', event => this.#press(event));
    canvas.addEventListener('pointermove', event => this.#move(event));
    canvas.addEventListener('pointerup', event => this.#release(event));
    canvas.addEventListener('pointerleave', () => this.#setHover(null));
  }

  setCursor(position) {
    if (position !== this.cursor) this.stale = true;
    this.cursor = position;
  }

  draw() {
    const ratio = window.devicePixelRatio, {clientWidth: width, clientHeight: height} = this.canvas;
    if (this.width !== width || this.height !== height) {
      [this.width, this.height] = [width, height];
      [this.canvas.width, this.canvas.height] = [width * ratio, height * ratio];
      this.stale = true;
    }
    if (!this.stale || !width || !height) return;
    this.stale = false;
    const pen = this.canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = '11px system-ui, sans-serif';
    this.#measure();
    this.#drawGrid(pen);
    this.#drawMarks(pen);
    this.#drawLine(pen);
    this.#drawLabels(pen);
  }

  #measure() {
    const {first, last} = this.range, values = [];
    for (let k = Math.floor(first); k <= Math.min(last, this.model.frames.length - 1); ++k) {
      const value = this.series.of(this.model.frames[k]);
      if (value !== null) values.push(value);
    }
    values.sort((a, b) => a - b);
    // A few frames that are far beyond the others would flatten the line.
    const usual = values[Math.floor(0.99 * (values.length - 1))] ?? 1;
    this.top = nice(Math.max(1, Math.min(values.at(-1) ?? 1, 1.6 * usual)));
  }

  #x(position) {
    return LEFT + (position - this.range.first) / (this.range.last - this.range.first) * (this.width - LEFT - RIGHT);
  }
  #y(value) { return TOP + (1 - Math.min(value / this.top, 1)) * (this.height - TOP - BOTTOM); }
  #positionAt(x) {
    const share = (x - LEFT) / Math.max(1, this.width - LEFT - RIGHT);
    return this.range.first + Math.min(Math.max(share, 0), 1) * (this.range.last - this.range.first);
  }

  #drawGrid(pen) {
    pen.lineWidth = 1;
    pen.textAlign = 'right';
    pen.textBaseline = 'middle';
    for (const share of [0, 0.5, 1]) {
      const y = Math.round(this.#y(share * this.top)) + 0.5;
      pen.strokeStyle = '#2a3342';
      pen.beginPath();
      pen.moveTo(LEFT, y);
      pen.lineTo(this.width - RIGHT, y);
      pen.stroke();
      pen.fillStyle = '#8b98ab';
      pen.fillText(String(share * this.top), LEFT - 6, y);
    }
    pen.textBaseline = 'alphabetic';
    const frames = this.model.frames, end = frames.length - 1;
    for (const [position, align] of [[this.range.first, 'left'], [this.range.last, 'right']]) {
      const row = frames[Math.min(Math.round(position), end)];
      pen.textAlign = align;
      if (row) pen.fillText(String(row.frame), this.#x(position), this.height - 3);
    }
  }

  // Frames without a pose, and loops.
  #drawMarks(pen) {
    const {frames, loops} = this.model;
    const width = Math.max(1, this.#x(1) - this.#x(0));
    pen.fillStyle = 'rgba(248, 113, 113, 0.35)';
    for (let k = Math.floor(this.range.first); k <= Math.min(this.range.last, frames.length - 1); ++k) {
      if (this.model.stateOf(frames[k]) !== 'tracking') pen.fillRect(this.#x(k), TOP, width, this.height - TOP - BOTTOM);
    }
    pen.fillStyle = colours.loop;
    for (const loop of loops) {
      const k = loop ? frames.findIndex(f => f.frame >= loop.frame) : -1;
      if (k >= this.range.first && k <= this.range.last) pen.fillRect(this.#x(k), TOP, 1.5, this.height - TOP - BOTTOM);
    }
  }

  // One column of pixels shows the least and the greatest of its frames.
  #drawLine(pen) {
    pen.strokeStyle = this.series.colour;
    pen.lineWidth = 1.2;
    pen.beginPath();
    let open = false;
    const {first, last} = this.range, end = Math.min(Math.ceil(last), this.model.frames.length - 1);
    const step = Math.max(1, Math.floor((last - first) / (2 * this.width)));
    for (let k = Math.floor(first); k <= end; k += step) {
      const values = this.model.frames.slice(k, k + step).map(f => this.series.of(f)).filter(v => v !== null);
      if (values.length) {
        const x = this.#x(k), low = this.#y(Math.min(...values)), high = this.#y(Math.max(...values));
        if (open) pen.lineTo(x, low); else pen.moveTo(x, low);
        if (high !== low) pen.lineTo(x, high);
      }
      open = values.length > 0;
    }
    pen.stroke();
  }

  #drawLabels(pen) {
    const at = this.hover ?? this.cursor, row = at === null ? null : this.model.frames[at];
    pen.textAlign = 'left';
    pen.fillStyle = '#dbe4f0';
    pen.fillText(this.series.title, LEFT, 12);
    if (!row) return;
    pen.fillStyle = this.hover === null ? '#ffffff' : palette[1];
    pen.fillRect(this.#x(at) - 0.5, TOP, 1, this.height - TOP - BOTTOM);
    const value = this.series.of(row);
    pen.textAlign = 'right';
    const text = value === null ? 'none' : `${value.toFixed(this.series.digits ?? 0)} ${this.series.unit}`;
    pen.fillText(`frame ${row.frame}: ${text}`, this.width - RIGHT, 12);
  }

  #setHover(position) {
    if (position !== this.hover) this.stale = true;
    this.hover = position;
  }
  #press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.pressed = {x: event.offsetX, moved: false};
  }
  #move(event) {
    const end = this.model.frames.length - 1;
    this.#setHover(end < 0 ? null : Math.min(Math.round(this.#positionAt(event.offsetX)), end));
    if (!this.pressed) return;
    const by = this.pressed.x - event.offsetX;
    if (!this.pressed.moved && Math.abs(by) < DRAG_PIXELS) return;
    this.pressed = {x: event.offsetX, moved: true};
    this.range.move(by / Math.max(1, this.width - LEFT - RIGHT) * (this.range.last - this.range.first));
  }
  #release(event) {
    if (this.pressed && !this.pressed.moved && this.model.frames.length) this.seek(Math.round(this.#positionAt(event.offsetX)));
    this.pressed = null;
  }
}
