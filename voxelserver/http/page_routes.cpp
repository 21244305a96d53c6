#include "voxelserver/http/page_routes.hpp"

#include <xxhash.h>

#include "voxelserver/page/assets.hpp"

namespace terravox::http {
namespace {

// The page loads nothing from other origins, and must not be embedded in other pages. Map tiles are
// loaded as blobs where there is a token.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' "
    "blob: data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

// Bytes compiled into the program: their tag changes only with the program.
Response fixed(std::string_view content_type, std::string_view bytes, const Request& request) {
    const std::string etag = etag_of(XXH64(bytes.data(), bytes.size(), 0), "p");
    if (etag_matches(request.header("If-None-Match"), etag))
        return not_modified(etag);
    Response out;
    out.add("Content-Type", content_type);
    add_validators(out, etag);
    out.fixed_body = bytes;
    return out;
}

}  // namespace

Response answer_page(const RouteRequest& call) {
    const std::string_view name =
        call.parts.count == 1 ? std::string_view("index.html") : call.parts.part[1];
    const page::Asset* asset = page::find(name);
    if (asset == nullptr)
        return problem(404, "the page has no file " + std::string(name));
    Response out = fixed(asset->content_type, asset->bytes, call.request);
    return out.add("Content-Security-Policy", kPolicy)
        .add("Referrer-Policy", "no-referrer")
        .add("Cross-Origin-Opener-Policy", "same-origin");
}

Response answer_open_api(const RouteRequest& call) {
    return fixed("application/json", page::open_api(), call.request);
}

}  // namespace terravox::http
