"""HTTP by hand: bytes as they are on the wire, for requests that no client library would send."""

import json
import select
import socket
import time

from support import HANGS_S


class Reply:
    """One reply: status, headers (names in lower case, the last of each name), body."""

    def __init__(self, status, headers, body):
        self.status = status
        self.headers = headers
        self.body = body

    def problem(self):
        """Checks the form of an error. @return what is wrong with it, or an empty string"""
        kind = self.headers.get("content-type", "")
        if kind != "application/problem+json":
            return f"content type '{kind}'"
        try:
            said = json.loads(self.body)
        except ValueError:
            return f"no JSON: {self.body[:100]}"
        if said.get("status") != self.status or not said.get("title") or not said.get("detail"):
            return f"status, title or detail: {self.body[:200]}"
        return ""

    def __repr__(self):
        return f"{self.status} {self.body[:80]}"


class Talk:
    """What was received: the replies, the rest of the stream, and whether the server closed."""

    def __init__(self, data, closed, heads=()):
        self.replies = []
        self.closed = closed
        rest = data
        heads = list(heads)
        while rest:
            reply, rest = _first_reply(rest, heads.pop(0) if heads else False)
            if reply is None:
                break
            self.replies.append(reply)
        self.rest = rest

    def statuses(self):
        return [r.status for r in self.replies]

    def __repr__(self):
        return f"{self.replies} {'closed' if self.closed else 'open'} rest {self.rest[:80]}"


def _first_reply(data, to_head):
    end = data.find(b"\r\n\r\n")
    if not data.startswith(b"HTTP/1.1 ") or end < 0:
        return None, data
    lines = data[:end].decode("latin-1").split("\r\n")
    headers = {
        name.strip().lower(): value.strip()
        for name, _, value in (line.partition(":") for line in lines[1:])
    }
    status = int(lines[0][9:12])
    if headers.get("transfer-encoding") == "chunked" and not to_head:
        body, rest = _chunks(data[end + 4 :])
        return (None, data) if body is None else (Reply(status, headers, body), rest)
    length = 0 if to_head or status in (204, 304) else int(headers.get("content-length", "0"))
    if len(data) < end + 4 + length:
        return None, data
    return Reply(status, headers, data[end + 4 : end + 4 + length]), data[end + 4 + length :]


def _chunks(data):
    """@return the body that comes in chunks, and what is left; None when it is not whole"""
    body = b""
    while True:
        size, found, rest = data.partition(b"\r\n")
        if not found:
            return None, data
        n = int(size.split(b";")[0], 16)
        if len(rest) < n + 2:
            return None, data
        body += rest[:n]
        data = rest[n + 2 :]
        if n == 0:
            return body, data


def connect(port, timeout_s=HANGS_S):
    return socket.create_connection(("127.0.0.1", port), timeout=timeout_s)


def talk(port, data, quiet_s=0.3, half_close=False, heads=()):
    """Sends bytes and receives replies.

    @param quiet_s timeout without new bytes; a reply that has begun is waited for
    @param heads   for each reply: whether the request was HEAD
    """
    until = time.monotonic() + HANGS_S
    with connect(port) as connection:
        closed = _send(connection, data)
        if half_close and not closed:
            connection.shutdown(socket.SHUT_WR)
        got = b""
        while time.monotonic() < until:
            whole = got and not Talk(got, False, heads).rest
            if not select.select(
                [connection], [], [], quiet_s if whole else max(0, until - time.monotonic())
            )[0]:
                break
            try:
                more = connection.recv(1 << 16)
            except ConnectionError:
                more = b""
            if not more:
                return Talk(got, True, heads)
            got += more
        return Talk(got, closed, heads)


def _send(connection, data):
    """@return True when the server closed during sending; earlier replies may still be readable"""
    try:
        connection.sendall(data)
    except ConnectionError:
        return True
    return False


def get(path, *headers, method="GET", host="127.0.0.1"):
    """The bytes of a well-formed request."""
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host}", *headers, "", ""]
    return "\r\n".join(lines).encode("latin-1")
