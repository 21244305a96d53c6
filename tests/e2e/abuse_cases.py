"""Malformed requests and their allowed statuses; None is a closed connection without a reply."""

import random

from wire import get

HOST = b"Host: localhost\r\n"


def line(start, *headers, body=b""):
    return start + b"\r\n" + HOST + b"".join(h + b"\r\n" for h in headers) + b"\r\n" + body


def health(*headers, body=b""):
    return line(b"GET /healthz HTTP/1.1", *headers, body=body)


CLOSED = None

# name: (bytes, allowed statuses of the first reply, maximum number of replies)
REQUEST_LINES = {
    "as it should be": (health(), [200], 1),
    "a lone query mark": (get("/healthz?"), [200, 400], 1),
    "an odd query": (get("/healthz?a=b&a=c&%%%&=&"), [200, 400], 1),
    "HTTP/1.0": (b"GET /healthz HTTP/1.0\r\n\r\n", [200], 1),
    "HTTP/0.9": (b"GET /healthz\r\n\r\n", [400, CLOSED], 1),
    "HTTP/1.2": (line(b"GET /healthz HTTP/1.2"), [200, 505], 1),
    "HTTP/3.0": (line(b"GET /healthz HTTP/3.0"), [400, 505], 1),
    "another protocol": (line(b"GET /healthz HTTQ/1.1"), [400, CLOSED], 1),
    "HTTP/2 preface": (
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0",
        [400, 505, CLOSED],
        1,
    ),
    "TLS hello": (bytes.fromhex("16030100c8010000c403033f") + b"\x11" * 190, [400, CLOSED], 1),
    "requests HTTP/2": (
        health(
            b"Connection: Upgrade, HTTP2-Settings",
            b"Upgrade: h2c",
            b"HTTP2-Settings: AAMAAABkAARAAAAAAAIAAAAA",
        ),
        [200],
        1,
    ),
    "requests a web socket": (
        health(
            b"Connection: Upgrade",
            b"Upgrade: websocket",
            b"Sec-WebSocket-Version: 13",
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZQ==",
        ),
        [200, 400, 404],
        1,
    ),
    "line feeds alone": (b"GET /healthz HTTP/1.1\nHost: localhost\n\n", [200, 400], 1),
    "an empty line first": (b"\r\n" + health(), [200, 400], 1),
    "nothing but empty lines": (b"\r\n\r\n\r\n", [400, CLOSED], 1),
    "a blank first": (b" " + health(), [200, 400], 1),
    "two blanks": (line(b"GET  /healthz  HTTP/1.1"), [200, 400], 1),
    "tabs": (line(b"GET\t/healthz\tHTTP/1.1"), [400, CLOSED], 1),
    "a fourth word": (line(b"GET /healthz extra HTTP/1.1"), [400, CLOSED], 1),
    "NUL in the path": (line(b"GET /heal\0thz HTTP/1.1"), [400, CLOSED], 1),
    "a control character": (line(b"GET /a\x01\x7f HTTP/1.1"), [400, CLOSED], 1),
    "bytes beyond ASCII": (line(b"GET /\xff\xfe\x80 HTTP/1.1"), [400, 404], 1),
    "an escaped NUL": (get("/healthz%00"), [400, 404], 1),
    "an anchor": (get("/healthz#x"), [400, 404], 1),
    "no slash": (line(b"GET healthz HTTP/1.1"), [400, CLOSED], 1),
    "absolute form": (line(b"GET http://x/healthz HTTP/1.1"), [200, 400, CLOSED], 1),
    "absolute form, another scheme": (line(b"GET ftp://x/healthz HTTP/1.1"), [400, CLOSED], 1),
    "OPTIONS *": (line(b"OPTIONS * HTTP/1.1"), [204, 400, 405, CLOSED], 1),
    "GET *": (line(b"GET * HTTP/1.1"), [400, CLOSED], 1),
    "CONNECT": (line(b"CONNECT x:80 HTTP/1.1"), [400, 405, CLOSED], 1),
    "TRACE": (line(b"TRACE /healthz HTTP/1.1"), [400, 405, CLOSED], 1),
    "an unknown method": (line(b"BREW /healthz HTTP/1.1"), [400, 405, 501], 1),
    "a method in small letters": (line(b"get /healthz HTTP/1.1"), [400, 405, 501], 1),
    "DELETE": (line(b"DELETE /healthz HTTP/1.1"), [405], 1),
    "PUT": (line(b"PUT /healthz HTTP/1.1", b"Content-Length: 3", body=b"abc"), [405, 413], 1),
    "POST where there is none": (
        line(b"POST /healthz HTTP/1.1", b"Content-Length: 3", body=b"abc"),
        [405, 413],
        1,
    ),
    "an address of 15 KB": (get("/" + "a" * 15000), [404, 414], 1),
    "an address of 100 KB": (get("/" + "a" * 100_000), [400, 414, 431], 1),
    "three requests at once": (get("/healthz") + get("/v2/world") + get("/nothing"), [200], 3),
}

