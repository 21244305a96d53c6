#include "voxelserver/serve/http/route_answers.hpp"

#include <xxhash.h>

#include <algorithm>

#include "voxelserver/serve/page/assets.hpp"

namespace terravox::http {
namespace {

// Bytes compiled into the program: their tag changes only with the program.
Response fixed(std::string_view content_type, std::string_view bytes, const Request& request) {
    const std::string etag = make_etag(XXH64(bytes.data(), bytes.size(), 0), "p");
    if (etag_matches(request.header("If-None-Match"), etag))
        return not_modified(etag);
    Response out;
    out.add("Content-Type", content_type);
    add_validators(out, etag);
    out.fixed_body = bytes;
    return out;
}

Response answer_asset(std::string_view name, const Request& request) {
    const page::Asset* asset = page::find(name);
    if (asset == nullptr)
        return problem(404, "the page has no file " + std::string(name));
    return add_page_headers(fixed(asset->content_type, asset->bytes, request));
}

}  // namespace

Response add_page_headers(Response out, std::string_view archive_origin) {
    std::string connections = "'self'";
    if (!archive_origin.empty())
        connections.append(" ").append(archive_origin);
    // Map tiles are loaded as blobs where there is a token.
    return out
        .add("Content-Security-Policy",
             "default-src 'none'; script-src 'self'; style-src 'self'; connect-src " + connections +
                 "; img-src 'self' blob: data:; frame-ancestors 'none'; base-uri 'none'; "
                 "form-action 'none'")
        .add("Referrer-Policy", "no-referrer")
        .add("Cross-Origin-Opener-Policy", "same-origin");
}

Response answer_page(const RouteRequest& call) {
    return answer_asset(call.parts.count == 1 ? std::string_view("index.html") : call.parts.part[1],
                        call.request);
}

// Relative to the request, so that a proxy may add a path.
Response redirect_to_viewer() {
    Response out = reply(308, "text/plain; charset=utf-8", "view/\n");
    return out.add("Location", "view/").add("Cache-Control", "no-store");
}

Response answer_viewer(const RouteRequest& call) {
    if (call.parts.count == 2)
        return answer_asset("viewer.html", call.request);
    const std::string_view name = call.parts.part[2];
    const auto& files = page::kViewerFiles;
    if (std::find(files.begin(), files.end(), name) == files.end())
        return problem(404, "the viewer has no file " + std::string(name));
    return answer_asset(name, call.request);
}

Response answer_appearance(const RouteRequest& call) {
    return fixed("application/octet-stream", page::default_appearance(), call.request);
}

Response answer_open_api(const RouteRequest& call) {
    return fixed("application/json", page::open_api(), call.request);
}

}  // namespace terravox::http
