#include "voxelserver/serve/http/archive_route.hpp"

#include <cerrno>
#include <optional>

#include "voxelserver/serve/http/file_reply.hpp"

namespace terravox::http {
namespace {

constexpr const char* kType = "application/vnd.terravox.archive";

Response no_file(int why) {
    switch (why) {
        case ENOENT:
        case ENOTDIR:
        case EISDIR: return problem(404, "the archive is gone");
        case EMFILE:
        case ENFILE:
        case ENOMEM:
            return problem(503, "the server has too many files open").add("Retry-After", "1");
        default: return problem(500, "the archive cannot be read");
    }
}

}  // namespace

Response answer_archive(const Service& service, const RouteRequest& call) {
    if (service.archive.empty())
        return problem(404, "the world of this server is no box archive of its machine");
    const std::optional<OpenFile> file = open_file(service.archive, true);
    if (!file)
        return no_file(errno);
    return file_reply(call.request, *file, to_etag(*file), kType);
}

}  // namespace terravox::http
