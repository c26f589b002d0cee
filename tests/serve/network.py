#!/usr/bin/env python3
"""tests/serve/network.py PROGRAM: who is let in, what ends a connection, that slow viewers miss frames and
ten share them, and that what was closed is freed. Each test's name is what it shows."""
import json
import sys
import time

from visitor import Closed, Server, Visitor

PROGRAM = sys.argv[1]
CAMERA = {"do": "camera", "eye": [278, 273, -800], "target": [278, 273, 280]}


def ends(visitor, reason):
    try:
        while visitor.read(10) is not None:
            pass
    except Closed as closed:
        assert reason in str(closed), f"ends with {closed!r}, not {reason!r}"
        return
    raise AssertionError(f"goes on, without {reason!r}")


def let_in(*words, **options):
    """A visitor, or None."""
    try:
        return Visitor(*words, **options)
    except (Closed, ConnectionError):
        return None


def refused(*words, **options):
    assert not let_in(*words, **options), f"let in: {options}"


def eventually(holds, seconds=20):
    """Waits for what a busy machine may take a while to do."""
    end = time.monotonic() + seconds
    while not (good := holds()) and time.monotonic() < end:
        time.sleep(0.02)
    return good


def it_listens_at_the_loopback_address_alone(server):
    port = f":{int(server.host.rsplit(':')[-1]):04X}"
    places = []
    for table in ("tcp", "tcp6"):
        with open("/proc/net/" + table, encoding="ascii") as lines:
            fields = [line.split() for line in lines]
        places += [f[1] for f in fields if f[3] == "0A" and f[1].endswith(port)]
    assert places == ["0100007F" + port], places


def only_who_has_the_token_and_comes_from_the_page_is_let_in(server):
    refused(server, token="")
    refused(server, token=server.token[:-1] + ("0" if server.token[-1] != "0" else "1"))
    refused(server, origin="")
    refused(server, origin="http://localhost:1")
    refused(server, origin="https://" + server.host)
    refused(server, path="/other")
    Visitor(server).close()


def names_that_others_could_give_the_machine_are_refused(server):
    port = server.host.rsplit(":")[-1]
    for host in ("evil.example:" + port, "127.0.0.1.evil.example:" + port, "127.0.0.1:1", "127.0.0.1",
                 "localhost.x:" + port):
        assert server.fetch("/", host=host)[0] == 403, host
    for host in ("localhost:" + port, "127.0.0.1:" + port):
        assert server.fetch("/", host=host)[0] == 200, host
    assert server.fetch("/", origin="http://evil.example")[0] == 403


def pages_say_what_a_browser_may_do_with_them(server):
    status, head, body = server.fetch("/")
    assert status == 200 and b"<html" in body
    for line in ("content-security-policy: default-src 'self'", "referrer-policy: no-referrer",
                 "x-frame-options: DENY", "x-content-type-options: nosniff", "cache-control: no-store"):
        assert line in head, line
    assert server.token not in head + body.decode()
    assert server.fetch("/../etc/passwd")[0] in (403, 404) and server.fetch("/none")[0] == 404
    assert server.fetch("/kept/0")[0] == 403 and server.fetch(f"/kept/{server.token}/0")[0] == 404
    assert server.fetch(f"/kept/{server.token}/../../etc/passwd")[0] in (403, 404)


def what_is_malformed_ends_that_connection_alone(server):
    other = Visitor(server)
    for payload, reason in ((b"[]", "no JSON object"), (b"{", "no JSON object"),
                            (b'{"do":1}', "no JSON object"), (b'{"do":"nothing"}', "nothing of that name"),
                            (b'{"do":"x","a":[[[[[[[1]]]]]]]}', "too deep"),
                            (b'{"do":"' + b"x" * 17000 + b'"}', "too long"),
                            (b'{"do":"got"}', "a frame's number"),
                            (b'{"do":"camera","eye":[1,2]}', "eye")):
        visitor = Visitor(server)
        visitor.send(payload)
        ends(visitor, reason)
    visitor = Visitor(server)
    visitor.send(b"{}", opcode=2)
    ends(visitor, "expected text")
    other.say(**CAMERA)
    other.wait_for(lambda m: m.get("is") == "did")
    other.close()


