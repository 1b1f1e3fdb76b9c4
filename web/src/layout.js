// SPDX-License-Identifier: Apache-2.0
// The elements of the page, by name.
import {colours, palette} from './colours.js';
import {h, swatch} from './dom.js';

const layerRow = (parts, name, label, colour, checked = true) => {
  const box = h('input', {type: 'checkbox', id: `covis-show-${name}`, checked});
  parts.toggles[name] = box;
  return h('label', {class: 'row'}, box, swatch(colour), label);
};

const select = (id, options, chosen) => {
  const element = h('select', {id}, ...options.map(([value, text]) => h('option', {value}, text)));
  element.value = chosen;
  return element;
};

function top(parts) {
  parts.title = h('span', {class: 'title'});
  parts.mode = h('span', {class: 'badge', id: 'covis-mode'});
  parts.state = h('span', {class: 'pill', id: 'covis-state'});
  parts.reason = h('span', {class: 'reason', id: 'covis-reason'});
  parts.counts = h('span', {class: 'counts', id: 'covis-counts'});
  return h('header', {}, h('b', {}, 'Covis'), parts.title, parts.mode, parts.state, parts.reason, parts.counts);
}

function left(parts) {
  parts.pointColour = select('covis-colour', [['own', 'own colour'], ['height', 'by height'], ['submap', 'by submap']], 'height');
  parts.covisibility = select('covis-covisibility', [['0', 'off'], ['100', '100 points'], ['15', '15 points']], '100');
  parts.pointSize = select('covis-size', [['1', 'small'], ['2', 'medium'], ['3.5', 'large']], '2');
  parts.follow = h('input', {type: 'checkbox', id: 'covis-follow'});
  parts.fit = h('button', {id: 'covis-fit'}, 'All');
  parts.above = h('button', {id: 'covis-above'}, 'From above');
  parts.submaps = h('div', {id: 'covis-submaps'});
  parts.loops = h('div', {id: 'covis-loops', class: 'list'});
  return h('aside', {class: 'left'},
    h('h2', {}, 'Shown'),
    layerRow(parts, 'path', 'path', palette[0]), layerRow(parts, 'keyFrames', 'key frames', '#cc8d25'),
    layerRow(parts, 'points', 'points', '#7bd65b'),
    h('label', {class: 'row sub'}, 'colour', parts.pointColour), h('label', {class: 'row sub'}, 'size', parts.pointSize),
    layerRow(parts, 'covisibility', 'covisibility', colours.covisibility),
    h('label', {class: 'row sub'}, 'from', parts.covisibility),
    layerRow(parts, 'loops', 'loop edges', colours.loop), layerRow(parts, 'current', 'camera', colours.tracked),
    layerRow(parts, 'axes', 'axes x y z', 'linear-gradient(90deg, #f44 33%, #4f4 33% 66%, #48f 66%)'),
    h('h2', {}, 'View'),
    h('label', {class: 'row'}, parts.follow, 'follow the camera'),
    h('div', {class: 'row'}, parts.fit, parts.above),
    parts.submaps, h('h2', {id: 'covis-loops-title'}, 'Loops'), parts.loops);
}

function right(parts) {
  parts.image = h('canvas', {class: 'picture', id: 'covis-image'});
  parts.imageText = h('p', {class: 'note', id: 'covis-image-text'});
  parts.imagePanel = h('section', {}, h('h2', {}, 'Image'), parts.image,
    h('p', {class: 'note legend'}, swatch(colours.tracked), 'tracked', swatch(colours.unmatched), 'new', swatch(colours.lost), 'lost'), parts.imageText);
  parts.picked = h('canvas', {class: 'picture', id: 'covis-picked'});
  parts.pickedTitle = h('h2', {id: 'covis-picked-title'}, 'Selection');
  parts.pickedText = h('div', {id: 'covis-picked-text'});
  parts.summary = h('table', {id: 'covis-summary'});
  parts.summaryPanel = h('section', {id: 'covis-summary-panel'}, h('h2', {}, 'Result'), parts.summary);
  return h('aside', {class: 'right'}, parts.imagePanel, h('section', {}, parts.pickedTitle, parts.picked, parts.pickedText), parts.summaryPanel);
}

function bottom(parts) {
  parts.play = h('button', {id: 'covis-play', title: 'play or pause'}, '▶');
  parts.slider = h('input', {type: 'range', id: 'covis-time', min: '0', value: '0', title: 'time'});
  parts.speed = select('covis-speed', [['0.25', '¼×'], ['1', '1×'], ['4', '4×'], ['16', '16×']], '1');
  parts.clock = h('span', {class: 'clock', id: 'covis-clock'});
  parts.newest = h('button', {id: 'covis-newest'}, 'Live');
  parts.inliers = h('canvas', {class: 'chart', id: 'covis-inliers'});
  parts.times = h('canvas', {class: 'chart', id: 'covis-times'});
  parts.bottom = h('footer', {}, h('div', {class: 'player'}, parts.play, parts.slider, parts.speed, parts.clock, parts.newest),
    h('div', {class: 'charts'}, parts.inliers, parts.times));
  return parts.bottom;
}

// Fills the root with the page and returns its parts.
export function layOut(root) {
  const parts = {root, toggles: {}};
  parts.canvas = h('canvas', {id: 'covis-canvas'});
  parts.hint = h('div', {class: 'hint'}, 'drag: orbit · right drag: move · wheel: zoom · click: pick');
  root.replaceChildren(top(parts), left(parts), h('main', {}, parts.canvas, parts.hint), right(parts), bottom(parts));
  return parts;
}
