#include "voxelserver/http/archive_route.hpp"

#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <optional>

#include "voxelserver/http/file_reply.hpp"

namespace terravox::http {
namespace {

constexpr const char* kType = "application/vnd.terravox.archive";

std::string etag_of_file(const OpenFile& file) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "\"%" PRIx64 "-%" PRIx64 "\"", file.bytes,
                  static_cast<std::uint64_t>(file.changed_ns));
    return text.data();
}

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
    return file_reply(call.request, *file, etag_of_file(*file), kType);
}

}  // namespace terravox::http