def too_many_messages_end_the_connection(server):
    visitor = Visitor(server)
    try:
        for _ in range(1000):
            visitor.say(do="pick", x=1, y=1)
            visitor.read(0)  # answers that are left unread end it, too
        ends(visitor, "too many messages")
    except OSError:
        return
    except Closed as closed:
        assert "too many messages" in str(closed), f"ends with {closed!r}"


def no_more_than_sixteen_are_let_in_and_those_who_leave_make_room(server):
    visitors = [eventually(lambda: let_in(server)) for _ in range(16)]
    refused(server)
    visitors.pop().close()
    visitors.append(eventually(lambda: let_in(server)))
    assert all(visitors)
    for visitor in visitors:
        visitor.close()


def a_viewer_that_does_not_read_gets_fewer_frames_and_no_queue(server):
    lively, slow = Visitor(server), Visitor(server, slow=True)
    frames = {lively: [], slow: []}
    for i in range(60):
        lively.say(**{**CAMERA, "eye": [278 + i % 7, 273, -800]})
        for visitor, timeout in ((lively, 0.04), (slow, 0.0)):
            while (message := visitor.read(timeout)) is not None:
                if "file" in message:
                    frames[visitor].append(message["frame"])
    assert len(frames[slow]) == 2 and len(frames[lively]) > 10, [len(f) for f in frames.values()]
    slow.say(do="got", frame=frames[slow][-1])
    late = slow.wait_for(lambda m: "file" in m)
    assert late["frame"] >= frames[lively][-1] - 1, "what it gets then is the newest"
    lively.close()
    slow.close()


def ten_viewers_share_one_frame(server):
    visitors = [Visitor(server) for _ in range(10)]
    for visitor in visitors:
        visitor.wait_for(lambda m: m.get("is") == "hello")
    visitors[0].say(**CAMERA)
    event = visitors[0].wait_for(lambda m: m.get("is") == "did")["event"]
    pictures = [v.wait_for(lambda m: "file" in m and m["event"] >= event and m["format"] == 1)
                for v in visitors]
    assert len({p["file"] for p in pictures}) == 1 and len({p["frame"] for p in pictures}) == 1
    for visitor in visitors:
        visitor.close()


def what_was_closed_is_freed(server):
    def visit():
        visitor = Visitor(server)
        visitor.wait_for(lambda m: "file" in m)
        visitor.close()
    for _ in range(10):
        visit()
    time.sleep(0.5)
    descriptors, memory = server.descriptors(), server.memory_kib()
    for _ in range(100):
        visit()
    assert eventually(lambda: server.descriptors() <= descriptors), (descriptors, server.descriptors())
    assert server.memory_kib() < memory + 8192, (memory, server.memory_kib())


def main():
    server = Server(PROGRAM, "scenes/cornell.json", "-s", "64x64", "-m", "direct-radiance", "--quiet")
    failed = 0
    for test in (it_listens_at_the_loopback_address_alone,
                 only_who_has_the_token_and_comes_from_the_page_is_let_in,
                 names_that_others_could_give_the_machine_are_refused,
                 pages_say_what_a_browser_may_do_with_them, what_is_malformed_ends_that_connection_alone,
                 too_many_messages_end_the_connection,
                 no_more_than_sixteen_are_let_in_and_those_who_leave_make_room,
                 a_viewer_that_does_not_read_gets_fewer_frames_and_no_queue, ten_viewers_share_one_frame,
                 what_was_closed_is_freed):
        try:
            test(server)
            print(f"[       OK ] {test.__name__}", flush=True)
        except (AssertionError, OSError, Closed, json.JSONDecodeError) as error:
            failed += 1
            print(f"[  FAILED  ] {test.__name__}: {error}", flush=True)
    status = server.stop()
    assert status == 0 and not failed, f"{failed} failed, status {status}"


main()
