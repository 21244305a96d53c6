#include "voxelserver/http/archive_route.hpp"

#include <cinttypes>
#include <cstdio>

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

}  // namespace

Response answer_archive(const Service& service, const RouteRequest& call) {
    if (service.archive.empty())
        return problem(404, "the world of this server is no box archive of its machine");
    const std::optional<OpenFile> file = open_file(service.archive, true);
    if (!file)
        return problem(404, "the archive is gone, or cannot be read");
    return file_reply(call.request, *file, etag_of_file(*file), kType);
}

}  // namespace terravox::http
