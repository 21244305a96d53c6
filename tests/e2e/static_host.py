"""A static web host as there are many, and what may go wrong with one."""

import gzip
import os
import pathlib
import re
import ssl
import threading
import time
from email.utils import formatdate
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".json": "application/json",
    ".jpg": "image/jpeg",
    ".txt": "text/plain",
}
# What hosts compress for clients that accept it: texts, and never a range of them.
COMPRESSED = {".html", ".js", ".css", ".json", ".txt"}
STEP_BYTES = 16384


class StaticHost:
    """Serves files on a port of its own, and counts requests and bytes of bodies.

    Ranges, entity tags, dates, and gzip for texts. Everything below may be changed while it runs.

    files: a folder, or the bytes of each file by name
    compresses: whether texts are compressed for clients that accept it
    answers_ranges: otherwise each reply is the whole file
    etag: instead of one made of size and date; "": none
    is_bare: ranges come without Content-Range, as of the simplest hosts
    bytes_per_s: of each connection; 0: no limit
    fails: called with the name of a file and its range (None: all of it); what it returns, a status
        or None, is the reply instead of the file
    before: called with the host before each request, to change it
    headers: of every reply, in addition to those of the file
    certificate: a folder of certificate.self_signed(): the host speaks TLS
    """

    def __init__(
        self,
        files,
        *,
        compresses=True,
        answers_ranges=True,
        etag=None,
        is_bare=False,
        bytes_per_s=0,
        fails=None,
        before=None,
        headers=None,
        certificate=None,
    ):
        self.files = files if isinstance(files, dict) else pathlib.Path(files)
        self.compresses = compresses
        self.answers_ranges = answers_ranges
        self.etag = etag
        self.is_bare = is_bare
        self.bytes_per_s = bytes_per_s
        self.fails = fails
        self.before = before
        self.headers = headers or {}
        self.requests = self.sent = 0
        self.log = []  # (name, range or None, status, bytes of the body)
        self.authorizations = set()  # what requests had in their header, None: nothing
        self.lock = threading.Lock()
        self.server = _Server(("127.0.0.1", 0), _handler(self))
        if certificate is not None:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(certificate / "both.pem")
            # Handshakes are made by the threads of the connections: the first read begins them.
            self.server.socket = context.wrap_socket(
                self.server.socket, server_side=True, do_handshake_on_connect=False
            )
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        scheme = "http" if certificate is None else "https"
        self.url = f"{scheme}://127.0.0.1:{self.server.server_port}/"

    def stop(self):
        self.server.shutdown()
        self.server.server_close()

    def find(self, name):
        """@return bytes of a file, or None, and its headers"""
        if isinstance(self.files, dict):
            data = self.files.get(name)
            return data, {} if self.etag is None else self._tag()
        file = self.files / name
        if not file.is_file() or not file.resolve().is_relative_to(self.files.resolve()):
            return None, {}
        # Opened first: tag and bytes are those of one file, also when it is replaced meanwhile.
        opened = _File(file)
        status = os.fstat(opened.number)
        own = {"ETag": f'"{status.st_size}-{status.st_mtime_ns}"'}
        headers = own if self.etag is None else self._tag()
        headers["Last-Modified"] = formatdate(status.st_mtime, usegmt=True)
        return opened, headers

    def _tag(self):
        return {"ETag": self.etag} if self.etag else {}


class _File:
    """A file as bytes that are read when they are needed: archives may be larger than memory."""

    def __init__(self, path):
        self.number = os.open(path, os.O_RDONLY | os.O_CLOEXEC)

    def __del__(self):
        os.close(self.number)

    def __len__(self):
        return os.fstat(self.number).st_size

    def __getitem__(self, part):
        first, end, _ = part.indices(len(self))
        read = bytearray()
        while first + len(read) < end:
            some = os.pread(self.number, end - first - len(read), first + len(read))
            if not some:
                break
            read += some
        return bytes(read)


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request, client_address):
        """Browsers cancel requests; what else fails shows in the test."""


def _handler(host):
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        # Otherwise each reply waits 40 ms for an acknowledgement of its head.
        disable_nagle_algorithm = True

        def do_GET(self):
            name = self.path.split("?")[0].lstrip("/") or "index.html"
            asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
            part = (int(asked[1]), int(asked[2]) if asked[2] else None) if asked else None
            host.authorizations.add(self.headers.get("Authorization"))
            if host.before is not None:
                host.before(host)
            failure = host.fails(name, part) if host.fails is not None else None
            data, headers = host.find(name)
            if failure is not None or data is None:
                self.reply(name, part, failure or 404, {}, b"")
                return
            headers["Content-Type"] = TYPES.get(
                pathlib.Path(name).suffix, "application/octet-stream"
            )
            if part is not None and host.answers_ranges:
                self.reply_part(name, part, data, headers)
            else:
                self.reply_whole(name, part, data, headers)

        def reply_part(self, name, part, data, headers):
            first, last = part[0], len(data) - 1 if part[1] is None else part[1]
            last = min(last, len(data) - 1)
            if first > last:
                self.reply(name, part, 416, {"Content-Range": f"bytes */{len(data)}"}, b"")
                return
            if not host.is_bare:
                headers["Content-Range"] = f"bytes {first}-{last}/{len(data)}"
            self.reply(name, part, 206, headers, data[first : last + 1])

        def reply_whole(self, name, part, data, headers):
            body = data[0 : len(data)]
            if host.answers_ranges:
                headers["Accept-Ranges"] = "bytes"
            accepts = "gzip" in self.headers.get("Accept-Encoding", "")
            if host.compresses and accepts and pathlib.Path(name).suffix in COMPRESSED:
                body = gzip.compress(body, 6, mtime=0)
                headers["Content-Encoding"] = "gzip"
                headers["Vary"] = "Accept-Encoding"
                # The bytes of the compressed body differ from those that the tag stands for.
                if "ETag" in headers:
                    headers["ETag"] = "W/" + headers["ETag"]
            self.reply(name, part, 200, headers, body)

        def reply(self, name, part, status, headers, body):
            with host.lock:
                host.requests += 1
                host.sent += len(body)
                host.log.append((name, part, status, len(body)))
            self.send_response(status)
            for header, value in {**headers, **host.headers}.items():
                self.send_header(header, value)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            for at in range(0, len(body), STEP_BYTES):
                piece = body[at : at + STEP_BYTES]
                self.wfile.write(piece)
                if host.bytes_per_s > 0:
                    time.sleep(len(piece) / host.bytes_per_s)

        def log_message(self, *_):
            pass

    return Handler
