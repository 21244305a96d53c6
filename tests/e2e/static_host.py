"""A static web host as there are many: files of a folder, ranges, entity tags; no code."""

import re
import threading
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


class StaticHost:
    """Serves a folder on a port of its own, and counts requests and bytes."""

    def __init__(self, folder):
        outer = self
        self.requests = self.sent = 0
        self.lock = threading.Lock()

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            disable_nagle_algorithm = True

            def do_GET(self):
                name = self.path.split("?")[0].lstrip("/") or "index.html"
                file = folder / name
                if not file.is_file() or folder.resolve() not in file.resolve().parents:
                    self.reply(404, {}, b"")
                    return
                data = file.read_bytes()
                status = file.stat()
                headers = {
                    "Content-Type": TYPES.get(file.suffix, "application/octet-stream"),
                    "ETag": f'"{status.st_size}-{status.st_mtime_ns}"',
                    "Last-Modified": formatdate(status.st_mtime, usegmt=True),
                    "Accept-Ranges": "bytes",
                }
                asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
                if not asked:
                    self.reply(200, headers, data)
                    return
                first = int(asked[1])
                last = min(int(asked[2] or len(data) - 1), len(data) - 1)
                if first > last:
                    self.reply(416, {"Content-Range": f"bytes */{len(data)}"}, b"")
                    return
                headers["Content-Range"] = f"bytes {first}-{last}/{len(data)}"
                self.reply(206, headers, data[first : last + 1])

            def reply(self, status, headers, body):
                with outer.lock:
                    outer.requests += 1
                    outer.sent += len(body)
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.server.server_port}/"

    def stop(self):
        self.server.shutdown()
        self.server.server_close()
