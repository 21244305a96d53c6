"""Malformed requests and their allowed statuses; None is a closed connection without a reply."""


def health(*headers, body=b""):
    lines = [b"GET /healthz HTTP/1.1", b"Host: localhost", *headers, b"", b""]
    return b"\r\n".join(lines) + body


CLOSED = None

# name: (bytes, allowed statuses of the first reply, maximum number of replies)
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