# Everything that could make two servers see two requests where there is one.
BODIES = {
    "no Host": (b"GET /healthz HTTP/1.1\r\n\r\n", [200, 400], 1),
    "two Hosts": (health(b"Host: y"), [200, 400], 1),
    "the same Host twice": (health(b"Host: localhost"), [400], 1),
    "a header of 100 KB": (health(b"A: " + b"a" * 100_000), [400, 431], 1),
    "200 headers": (health(*(b"A%d: b" % i for i in range(200))), [431], 1),
    "a header without a colon": (health(b"Junk"), [400, CLOSED], 1),
    "a header without a name": (health(b": x"), [200, 400], 1),
    "NUL in a header": (health(b"A: b\0c"), [400, CLOSED], 1),
    "a folded header": (health(b"X: y", b" z"), [200, 400], 1),
    "Transfer-Encoding in a fold": (
        health(b"X: y", b" Transfer-Encoding: chunked", body=b"0\r\n\r\n"),
        [200, 400],
        2,
    ),
    "Content-Length 10^12": (health(b"Content-Length: 1000000000000"), [413], 1),
    "Content-Length 2^64": (health(b"Content-Length: 18446744073709551616"), [400, 413], 1),
    "Content-Length -1": (health(b"Content-Length: -1"), [400, 411], 1),
    "Content-Length +0": (health(b"Content-Length: +0"), [400], 1),
    "Content-Length 0x0": (health(b"Content-Length: 0x0"), [400], 1),
    "Content-Length of nothing": (health(b"Content-Length:"), [400, 411], 1),
    "Content-Length 0": (health(b"Content-Length: 0"), [200], 1),
    "the same Content-Length twice": (
        health(b"Content-Length: 0", b"Content-Length: 0"),
        [200, 400],
        1,
    ),
    "two Content-Lengths": (
        health(b"Content-Length: 0", b"Content-Length: 5", body=b"GET /"),
        [400, 413],
        1,
    ),
    "two in one Content-Length": (health(b"Content-Length: 0, 5", body=b"GET /"), [400, 413], 1),
    "a blank before the colon": (health(b"Content-Length : 5", body=b"GET /"), [400, 413], 1),
    "chunked": (health(b"Transfer-Encoding: chunked", body=b"0\r\n\r\n"), [400, 411, 413], 1),
    "chunked and a length": (
        health(b"Content-Length: 6", b"Transfer-Encoding: chunked", body=b"0\r\n\r\nG"),
        [400],
        1,
    ),
    "chunked twice": (
        health(b"Transfer-Encoding: chunked", b"Transfer-Encoding: identity", body=b"0\r\n\r\n"),
        [400, 413],
        1,
    ),
    "chunked, misspelt": (health(b"Transfer-Encoding: xchunked", body=b"0\r\n\r\n"), [400, 501], 1),
    "chunked, a blank before the colon": (
        health(b"Transfer-Encoding : chunked", body=b"0\r\n\r\n"),
        [400],
        1,
    ),
    "chunked, behind a tab": (
        health(b"Transfer-Encoding:\tchunked", body=b"0\r\n\r\n"),
        [400, 411, 413],
        1,
    ),
    "chunked, behind a vertical tab": (
        health(b"\x0bTransfer-Encoding: chunked", body=b"0\r\n\r\n"),
        [400],
        1,
    ),
    "chunked, behind a bare carriage return": (
        health(b"X: a\rTransfer-Encoding: chunked", body=b"0\r\n\r\n"),
        [400],
        1,
    ),
    "chunked, behind a bare line feed": (
        health(b"X: a\nTransfer-Encoding: chunked", body=b"0\r\n\r\n"),
        [400, 411, 413],
        1,
    ),
    "identity": (health(b"Transfer-Encoding: identity"), [200, 400], 1),
    "waits for a go-ahead": (health(b"Expect: 100-continue", b"Content-Length: 5"), [413, 417], 1),
    "expects what there is not": (health(b"Expect: banana"), [200, 417], 1),
}

