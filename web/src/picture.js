// SPDX-License-Identifier: Apache-2.0
// An image with its keypoints: the present one of a run, or a key frame's with its observations.
import {colours} from './colours.js';

const kinds = [colours.tracked, colours.unmatched, colours.lost];

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.asked = 0;
  }

  // size: of the image in which the keypoints are. picture: anything drawImage() takes; null: none. keypoints: {u, v, kind},
  // and the radius of those that are to be larger.
  draw(size, picture, keypoints) {
    const {canvas} = this, ratio = window.devicePixelRatio;
    canvas.style.aspectRatio = `${size.width} / ${size.height}`;
    canvas.width = Math.max(1, canvas.clientWidth * ratio);
    canvas.height = Math.max(1, canvas.clientHeight * ratio);
    const pen = canvas.getContext('2d'), scale = canvas.width / size.width;
    pen.fillStyle = '#0b0e13';
    pen.fillRect(0, 0, canvas.width, canvas.height);
    if (picture) pen.drawImage(picture, 0, 0, canvas.width, canvas.height);
    pen.lineWidth = ratio;
    // What was tracked lies on top.
    for (const {u, v, kind, radius} of [...keypoints].sort((a, b) => b.kind - a.kind)) {
      const x = (u + 0.5) * scale, y = (v + 0.5) * scale, r = (radius ?? (kind === 0 ? 1.8 : 1)) * ratio;
      pen.strokeStyle = kinds[kind];
      pen.strokeRect(x - r, y - r, 2 * r, 2 * r);
    }
  }

  // Gives what draw() takes; undefined: a newer one was asked for meanwhile.
  async decode(jpeg) {
    const turn = ++this.asked;
    const picture = await createImageBitmap(new Blob([jpeg], {type: 'image/jpeg'})).catch(() => null);
    return turn === this.asked ? picture : undefined;
  }

  // url: null: none. Gives whether there was a picture.
  async drawUrl(size, url, keypoints) {
    const turn = ++this.asked;
    this.draw(size, null, keypoints);
    this.canvas.dataset.picture = 'no';
    const response = url ? await fetch(url).catch(() => null) : null;
    if (!response?.ok) return false;
    const picture = await response.blob().then(blob => createImageBitmap(blob)).catch(() => null);
    if (!picture) return false;
    if (turn === this.asked) {
      this.draw(size, picture, keypoints);
      this.canvas.dataset.picture = 'yes';
    }
    return true;
  }
}
