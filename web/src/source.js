// SPDX-License-Identifier: Apache-2.0
// Where the page's messages come from: the command that serves it, or the report that it is part of.
import {decode} from './protocol.js';

const RETRY_MS = 1000;

export class SocketSource {
  // changed: called with 'connected' or 'disconnected'.
  constructor(model, changed) {
    this.model = model;
    this.changed = changed;
    this.received = {messages: 0, bytes: 0};
    this.waiting = new Map();  // question: those who wait for the answer
    this.#connect();
  }

  imageOf(keyFrame) { return `key_frame/${keyFrame}`; }

  // kind: key_frame or point. Gives the observations.
  ask(kind, id) {
    return new Promise(resolve => {
      const key = `${kind} ${id}`;
      this.waiting.set(key, [...this.waiting.get(key) ?? [], resolve]);
      if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({[kind]: id}));
    });
  }

  // Asks for at most one message in that time.
  askEvery(milliseconds) {
    this.interval = milliseconds;
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({interval: milliseconds}));
  }

  #connect() {
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => {
      this.model.reset();
      this.changed('connected');
    };
    this.socket.onmessage = event => {
      ++this.received.messages;
      this.received.bytes += event.data.byteLength;
      const blocks = decode(event.data);
      this.model.apply(blocks);
      for (const {kind, content} of blocks) {
        if (kind === 'keyFrameObservations') this.#answer(`key_frame ${content.id}`, content.list);
        if (kind === 'pointObservations') this.#answer(`point ${content.id}`, content.list);
      }
    };
    this.socket.onclose = () => {
      this.changed('disconnected');
      setTimeout(() => this.#connect(), RETRY_MS);
    };
  }

  #answer(key, list) {
    for (const resolve of this.waiting.get(key) ?? []) resolve(list);
    this.waiting.delete(key);
  }
}

export class EmbeddedSource {
  constructor(model, changed, text) {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    model.apply(decode(bytes.buffer));
    changed('embedded');
  }
  askEvery() {}
  imageOf() { return null; }
  ask() { return Promise.resolve(null); }
}
