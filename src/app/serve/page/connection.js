/* The one WebSocket to the server (protocol.h): messages, pictures, and another try when it was lost. */
import {tell} from "./world.js";

const header = 24, magic = 0x52464c53; /* "SLFR" */
const uncounted = new Set(["got", "pick", "story"]);
const longest_wait = 4000;
let socket = null, wait = 250, lost = 0, unnumbered = [];
const held = new Map();

/* Takes the token out of the address bar at once; a reload finds it in this tab's storage. */
function token() {
  if (location.hash.length > 1) {
    sessionStorage.setItem("token", location.hash.slice(1));
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") || "";
}

/* Sends a message; `since` is the time of the hand's event that it comes of. */
export function send(message, since) {
  if (!socket || socket.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify(message));
  if (!uncounted.has(message.do)) unnumbered.push({message, since});
  return true;
}

/* Sends at most one message of a key for each picture of the screen: the newest. */
export function send_smoothly(key, message, since) {
  const waiting = held.get(key);
  if (waiting) {
    held.set(key, {message, since: waiting.since ?? since});
    return;
  }
  send(message, since);
  held.set(key, {});
  requestAnimationFrame(() => {
    const next = held.get(key);
    held.delete(key);
    if (next?.message) send_smoothly(key, next.message, next.since);
  });
}

/* Sends the last message of a row, and none of the row that still waits. */
export function send_last(key, message, since) {
  if (held.has(key)) held.set(key, {});
  return send(message, since);
}

/* Tells whether a message of the kind is on its way, or waits to be. */
export const is_unanswered = kind => held.get(kind)?.message || unnumbered.some(u => u.message.do === kind);

function number_event(news) {
  const at = unnumbered.findIndex(u => u.message.do === news.do);
  if (at < 0) return;
  tell("numbered", {event: news.event, ...unnumbered[at]});
  unnumbered.splice(0, at + 1);
}

function receive_text(text) {
  const news = JSON.parse(text);
  if (news.is === "did") number_event(news);
  if (news.is === "refused") unnumbered.splice(0, 1 + unnumbered.findIndex(u => u.message.do === news.do));
  tell(news.is, news);
}

function receive_picture(bytes) {
  const head = new DataView(bytes);
  if (bytes.byteLength <= header || head.getUint32(0, true) !== magic) return;
  tell("frame", {
    kind: head.getUint8(4),
    still: head.getUint8(5) === 1,
    index: head.getUint16(6, true),
    number: head.getUint32(8, true),
    width: head.getUint16(12, true),
    height: head.getUint16(14, true),
    event: Number(head.getBigUint64(16, true)),
    bytes: bytes.byteLength,
    file: new Blob([bytes.slice(header)], {type: head.getUint8(5) ? "image/png" : "image/jpeg"})
  });
}

function opened() {
  wait = 250;
  lost = 0;
  unnumbered = [];
  tell("connection", {state: "open"});
}

function closed(event) {
  socket = null;
  lost++;
  tell("connection", {state: "lost", times: lost, reason: event.reason});
  setTimeout(connect, wait);
  wait = Math.min(2 * wait, longest_wait);
}

export function connect() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  socket = new WebSocket(scheme + "//" + location.host + "/socket?" + encodeURIComponent(token()));
  socket.binaryType = "arraybuffer";
  socket.onopen = opened;
  socket.onclose = closed;
  socket.onmessage = m => typeof m.data === "string" ? receive_text(m.data) : receive_picture(m.data);
}
