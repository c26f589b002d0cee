"use strict";
// Shows frames of side a, and orbits. The token leaves the address bar at once.
const token = location.hash.slice(1) || sessionStorage.getItem("token");
sessionStorage.setItem("token", token);
history.replaceState(null, "", "/");
const canvas = document.querySelector("canvas"), state = document.getElementById("state");
const socket = new WebSocket(`ws://${location.host}/socket?${token}`);
socket.binaryType = "arraybuffer";
let camera = null;
const say = message => socket.send(JSON.stringify(message));

async function show(data) {
    const view = new DataView(data), kind = view.getUint8(4);
    say({do: "got", frame: view.getUint32(8, true)});
    if (kind !== 0) return;
    const picture = await createImageBitmap(new Blob([data.slice(24)]));
    canvas.width = picture.width;
    canvas.height = picture.height;
    canvas.getContext("2d").drawImage(picture, 0, 0);
}

socket.onmessage = event => {
    if (event.data instanceof ArrayBuffer) return void show(event.data);
    const message = JSON.parse(event.data);
    if (message.is === "hello") camera = message.scene.camera;
    if (message.is === "state") state.textContent = `${message.method}, ${message.batches} updates`;
};
socket.onclose = event => { state.textContent = `the connection has ended: ${event.reason}`; };

canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
canvas.onpointermove = event => {
    if (!camera || !event.buttons) return;
    const d = camera.eye.map((x, i) => x - camera.target[i]), angle = -0.01 * event.movementX;
    const turned = [Math.cos(angle) * d[0] + Math.sin(angle) * d[2], d[1] + 0.01 * event.movementY * Math.hypot(...d),
                    Math.cos(angle) * d[2] - Math.sin(angle) * d[0]];
    camera.eye = turned.map((x, i) => x + camera.target[i]);
    camera.up = [0, 1, 0];
    say({do: "camera", ...camera});
};
