"""A visitor of `softlux serve` without a browser: a WebSocket by Python's standard library, and the server as
a child."""
import base64
import json
import os
import select
import socket
import struct
import subprocess
import time


class Closed(Exception):
    """The connection has ended; the reason is its text."""


class Server:
    def __init__(self, program, *words, environment=None):
        self.child = subprocess.Popen([program, "serve", *words], stdout=subprocess.PIPE, text=True,
                                      env={**os.environ, **(environment or {})})
        self.address = self.child.stdout.readline().strip()
        if not self.address:
            raise SystemExit("serve printed no address")
        self.host, self.token = self.address[len("http://"):].split("/#")

    def fetch(self, path, host=None, origin=None):
        """The status and the body of a request."""
        with socket.create_connection(self.host.rsplit(":", 1), timeout=20) as s:
            lines = [f"GET {path} HTTP/1.1", f"Host: {host or self.host}", "Connection: close"]
            lines += [f"Origin: {origin}"] if origin else []
            s.sendall("\r\n".join(lines + ["", ""]).encode())
            answer = b"".join(iter(lambda: s.recv(65536), b""))
        head, _, body = answer.partition(b"\r\n\r\n")
        return int(head.split()[1]) if head else 0, head.decode(), body

    def memory_kib(self):
        with open(f"/proc/{self.child.pid}/status", encoding="ascii") as lines:
            return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))

    def processor_seconds(self):
        with open(f"/proc/{self.child.pid}/stat", encoding="ascii") as line:
            return sum(map(int, line.read().rsplit(")")[-1].split()[11:13])) / os.sysconf("SC_CLK_TCK")

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.child.pid}/fd"))

    def stop(self):
        """Ctrl-C; the exit status."""
        self.child.send_signal(2)
        try:
            return self.child.wait(60)
        except subprocess.TimeoutExpired:
            self.child.kill()
            raise


class Visitor:
    """One WebSocket. Frames are acknowledged as they are read, unless `slow`."""

    def __init__(self, server, token=None, origin=None, path="/socket", slow=False):
        self.slow, self.rest, self.bytes = slow, b"", 0
        self.socket = socket.create_connection(server.host.rsplit(":", 1), timeout=20)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        lines = [f"GET {path}?{server.token if token is None else token} HTTP/1.1", f"Host: {server.host}",
                 "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
                 f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}"]
        if origin != "":
            lines.append(f"Origin: {origin or 'http://' + server.host}")
        self.socket.sendall("\r\n".join(lines + ["", ""]).encode())
        head = self.until(b"\r\n\r\n")
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise Closed(head.split(b"\r\n")[0].decode())

    def more(self, timeout):
        if not select.select([self.socket], [], [], max(0.0, timeout))[0]:
            return False
        part = self.socket.recv(1 << 18)
        if not part:
            raise Closed("end")
        self.rest += part
        return True

    def until(self, mark):
        while mark not in self.rest:
            if not self.more(20):
                raise Closed("silence")
        head, _, self.rest = self.rest.partition(mark)
        return head

    def send(self, payload, opcode=1):
        head = bytes([0x80 | opcode])
        size = len(payload)
        if size < 126:
            head += bytes([0x80 | size])
        else:
            head += struct.pack(">BH", 0xFE, size) if size < 65536 else struct.pack(">BQ", 0xFF, size)
        self.socket.sendall(head + b"\0\0\0\0" + payload)  # a mask of nothing

    def say(self, **message):
        self.send(json.dumps(message).encode())

    def whole(self):
        """The next frame's opcode and payload, if all of it is there."""
        r = self.rest
        if len(r) < 2:
            return None
        size, at = r[1] & 127, 2
        if size == 126:
            size, at = int.from_bytes(r[2:4], "big"), 4
        elif size == 127:
            size, at = int.from_bytes(r[2:10], "big"), 10
        if len(r) < at or len(r) < at + size:
            return None
        self.rest = r[at + size:]
        return r[0] & 15, r[at:at + size]

    def read(self, timeout=20.0):
        """A message (dict), a picture (dict with "kind" and "file"), or None."""
        end = time.monotonic() + timeout
        while (frame := self.whole()) is None:
            if not self.more(end - time.monotonic()):
                return None
        opcode, payload = frame
        self.bytes += len(payload)
        if opcode == 8:
            raise Closed(payload[2:].decode())
        if opcode == 1:
            return json.loads(payload)
        if opcode != 2:
            return self.read(max(0.0, end - time.monotonic()))
        names = ("magic", "kind", "format", "index", "frame", "width", "height", "event")
        picture = dict(zip(names, struct.unpack("<4sBBHIHHQ", payload[:24])), file=payload[24:])
        if not self.slow:
            self.say(do="got", frame=picture["frame"])
        return picture

    def wait_for(self, what, timeout=60.0):
        """The next message or picture for which what(it) holds."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            it = self.read(end - time.monotonic())
            if it is not None and what(it):
                return it
        raise AssertionError("waited in vain")

    def close(self):
        self.socket.close()