# Headers that contradict the request, and values that none of them has.
_HEADERS = [b"Content-Length: ", b"Transfer-Encoding: ", b"Connection: ", b"Expect: "]
_HEADERS += [b"If-None-Match: ", b"Host: ", b"Range: "]
_VALUES = [b"-1", b"99999999999999999999", b"chunked", b"*", b'W/"', b"\xff", b"0,0", b""]
_VALUES += [b"close, close", b"bytes=9-1,-0"]


def damaged(random_numbers, good):
    """One seeded malformed request.

    A good one with its line cut, bytes changed, parts doubled or ends missing, or no request at
    all.
    """
    data = bytearray(random_numbers.choice(good))
    kind = random_numbers.randrange(8)
    if kind == 0:
        data = data[: random_numbers.randrange(1, len(data))]
    elif kind == 1:
        for _ in range(random_numbers.randrange(1, 9)):
            data[random_numbers.randrange(len(data))] = random_numbers.randrange(256)
    elif kind == 2:
        at = random_numbers.randrange(len(data))
        data[at:at] = bytes(
            random_numbers.randrange(256) for _ in range(random_numbers.randrange(1, 200))
        )
    elif kind == 3:
        words = bytes(data).split(b" ")
        random_numbers.shuffle(words)
        data = bytearray(b" ".join(words))
    elif kind == 4:
        data = bytearray(random_numbers.randbytes(random_numbers.randrange(1, 3000)))
    elif kind == 5:
        data = bytearray(
            bytes(data).replace(
                b"\r\n", random_numbers.choice([b"\n", b"\r", b"\r\r\n", b"\n\r", b"\0\n"])
            )
        )
    elif kind == 6:
        a, b = sorted(random_numbers.randrange(len(data)) for _ in range(2))
        data[b:b] = data[a:b] * random_numbers.randrange(1, 40)
    else:
        header = random_numbers.choice(_HEADERS)
        value = random_numbers.choice(_VALUES)
        data[-2:-2] = (header + value + b"\r\n") * random_numbers.randrange(1, 70)
    return bytes(data)


def path_tricks(count, seed):
    """Addresses that try to leave whatever folder a server might serve."""
    numbers = random.Random(seed)
    ups = ["../", "..%2f", "%2e%2e%2f", "..\\", "%252e%252e%252f", "..;/", ".%00./"]
    ups += ["..%c0%af", "....//", ".././"]
    starts = ["/", "//", "/v2/boxes/0/", "/map/0/", "/page/", "/gkot/", "/./", "/page/x/"]
    starts += ["/%2f", "/page//", "/file:/", "/~root/"]
    goals = ["etc/passwd", "proc/self/environ", "canary.txt", "survey/canary.txt"]
    goals += ["etc/passwd%00.png", "etc/passwd?x", "etc//passwd", "/etc/passwd", "CANARY.TXT"]
    return [
        numbers.choice(starts)
        + "".join(numbers.choice(ups) for _ in range(numbers.randrange(0, 12)))
        + numbers.choice(goals)
        for _ in range(count)
    ]
