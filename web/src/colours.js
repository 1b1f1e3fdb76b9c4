// SPDX-License-Identifier: Apache-2.0
// The colours of the page.

export const background = '#12161d';
export const palette = ['#ffb02e', '#4fc3f7', '#c792ea', '#81c784', '#f06292', '#fff176', '#4db6ac', '#a1887f'];
export const colours = {
  covisibility: '#5f7396', loop: '#ff4dd2', tracked: '#4ade80', unmatched: '#60a5fa', lost: '#f87171', selected: '#22e0ff',
  before: '#9aa4b2', after: '#b6ff6a', neutral: '#9fb0c8',
};
export const submapColour = index => palette[index % palette.length];

export function rgb(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [n >> 16, n >> 8 & 255, n & 255];
}

// From low to high, for heights.
const ramp = ['#4360d8', '#2f9be0', '#2cc4b4', '#7bd65b', '#e6d54a', '#f59a3c'].map(rgb);
export function heightColour(share) {
  const at = Math.min(Math.max(share, 0), 1) * (ramp.length - 1), k = Math.min(Math.floor(at), ramp.length - 2);
  return ramp[k].map((c, i) => Math.round(c + (ramp[k + 1][i] - c) * (at - k)));
}
